//! `share.*`: path space filtering [Keller, Dahm and Binder 2014]. Collection points share the indirect light that their camera paths
//! found.
//!
//! Each camera path leaves a sample Y at its collection point: the indirect light that a white diffuse surface there would show. A
//! point takes the mean of the samples within a radius on its own surface. In the image, T a Y becomes T a mean(Y). T is the
//! throughput of the prefix, and a the albedo of the point's diffuse lobes. The difference is added to what the path found. Direct
//! light, light of other lobes, and light before the point remain as they are. Points are found in world space: one that is seen in a
//! mirror also takes samples of those that are seen directly, never the reverse.
//!
//! Bounces stay exact. Behind a point of camera vertex d, light may have `max_bounces` - d scatterings. A sample therefore stores three
//! values: for points of its own depth, one vertex deeper, and two deeper. Deeper points have fewer bounces left. A point takes no samples
//! of deeper points: these lack light. Paths that found nothing leave a zero, which counts.
//!
//! Near other surfaces, indirect light changes fast, as in corners and contact shadows. The radius is therefore at most a share of the
//! harmonic mean distance of the surfaces that the paths around a point met. This is the bound of irradiance caching [Ward, Rubinstein
//! and Clear 1988]. It also keeps the floor on one side of a thin wall from taking much light of the other side.
//!
//! Sums are integers, whose quantum is a power of two below the largest sample of the frame: no sample is clamped. The index has a
//! grid for each power of two of the radius, as the gather `points-grid`. A point searches the grid of its own radius. Where it finds
//! few samples, it also searches those of half and of twice that radius.
//!
//! Radii leave out the width that rough lobes add to the cone of a pixel. So a disc holds some 64 points in the first frame, also
//! where it is seen in a rough mirror.
//!
//! Sharing pays where it removes a larger share of the variance of an image than it takes of a frame's time. Both are measured as in
//! `balance`. Where it does not pay, the next frames do not share; the less it paid, the more of them.
//!
//! Cost: an index over the points, and a search. In `mirror-room` it meets 127 points a pixel, of which 29 give samples (fifth frame).
//! Both fall with the radius. Where many views of a surface overlap, random points are left out of the index.
//! Limitations: light is blurred within the radius, also across the edges of shadows of indirect light that a far object throws. Only
//! diffuse lobes share. Points whose color lacks a channel neither give nor take. A tile of an image takes samples of
//! its own pixels alone, and decides by itself whether sharing pays. Blur of true detail counts as removed variance there.

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{FrameStage, Step};
use crate::gather::contribution::{DISC_THICKNESS, MIN_NORMAL_COS, Receiver, disc_half_extent};
use crate::gather::hash::{
    RADIUS_BINS, Runs, cell_bits, cell_size_of, radius_bin, reserve_block, salt, slot,
};
use crate::interface::NONE;
use crate::interface::balance::ShareBalance;
use crate::interface::features::Features;
use crate::interface::frame::{Dispatch, FIRST_FRAME, FrameParams};
use crate::interface::material::Material;
use crate::interface::packed::{MIN_EXPONENT, exponent, from_bfloats, from_rgbe, rgbe_quanta, rgbe_quantum};
use crate::interface::point::{
    IndirectSample, PointGeometry, PointShading, SHARED_DEPTHS, SharedLight, SharingPoint,
};
use crate::math::grid::cell;
use crate::math::mean;
use crate::math::quanta::ColorQuanta;
use crate::math::rng::pcg4d;
#[cfg(not(target_arch = "spirv"))]
use crate::pass::balance::BALANCE;
use crate::pass::balance::{KEEP, MAX_VARIANCE, costs, mean_of_rows};
use crate::pass::weigh::FADE;
#[cfg(not(target_arch = "spirv"))]
use crate::pass::weigh::WEIGH;
use crate::platform::{AtomicWords, Atomics, Slots, Words};
use crate::surface::textured::material_of;
use spirv_std::glam::{UVec3, UVec4, Vec2, Vec3};

/// Stage that shares indirect light between collection points.
#[cfg(not(target_arch = "spirv"))]
pub const SHARE: FrameStage = FrameStage {
    before_display: |params| {
        if !params.shares_indirect() {
            return Vec::new();
        }
        let mut steps = vec![
            Step::Clear { buffer: "share_levels" },
            Step::Clear { buffer: "share_counts" },
            // Crowded slots have entries that no point takes: they must not hold points of earlier frames.
            Step::Clear { buffer: "sharing_points" },
            Step::level(&SHARE_INDEX, COUNT, params.pixel_count()),
            Step::level(&SHARE_INDEX, RESERVE, cell_mask(params) + 1),
            Step::level(&SHARE_INDEX, FILL, params.pixel_count()),
            Step::new(&SHARE_GATHER, params),
        ];
        // Without light paths there are no weights of pixels.
        if params.light_path_count > 0 {
            steps.extend([Step::new(&SHARE_ROWS, params), Step::new(&SHARE_BALANCE, params)]);
        }
        steps
    },
    keeps: &["share_balance"],
    needs: &[&WEIGH, &BALANCE],
    features: Features::INDIRECT,
    ..FrameStage::new("share")
};

/// Radius of the first frame, relative to the disc of a pixel's footprint area.
pub const SHARE_RADIUS_PX: f32 = 8.0;
/// Stages of the index.
const COUNT: u32 = 0;
const RESERVE: u32 = 1;
const FILL: u32 = 2;
/// Number of points of a slot above which some are left out.
const MAX_IN_SLOT: u32 = 32;
/// Word of the random numbers that decide which.
const CROWD_SALT: u32 = 0x7368_6172;
/// Index of the word behind the levels that holds the exponent of the frame's largest sample.
pub const LARGEST: u32 = RADIUS_BINS;
/// Number of samples of a point's own level with which it does not search the next ones.
const ENOUGH: u32 = 4;
/// Maximum radius over the harmonic mean hit distance. Beside an infinite perpendicular wall at distance d, that mean is 3 pi d / 2. So
/// radii are at most 1.2 d.
const MAX_PROXIMITY: f32 = 0.25;
/// Unit of sums of proximities.
const PROXIMITY_SCALE: f32 = 1024.0;
/// Largest number of cells that a disc meets, with those that rounding adds. A larger box gives no samples.
const MAX_CELLS: f32 = 512.0;
/// Number of radii, each half of the one before, of which a point takes the first that is far enough from surfaces.
const MAX_SEARCHES: u32 = 4;

/// Cost of a point that shares, its part of the index included (rays of camera paths). This and the next one were measured on a CPU.
const POINT_COST: f32 = 0.8;
/// Cost of a point that is looked at (rays of camera paths).
const CANDIDATE_COST: f32 = 0.01;
/// Minimum number of frames without sharing behind one in which it did not pay. While something moves, also the maximum.
const PAUSE: f32 = 8.0;
/// Maximum number of frames without sharing in a still view.
const MAX_PAUSE: f32 = 63.0;

/// Number of cells of the index minus one (a power of two minus one).
#[inline(always)]
pub fn cell_mask(params: &FrameParams) -> u32 {
    u32::MAX >> params.pixel_count().leading_zeros()
}

/// Largest radius within which a point takes samples (m).
#[inline(always)]
pub fn share_radius(sample: &IndirectSample, params: &FrameParams) -> f32 {
    from_bfloats(sample.radius_and_proximity).0 * (params.share_radius_px / params.radius_px)
}

/// Edge of a cell of a level (m): between the radius and its double.
#[inline(always)]
fn cell_size(level: u32) -> f32 {
    cell_size_of(level) * 0.5
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
    #[len = RADIUS_BINS + 1] mut share_levels: AtomicWords<'_>,
    #[len = cell_mask(params) + 2] mut share_counts: AtomicWords<'_>,
    #[len = 2 * (cell_mask(params) + 1)] mut share_ranges: AtomicWords<'_>,
    #[len = params.pixel_count()] mut sharing_points: Slots<'_, SharingPoint>,
    #[len = params.pixel_count()] mut shared_light: Slots<'_, SharedLight>,
    #[len = 1] share_balance: &[ShareBalance],
) {
    let mask = cell_mask(params);
    let has_light = dispatch.level == COUNT || share_levels.get(LARGEST) >= MIN_EXPONENT;
    if !has_light || share_balance[0].pause > 0 {
        return;
    }
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
    let level = radius_bin(share_radius(&sample, params));
    let cell = cell(point.position, cell_size(level));
    let slot = slot(cell, salt(level), mask);
    if dispatch.level == COUNT {
        share_levels.set(level, 1);
        share_levels.fetch_max(LARGEST, exponent(sample.light[0]));
        share_counts.add(slot, 1);
    }
    if dispatch.level == FILL && is_kept(pixel, share_counts.get(slot), params) {
        // Take the next entry of the slot. The order in a cell is free, because sums are integers.
        let to = share_ranges.add(2 * slot + 1, 1);
        let shading = &point_shading[pixel as usize];
        let key = point.depth | level << 8 | cell_bits(cell);
        sharing_points.write(to, SharingPoint { position: point.position, key });
        let PointShading { shading_normal, material, .. } = *shading;
        shared_light.write(to, SharedLight { shading_normal, material, sample });
    }
}

/// Whether a point of a crowded slot is among the `MAX_IN_SLOT` or so that stay, by a random number of its own.
#[inline(always)]
fn is_kept(pixel: u32, in_slot: u32, params: &FrameParams) -> bool {
    let mut kept = true;
    if in_slot > MAX_IN_SLOT {
        let random = pcg4d(UVec4::new(params.film_pixel(pixel), params.frame, params.seed, CROWD_SALT)).x;
        kept = random as f32 * (1.0 / 4_294_967_296.0) * (in_slot as f32) < MAX_IN_SLOT as f32;
    }
    kept
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
    share_balance: &[ShareBalance],
    mut path_radiance: Slots<'_, Vec3>,
    #[len = params.pixel_count()] mut share_gains: Slots<'_, Vec2>,
) {
    if share_balance[0].pause > 0 {
        return;
    }
    let pixel = pixel_order[index as usize];
    let point = point_geometry[pixel as usize];
    let sample = point_indirect[pixel as usize];
    let own = sample.light[0];
    let largest = share_levels[LARGEST as usize];
    if !point.exists() || own == NONE || largest < MIN_EXPONENT {
        share_gains.write(pixel, Vec2::ZERO);
        return;
    }
    let shading = &point_shading[pixel as usize];
    let taker = Taker::new(point, shading, largest);
    let samples =
        Samples { levels: share_levels, ranges: share_ranges, points: sharing_points, light: shared_light };
    let search = samples.search(&taker, share_radius(&sample, params), cell_mask(params), &mut |_, _| ());
    let mut gain = 0.0;
    if search.has_mean() {
        let change = search.taken.mean(rgbe_quantum(largest)) - from_rgbe(own);
        let seen = diffuse_response(shading, materials, params, features) * change;
        path_radiance.write(pixel, path_radiance.read(pixel) + seen);
        gain = mean(seen) * mean(seen);
    }
    share_gains.write(pixel, Vec2::new(gain, POINT_COST + CANDIDATE_COST * search.candidates as f32));
}

/// Throughput of the prefix times diffuse albedo: the factor from the indirect light of a white diffuse surface to that of the pixel.
#[inline(always)]
pub fn diffuse_response(
    shading: &PointShading,
    materials: &[Material],
    params: &FrameParams,
    features: Features,
) -> Vec3 {
    let material = material_of(shading, materials, features);
    let receiver = Receiver::new(shading, material, params.specular_roughness, features);
    shading.throughput * receiver.diffuse_albedo()
}

/// Means over the pixels of each row: the squared change by sharing, relative to the square of a pixel's value, and the cost.
#[pass(name = "share.rows", over = params.height, work = Gather)]
pub fn share_rows(
    row: u32,
    params: &FrameParams,
    pixel_weights: &[f32],
    share_gains: &[Vec2],
    #[len = params.height] mut share_rows: Slots<'_, Vec2>,
) {
    let mut sum = Vec2::ZERO;
    let mut pixel = row * params.width;
    while pixel < (row + 1) * params.width {
        let Vec2 { x: gain, y: cost } = share_gains[pixel as usize];
        sum += Vec2::new(gain * pixel_weights[pixel as usize], cost);
        pixel += 1;
    }
    share_rows.write(row, sum / params.width as f32);
}

/// Decides whether the next frames share.
#[pass(name = "share.balance", over = 1, work = Gather)]
pub fn share_balance(
    _index: u32,
    params: &FrameParams,
    counters: &[u32],
    balance_rows: &[Vec2],
    share_rows: &[Vec2],
    mut share_balance: Slots<'_, ShareBalance>,
) {
    let before = share_balance.read(0);
    if before.pause > 0 {
        let mut next = ShareBalance { pause: before.pause - 1, ..before };
        if params.moved != 0 {
            next = ShareBalance { pause: next.pause.min(PAUSE as u32), ..before.faded(FADE) };
        }
        share_balance.write(0, next);
        return;
    }
    // Skip the first frame, whose emissions know nothing yet: caustics are most of its noise.
    if params.moved == FIRST_FRAME {
        return;
    }
    let Vec2 { x: gain, y: cost } = mean_of_rows(share_rows, params);
    let variance = mean_of_rows(balance_rows, params).element_sum();
    // Black images and light without bounds tell nothing.
    if !(gain < MAX_VARIANCE && variance > 0.0 && variance < MAX_VARIANCE) {
        return;
    }
    let keep = if params.moved != 0 { FADE } else { KEEP };
    let (camera_cost, light_cost) = costs(counters, params);
    let faded = before.faded(keep);
    let mut now = ShareBalance {
        gain: faded.gain + gain,
        variance: faded.variance + variance,
        cost: faded.cost + cost * params.pixel_count() as f32,
        other_cost: faded.other_cost + camera_cost + light_cost,
        pause: 0,
    };
    let worth = now.worth();
    if worth < 1.0 {
        now.pause = (PAUSE / worth.max(PAUSE / MAX_PAUSE)) as u32;
    }
    share_balance.write(0, now);
}

/// Point that takes samples.
pub struct Taker {
    point: PointGeometry,
    shading_normal: Vec3,
    material: u32,
    /// Exponent of the frame's largest sample.
    largest: u32,
}

impl Taker {
    /// A point, and the exponent of the frame's largest sample.
    #[inline(always)]
    pub fn new(point: PointGeometry, shading: &PointShading, largest: u32) -> Taker {
        Taker { point, shading_normal: shading.shading_normal, material: shading.material, largest }
    }

    /// Whether a point lies within the radius, close to the tangent plane, and gives samples for this depth.
    #[inline(always)]
    fn is_near(&self, giver: &SharingPoint, radius: f32) -> bool {
        let along = giver.position - self.point.position;
        let height = along.dot(self.point.normal).abs();
        along.length_squared() <= radius * radius
            && height <= DISC_THICKNESS * radius
            && self.deeper(giver) < SHARED_DEPTHS as u32
    }

    /// Number of camera vertices by which this point is deeper than one that gives; a huge number if it is less deep.
    #[inline(always)]
    pub fn deeper(&self, giver: &SharingPoint) -> u32 {
        self.point.depth.wrapping_sub(giver.key & 0xff)
    }

    /// Whether a sample is from the same kind of surface.
    #[inline(always)]
    fn is_alike(&self, light: &SharedLight) -> bool {
        light.material == self.material && light.shading_normal.dot(self.shading_normal) > MIN_NORMAL_COS
    }
}

/// Search for samples around a point.
pub struct Search {
    /// Samples within the last radius.
    pub taken: Taken,
    /// The last radius (m).
    pub radius: f32,
    /// Whether surfaces are too near for each radius.
    surfaces_are_near: bool,
    /// Number of points that were looked at.
    candidates: u32,
}

impl Search {
    /// Whether the point takes the mean: there are several samples, and no surface is near.
    #[inline(always)]
    pub fn has_mean(&self) -> bool {
        !self.surfaces_are_near && self.taken.count > 1
    }
}

/// Samples that a point has taken.
#[derive(Clone, Copy, Default)]
pub struct Taken {
    light: ColorQuanta,
    /// Number of samples. The point's own is among them, unless it is left out of the index.
    pub count: u32,
    /// Sum of min(1, radius times proximity), in 1 / `PROXIMITY_SCALE`.
    proximity: u32,
    /// Number of points that were looked at.
    candidates: u32,
}

impl Taken {
    /// Adds a sample: its value, and its proximity times the radius.
    #[inline(always)]
    fn plus(self, value: UVec3, proximity: f32) -> Taken {
        Taken {
            light: self.light.plus(ColorQuanta::new(value)),
            count: self.count + 1,
            proximity: self.proximity + (proximity.min(1.0) * PROXIMITY_SCALE) as u32,
            candidates: self.candidates,
        }
    }

    /// Whether the radius exceeds its share of the harmonic mean distance.
    #[inline(always)]
    fn surfaces_are_near(&self) -> bool {
        self.proximity as f32 > MAX_PROXIMITY * PROXIMITY_SCALE * self.count as f32
    }

    /// Mean of the samples.
    #[inline(always)]
    pub fn mean(&self, quantum: f32) -> Vec3 {
        self.light.to_vec3(quantum) / self.count as f32
    }
}

/// Samples of all points, in the order of the index.
pub struct Samples<'a> {
    /// `share_levels`.
    pub levels: &'a [u32],
    /// `share_ranges`.
    pub ranges: &'a [u32],
    /// `sharing_points`.
    pub points: &'a [SharingPoint],
    /// `shared_light`.
    pub light: &'a [SharedLight],
}

impl Samples<'_> {
    /// Searches around a point. Halves the radius until no surface is near. `take` gets each sample's entry in the index, and the radius.
    #[inline(always)]
    pub fn search(
        &self,
        taker: &Taker,
        largest_radius: f32,
        cell_mask: u32,
        take: &mut impl FnMut(u32, f32),
    ) -> Search {
        let level = radius_bin(largest_radius);
        let mut search = Search {
            taken: Taken::default(),
            radius: largest_radius,
            surfaces_are_near: true,
            candidates: 0,
        };
        let mut searches = 0;
        while search.surfaces_are_near && searches < MAX_SEARCHES {
            if searches > 0 {
                search.radius *= 0.5;
            }
            search.taken = self.around(taker, search.radius, level, cell_mask, take);
            search.candidates += search.taken.candidates;
            search.surfaces_are_near = search.taken.surfaces_are_near();
            searches += 1;
        }
        search
    }

    /// Samples within a radius around a point: those of its own level and, if they are few, of those next to it.
    #[inline(always)]
    fn around(
        &self,
        taker: &Taker,
        radius: f32,
        own_level: u32,
        cell_mask: u32,
        take: &mut impl FnMut(u32, f32),
    ) -> Taken {
        let half_extent = disc_half_extent(&PointGeometry { radius, ..taker.point });
        let taken = Taken::default();
        let mut taken = self.of_level(own_level, taker, radius, half_extent, cell_mask, taken, take);
        let mut level = own_level.max(1) - 1;
        while level <= own_level + 1 && taken.count < ENOUGH {
            if level != own_level && self.levels[(level & (RADIUS_BINS - 1)) as usize] != 0 {
                taken = self.of_level(level, taker, radius, half_extent, cell_mask, taken, take);
            }
            level += 1;
        }
        taken
    }

    /// Adds the samples of a level.
    #[inline(always)]
    fn of_level(
        &self,
        level: u32,
        taker: &Taker,
        radius: f32,
        half_extent: Vec3,
        cell_mask: u32,
        mut taken: Taken,
        take: &mut impl FnMut(u32, f32),
    ) -> Taken {
        let size = cell_size(level);
        let position = taker.point.position;
        let (low, high) = (cell(position - half_extent, size), cell(position + half_extent, size));
        let mut runs = Runs::new(low, high, salt(level), cell_mask);
        // Rounding makes large boxes far from the origin.
        while runs.cell_count() <= MAX_CELLS && runs.is_left() {
            let run = runs.next(self.ranges);
            taken.candidates += run.end - run.start;
            let mut entry = run.start;
            while entry < run.end {
                let giver = self.points[entry as usize];
                // Skip points of other levels and cells that share the slot.
                if giver.key >> 8 & 0xff == level
                    && taker.is_near(&giver, radius)
                    && run.holds_bits(giver.key)
                {
                    let light = &self.light[entry as usize];
                    if taker.is_alike(light) {
                        let sample = light.sample.light[taker.deeper(&giver) as usize];
                        let value = rgbe_quanta(sample, taker.largest);
                        let (_, proximity) = from_bfloats(light.sample.radius_and_proximity);
                        taken = taken.plus(value, radius * proximity);
                        take(entry, radius);
                    }
                }
                entry += 1;
            }
        }
        taken
    }
}
