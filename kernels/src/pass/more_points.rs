//! `points.*`: more collection points in pixels where the choice of the prefix is most of the noise, as for caustics in a rough
//! mirror. A prefix costs a fraction of a camera path. After `resolve` such pixels trace further prefixes and gather the photons of
//! the frame again. The caustic of a pixel is the mean over its points.
//!
//! With k points, a pixel has the variance R + P / k at the cost C + (k - 1) c. P is the variance by the choice of the prefix, and R
//! all other variance. A frame costs C, a further point c. For c far below C, the product is smallest at k^2 = P C / (R c). P is the
//! variance of caustics from frame to frame that their photons do not explain. Earlier frames decide, so that every frame is unbiased.
//!
//! Limitations: all points of a pixel share the photons of the frame, so their noise remains. Prefixes that have found no caustic
//! yet get no further points. A row of the image has at most as many further points as pixels. Frames with a pilot, and frames
//! whose photons need several batches, have one point a pixel. The further prefixes find no light on their way: the path layer
//! remains as it is. The inspector shows the first point.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{FrameStage, Step};
use crate::gather::accumulator::{self, GatheredSum};
use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::point::{PointGeometry, PointShading};
use crate::interface::scene::SceneTables;
use crate::interface::seen::PixelNoise;
use crate::math::mean;
use crate::math::rng::Stream;
use crate::pass::resolve::estimate_radiance;
use crate::pass::weigh::{MAX_LIGHT, kept};
use crate::path::camera_pass::{CameraPass, CameraPathRequest, run_camera_pass};
use crate::path::camera_path::{CameraPathLight, CameraSuffix};
use crate::path::observer::{CollectionPoint, PathObserver};
use crate::platform::{Atomics, Slots};
use crate::trace::Tracer;
use spirv_std::glam::{UVec2, Vec2, Vec3};

/// Stage that adds collection points.
#[cfg(not(target_arch = "spirv"))]
pub const MORE_POINTS: FrameStage = FrameStage {
    before_light: |params| vec![Step::new(&POINTS_COUNT, params), Step::new(&POINTS_ASSIGN, params)],
    after_resolve: |params| vec![Step::new(&POINTS_LEARN, params)],
    gather_again: |params, gather| {
        let mut steps = vec![
            Step::new(&POINTS_SET_ASIDE, params),
            Step::Clear { buffer: "accumulator" },
            Step::new(&POINTS_TRACE, params),
        ];
        steps.extend(gather);
        steps.extend([Step::new(&POINTS_ADD, params), Step::new(&POINTS_RESTORE, params)]);
        steps
    },
    keeps: &["pixel_noise", "pixel_variances"],
    ..FrameStage::new("more points")
};

/// Maximum number of collection points of a pixel.
pub const MAX_POINTS: u32 = 16;
/// Cost of a frame of one point, relative to that of a further point in all pixels. Measured on a CPU in glossy-room.
const FRAME_COST: f32 = 4.0;
/// Number of pixels to each side over which variances are averaged.
const AROUND: u32 = 2;

/// Chooses the number of points of each pixel.
#[pass(name = "points.count", over = params.pixel_count(), work = Guide)]
pub fn points_count(
    pixel: u32,
    params: &FrameParams,
    pixel_variances: &[Vec2],
    #[len = params.pixel_count()] mut point_counts: Slots<'_, u32>,
) {
    let variances = params.sum_around(pixel, AROUND, |other| pixel_variances[other as usize]);
    let mut count = 1;
    if variances.x > 0.0 {
        let best = (variances.x / variances.y * FRAME_COST).sqrt();
        count = (best.min(params.collection_points as f32) + 0.5) as u32;
    }
    point_counts.write(pixel, count.max(1));
}

/// Assigns the slots of a row, one a pixel, to its further points. If there are too few, all pixels get fewer points.
#[pass(name = "points.assign", over = params.height, work = Guide)]
pub fn points_assign(
    row: u32,
    params: &FrameParams,
    point_counts: &[u32],
    #[len = params.pixel_count()] mut point_slots: Slots<'_, UVec2>,
    #[len = params.pixel_count()] mut slot_prefixes: Slots<'_, UVec2>,
) {
    let (first, end) = (row * params.width, (row + 1) * params.width);
    let mut wanted = 0;
    let mut pixel = first;
    while pixel < end {
        wanted += point_counts[pixel as usize] - 1;
        pixel += 1;
    }
    let mut slot = first;
    pixel = first;
    while pixel < end {
        let mut further = point_counts[pixel as usize] - 1;
        if wanted > params.width {
            further = further * params.width / wanted;
        }
        point_slots.write(pixel, UVec2::new(slot, further));
        let mut number = 1;
        while number <= further {
            slot_prefixes.write(slot, UVec2::new(pixel, number));
            slot += 1;
            number += 1;
        }
        pixel += 1;
    }
    while slot < end {
        slot_prefixes.write(slot, UVec2::new(NONE, 0));
        slot += 1;
    }
}

/// Learns the noise of each pixel's light with its first point alone: the variance by its prefix, and all other.
#[pass(name = "points.learn", over = params.pixel_count(), work = Guide)]
pub fn points_learn(
    pixel: u32,
    params: &FrameParams,
    path_radiance: &[Vec3],
    #[len = params.pixel_count()] caustic_radiance: &[Vec3],
    #[len = params.pixel_count() * accumulator::WORDS] accumulator: &[u32],
    #[len = params.pixel_count()] mut pixel_noise: Slots<'_, PixelNoise>,
    #[len = params.pixel_count()] mut pixel_variances: Slots<'_, Vec2>,
) {
    let caustic = mean(caustic_radiance[pixel as usize]).min(MAX_LIGHT);
    let light = (mean(path_radiance[pixel as usize]) + caustic).min(MAX_LIGHT);
    let (_, photons) = GatheredSum::read(accumulator, pixel, params.quantum);
    let before = pixel_noise.read(pixel);
    let keep = kept(before.frames, params);
    let now = PixelNoise {
        frames: before.frames * keep + 1.0,
        light: before.light * keep + light,
        light_square: before.light_square * keep + light * light,
        caustic: before.caustic * keep + caustic,
        caustic_square: before.caustic_square * keep + caustic * caustic,
        photon_variance: before.photon_variance * keep + caustic * caustic / photons.max(1) as f32,
    };
    pixel_noise.write(pixel, now);
    let by_prefix = now.variance_by_prefix();
    pixel_variances.write(pixel, Vec2::new(by_prefix, (now.variance() - by_prefix).max(0.0)));
}

/// Sets the first points and their sums aside. The weights of slots are 0: emissions learn from the first points.
#[pass(name = "points.set_aside", over = params.pixel_count(), work = Resolve)]
pub fn points_set_aside(
    pixel: u32,
    slot_prefixes: &[UVec2],
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    accumulator: &[u32],
    #[len = params.pixel_count()] mut pixel_weights: Slots<'_, f32>,
    #[len = params.pixel_count()] mut first_geometry: Slots<'_, PointGeometry>,
    #[len = params.pixel_count()] mut first_shading: Slots<'_, PointShading>,
    #[len = params.pixel_count() * accumulator::WORDS] mut first_sum: Slots<'_, u32>,
    #[len = params.pixel_count()] mut first_weight: Slots<'_, f32>,
) {
    first_geometry.write(pixel, point_geometry[pixel as usize]);
    if slot_prefixes[pixel as usize].x != NONE {
        first_shading.write(pixel, point_shading[pixel as usize]);
    }
    let mut word = pixel * accumulator::WORDS;
    while word < (pixel + 1) * accumulator::WORDS {
        first_sum.write(word, accumulator[word as usize]);
        word += 1;
    }
    first_weight.write(pixel, pixel_weights.read(pixel));
    pixel_weights.write(pixel, 0.0);
}

/// Restores the first points and their sums, which layers of the image and the inspector show.
#[pass(name = "points.restore", over = params.pixel_count(), work = Resolve)]
pub fn points_restore(
    pixel: u32,
    slot_prefixes: &[UVec2],
    first_geometry: &[PointGeometry],
    first_shading: &[PointShading],
    first_sum: &[u32],
    first_weight: &[f32],
    mut point_geometry: Slots<'_, PointGeometry>,
    mut point_shading: Slots<'_, PointShading>,
    mut accumulator: Slots<'_, u32>,
    mut pixel_weights: Slots<'_, f32>,
) {
    point_geometry.write(pixel, first_geometry[pixel as usize]);
    if slot_prefixes[pixel as usize].x != NONE {
        point_shading.write(pixel, first_shading[pixel as usize]);
    }
    let mut word = pixel * accumulator::WORDS;
    while word < (pixel + 1) * accumulator::WORDS {
        accumulator.write(word, first_sum[word as usize]);
        word += 1;
    }
    pixel_weights.write(pixel, first_weight[pixel as usize]);
}

/// Traces the further prefixes, one slot an invocation.
#[pass(name = "points.trace", over = params.pixel_count(), work = Camera, shared_entry)]
pub fn points_trace(
    slot: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    tracer: &mut impl Tracer,
    counters: &mut impl Atomics,
    slot_prefixes: &[UVec2],
    point_geometry: Slots<'_, PointGeometry>,
    point_shading: Slots<'_, PointShading>,
) {
    let pass = FurtherPoint {
        slot,
        prefix: slot_prefixes[slot as usize],
        geometry: point_geometry,
        shading: point_shading,
    };
    run_camera_pass(pass, params, features, scene, tracer, counters);
}

/// The camera pass `points.trace`, which stores a collection point where it finds it.
struct FurtherPoint<'a> {
    slot: u32,
    /// Pixel and number of the prefix; the pixel of an empty slot is `NONE`.
    prefix: UVec2,
    geometry: Slots<'a, PointGeometry>,
    shading: Slots<'a, PointShading>,
}

impl PathObserver for FurtherPoint<'_> {
    type Kept = ();

    #[inline(always)]
    fn collect(&mut self, _kept: &mut (), point: &CollectionPoint) {
        self.geometry.write(self.slot, point.geometry);
        self.shading.write(self.slot, point.shading);
    }
    #[inline(always)]
    fn end(&mut self, kept: &mut (), last: Vec3) {
        self.collect(kept, &CollectionPoint::none(last));
    }
}

impl CameraPass for FurtherPoint<'_> {
    #[inline(always)]
    fn request(&self) -> CameraPathRequest {
        request(self.prefix)
    }
    #[inline(always)]
    fn store(&mut self, _light: &CameraPathLight, _kept: &()) {
        if self.prefix.x == NONE {
            self.geometry.write(self.slot, PointGeometry::default());
        }
    }
}

/// Requests a prefix by its pixel and its number.
#[inline(always)]
pub fn request(prefix: UVec2) -> CameraPathRequest {
    let suffix = CameraSuffix::NOTHING;
    CameraPathRequest { pixel: prefix.x, stream: Stream::Camera, number: prefix.y, suffix }
}

/// Averages the caustic of each pixel over its points, in the order of their numbers.
#[pass(name = "points.add", over = params.pixel_count(), work = Resolve)]
pub fn points_add(
    pixel: u32,
    params: &FrameParams,
    point_slots: &[UVec2],
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    accumulator: &[u32],
    mut caustic_radiance: Slots<'_, Vec3>,
) {
    let UVec2 { x: first, y: further } = point_slots[pixel as usize];
    if further == 0 {
        return;
    }
    let mut sum = caustic_radiance.read(pixel);
    let mut slot = first;
    while slot < first + further {
        let point = &point_geometry[slot as usize];
        if point.exists() {
            let (gathered, _) = GatheredSum::read(accumulator, slot, params.quantum);
            sum += estimate_radiance(point, &point_shading[slot as usize], gathered);
        }
        slot += 1;
    }
    caustic_radiance.write(pixel, sum / (further + 1) as f32);
}
