//! `share.*`: path space filtering [Keller, Dahm and Binder 2014]. Collection points share the indirect light that their camera paths
//! found.
//!
//! Each camera path leaves a sample Y at its collection point: the indirect light that a white diffuse surface there would show. A
//! point takes the mean of the samples within a radius on its own surface. In the image, T a Y becomes T a mean(Y). T is the
//! throughput of the prefix, and a the albedo of the point's diffuse lobes. The difference is added to what the path found. Direct
//! light, light of other lobes, and light before the point remain as they are. Points are found in world space: one that is seen in a
//! mirror takes samples of those that are seen directly.
//!
//! Bounces stay exact. Behind a point of camera vertex d, light may have `max_bounces` - d scatterings. A sample therefore has several
//! values: one for points of its own depth, and one each for points up to three vertices deeper. These take light of fewer
//! scatterings. A point takes no samples of deeper points: these lack light. Paths that found nothing leave a zero, which counts.
//!
//! Sums are integers, whose quantum is a power of two below the largest sample of the frame: no sample is clamped. The index has a
//! grid for each power of two of the radius, as the gather `points-grid`. A point searches the grids of its own radius, of half and of
//! twice that.
//!
//! Cost: an index over the points, and a search of some 50 samples a pixel. Limitations: light is blurred within the radius, also
//! across the edges of shadows of indirect light. A thin wall that stands on a floor shares no light with its other side, but the
//! floor does. Only diffuse lobes share. Points whose color lacks a channel neither give nor take. A tile of an image takes samples of
//! its own pixels alone.

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{FrameStage, Step};
use crate::gather::contribution::{DISC_THICKNESS, MIN_NORMAL_COS, Receiver, disc_half_extent};
use crate::gather::hash::{RADIUS_BINS, Runs, cell, cell_size_of, radius_bin, reserve_block, slot};
use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::frame::{Dispatch, FrameParams};
use crate::interface::material::Material;
use crate::interface::packed::from_rgbe;
use crate::interface::point::{IndirectSample, PointGeometry, PointShading, SharedLight, SharingPoint};
use crate::math::quanta::Quanta;
use crate::platform::{AtomicWords, Atomics, Slots, Words};
use crate::surface::textured::material_of;
use spirv_std::glam::Vec3;

/// Stage that shares indirect light between collection points.
#[cfg(not(target_arch = "spirv"))]
pub const SHARE: FrameStage = FrameStage {
    before_display: |params| {
        // Skip frames in which hardly any disc holds another point.
        if params.share_radius_px < MIN_RADIUS_PX {
            return Vec::new();
        }
        vec![
            Step::Clear { buffer: "share_levels" },
            Step::Clear { buffer: "share_counts" },
            Step::level(&SHARE_INDEX, COUNT, params.pixel_count()),
            Step::level(&SHARE_INDEX, RESERVE, cell_mask(params) + 1),
            Step::level(&SHARE_INDEX, FILL, params.pixel_count()),
            Step::level(&SHARE_LARGEST, 0, params.height),
            Step::level(&SHARE_LARGEST, 1, 1),
            Step::new(&SHARE_GATHER, params),
        ]
    },
    reads_indirect: true,
    ..FrameStage::new("share")
};

/// Radius of the first frame, relative to the disc of a pixel's footprint area.
pub const SHARE_RADIUS_PX: f32 = 4.0;
/// Radius below which points share nothing.
#[cfg(not(target_arch = "spirv"))]
const MIN_RADIUS_PX: f32 = 0.9;
/// Stages of the index.
const COUNT: u32 = 0;
const RESERVE: u32 = 1;
const FILL: u32 = 2;
/// Base-two logarithm of the largest sample over the quantum.
const LARGEST_LOG2: u32 = 30;
/// Largest number of camera vertices by which a point that takes a sample may be deeper than the point that gives it.
const MAX_DEEPER: u32 = 3;

/// Number of cells of the index minus one (a power of two minus one).
#[inline(always)]
pub fn cell_mask(params: &FrameParams) -> u32 {
    u32::MAX >> params.pixel_count().leading_zeros()
}

/// Radius within which a point takes samples (m).
#[inline(always)]
fn share_radius(point: &PointGeometry, params: &FrameParams) -> f32 {
    point.radius * (params.share_radius_px / params.radius_px)
}

/// Edge of a cell of a level (m): between the radius and its double.
#[inline(always)]
fn cell_size(level: u32) -> f32 {
    cell_size_of(level) * 0.5
}

/// Salt of the cells of a level, which separates the levels in the hash table.
#[inline(always)]
fn salt(level: u32) -> u32 {
    level.wrapping_mul(0x27d4_eb2f)
}

/// Builds the index over the points that give samples, one stage a dispatch.
#[pass(name = "share.index", over = 0, work = Index)]
pub fn share_index(
    index: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    pixel_order: &[u32],
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    point_indirect: &[IndirectSample],
    #[len = RADIUS_BINS] mut share_levels: AtomicWords<'_>,
    #[len = cell_mask(params) + 2] mut share_counts: AtomicWords<'_>,
    #[len = 2 * (cell_mask(params) + 1)] mut share_ranges: AtomicWords<'_>,
    #[len = params.pixel_count()] mut sharing_points: Slots<'_, SharingPoint>,
    #[len = params.pixel_count()] mut shared_light: Slots<'_, SharedLight>,
) {
    let mask = cell_mask(params);
    if dispatch.level == RESERVE {
        reserve_block(index, mask, &mut share_counts, &mut share_ranges);
        return;
    }
    let pixel = pixel_order[index as usize];
    let point = point_geometry[pixel as usize];
    let sample = point_indirect[pixel as usize];
    if !point.exists() || sample.light[0] == NONE {
        return;
    }
    let level = radius_bin(share_radius(&point, params));
    let slot = slot(cell(point.position, cell_size(level)), salt(level), mask);
    if dispatch.level == COUNT {
        share_levels.set(level, 1);
        share_counts.add(slot, 1);
    }
    if dispatch.level == FILL {
        // Take the next entry of the slot. The order in a cell is free, because sums are integers.
        let to = share_ranges.add(2 * slot + 1, 1);
        let shading = &point_shading[pixel as usize];
        let depth_and_level = point.depth | level << 16;
        sharing_points.write(to, SharingPoint { position: point.position, depth_and_level });
        let PointShading { shading_normal, material, .. } = *shading;
        shared_light.write(to, SharedLight { shading_normal, material, sample });
    }
}

/// Largest sample of each row. Level 1 makes that of the image.
#[pass(name = "share.largest", over = params.height, work = Guide)]
pub fn share_largest(
    row: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    point_indirect: &[IndirectSample],
    #[len = params.height + 1] mut largest_samples: Slots<'_, f32>,
) {
    let mut largest = 0.0f32;
    let mut index = 0;
    if dispatch.level == 0 {
        while index < params.width {
            let light = point_indirect[(row * params.width + index) as usize].light[0];
            if light != NONE {
                largest = largest.max(from_rgbe(light).max_element());
            }
            index += 1;
        }
        largest_samples.write(row, largest);
    } else {
        while index < params.height {
            largest = largest.max(largest_samples.read(index));
            index += 1;
        }
        largest_samples.write(params.height, largest);
    }
}

/// Replaces the indirect light of each point by the mean of the samples around it.
#[pass(name = "share.gather", over = params.pixel_count(), work = Gather)]
pub fn share_gather(
    index: u32,
    params: &FrameParams,
    features: Features,
    materials: &[Material],
    pixel_order: &[u32],
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    #[len = params.pixel_count()] point_indirect: &[IndirectSample],
    share_levels: &[u32],
    share_ranges: &[u32],
    sharing_points: &[SharingPoint],
    shared_light: &[SharedLight],
    largest_samples: &[f32],
    mut path_radiance: Slots<'_, Vec3>,
) {
    let pixel = pixel_order[index as usize];
    let point = point_geometry[pixel as usize];
    let own = point_indirect[pixel as usize].light[0];
    let largest = largest_samples[params.height as usize];
    if !point.exists() || own == NONE || largest < MIN_LARGEST {
        return;
    }
    let shading = &point_shading[pixel as usize];
    let quantum = quantum(largest);
    let mut taker = Taker {
        position: point.position,
        normal: point.normal,
        shading_normal: shading.shading_normal,
        depth: point.depth,
        material: shading.material,
        radius: share_radius(&point, params),
        inverse_quantum: 1.0 / quantum,
        red: Quanta::default(),
        green: Quanta::default(),
        blue: Quanta::default(),
        count: 0,
    };
    let half_extent = disc_half_extent(&PointGeometry { radius: taker.radius, ..point });
    let own_level = radius_bin(taker.radius);
    let mut level = own_level - 1;
    while level <= own_level + 1 {
        if share_levels[(level & (RADIUS_BINS - 1)) as usize] != 0 {
            let size = cell_size(level);
            let (low, high) =
                (cell(point.position - half_extent, size), cell(point.position + half_extent, size));
            let mut runs = Runs::new(low, high, salt(level), cell_mask(params));
            while runs.is_left() {
                let run = runs.next(share_ranges);
                let mut entry = run.start;
                while entry < run.end {
                    let giver = sharing_points[entry as usize];
                    // Skip points of other levels and cells that share the slot.
                    if taker.is_near(&giver)
                        && giver.depth_and_level >> 16 == level
                        && run.holds(giver.position, size)
                    {
                        taker.take(&giver, &shared_light[entry as usize]);
                    }
                    entry += 1;
                }
            }
        }
        level += 1;
    }
    if taker.count > 1 {
        let material = material_of(shading, materials, features);
        let receiver = Receiver::new(shading, material, params.specular_roughness, features);
        let change = taker.mean(quantum) - from_rgbe(own);
        let seen = shading.throughput * receiver.diffuse_albedo() * change;
        path_radiance.write(pixel, path_radiance.read(pixel) + seen);
    }
}

/// Smallest largest sample of a frame for which samples are shared: its quantum is a normal number.
const MIN_LARGEST: f32 = 1.0e-25;

/// Quantum of sums whose largest addend is `largest`.
#[inline(always)]
fn quantum(largest: f32) -> f32 {
    f32::from_bits((largest.to_bits() & 0x7f80_0000) - (LARGEST_LOG2 << 23))
}

/// Point that takes samples, and their sum.
struct Taker {
    position: Vec3,
    normal: Vec3,
    shading_normal: Vec3,
    depth: u32,
    material: u32,
    radius: f32,
    inverse_quantum: f32,
    red: Quanta,
    green: Quanta,
    blue: Quanta,
    count: u32,
}

impl Taker {
    /// Whether a point lies within the radius, close to the tangent plane, and gives samples for this depth.
    #[inline(always)]
    fn is_near(&self, giver: &SharingPoint) -> bool {
        let along = giver.position - self.position;
        let height = along.dot(self.normal).abs();
        let deeper = self.depth.wrapping_sub(giver.depth_and_level & 0xffff);
        along.length_squared() <= self.radius * self.radius
            && height <= DISC_THICKNESS * self.radius
            && deeper <= MAX_DEEPER
    }

    /// Takes the sample of a near point, if it is of the same kind of surface.
    #[inline(always)]
    fn take(&mut self, giver: &SharingPoint, light: &SharedLight) {
        if light.material == self.material && light.shading_normal.dot(self.shading_normal) > MIN_NORMAL_COS {
            let deeper = self.depth - (giver.depth_and_level & 0xffff);
            let light = from_rgbe(light.sample.light[deeper as usize]);
            self.red = self.red.plus(Quanta::from_f32(light.x, self.inverse_quantum));
            self.green = self.green.plus(Quanta::from_f32(light.y, self.inverse_quantum));
            self.blue = self.blue.plus(Quanta::from_f32(light.z, self.inverse_quantum));
            self.count += 1;
        }
    }

    /// Mean of the samples.
    #[inline(always)]
    fn mean(&self, quantum: f32) -> Vec3 {
        let sum = Vec3::new(self.red.to_f32(quantum), self.green.to_f32(quantum), self.blue.to_f32(quantum));
        sum / self.count as f32
    }
}
