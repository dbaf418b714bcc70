//! `weigh.*`: how much an error of each pixel counts, by what it showed: what emissions that learn and shares of a frame's time
//! go by. All of it is of earlier frames, and of what comes before the light paths that it is used for.

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{FrameStage, Step};
use crate::gather::accumulator::{self, GatheredSum};
use crate::interface::frame::{Dispatch, FrameParams, PILOT};
use crate::interface::point::{PointGeometry, PointShading};
use crate::interface::seen::PixelSum;
use crate::math::mean;
use crate::pass::resolve::estimate_radiance;
use crate::platform::Slots;
use spirv_std::glam::{Vec2, Vec3};

/// Weights of an error of each pixel.
#[cfg(not(target_arch = "spirv"))]
pub const WEIGH: FrameStage = FrameStage {
    // Add what camera paths found, and weigh pixels.
    before_light: |params| {
        let mut steps = vec![Step::new(&WEIGH_SEEN, params)];
        steps.extend(steps_of(params, 0));
        steps
    },
    // Add what light paths brought.
    after_resolve: |params| vec![Step::new(&WEIGH_LEARN, params)],
    keeps: &["image_rows", "pixel_sums"],
    ..FrameStage::new("weigh")
};

/// Weighs pixels once more, with what the pilot of the frame brought.
#[cfg(not(target_arch = "spirv"))]
pub fn weigh_with_pilot(params: &FrameParams) -> Vec<Step> {
    steps_of(params, 1)
}

#[cfg(not(target_arch = "spirv"))]
fn steps_of(params: &FrameParams, time: u32) -> Vec<Step> {
    vec![
        Step::level(&WEIGH_MEANS, time, params.pixel_count()),
        Step::level(&WEIGH_ROWS, 0, params.height),
        Step::level(&WEIGH_ROWS, 1, 1),
        Step::new(&WEIGH_PIXELS, params),
    ]
}

/// Share of what is known that counts on where something moved.
pub const FADE: f32 = 0.5;

/// Share of what so many frames said that counts on: all in a still view, and where something moved the half, but of a view that
/// was still for long no more than a frame's worth.
#[inline(always)]
pub fn kept(frames: f32, params: &FrameParams) -> f32 {
    if params.moved == 0 {
        1.0
    } else if frames * FADE > 1.0 {
        1.0 / frames
    } else {
        FADE
    }
}

/// Light of a pixel below which no error counts, relative to the mean of the image.
const DARK: f32 = 0.1;
/// Squares of light below this have no inverse in an f32.
const MIN_SQUARE: f32 = 1.0e-37;
/// Light of a frame counts as this at most (W m^-2 sr^-1): its square has an inverse.
const MAX_LIGHT: f32 = 1.0e15;
/// Pixels to each side whose light is a pixel's.
const AROUND: u32 = 2;

/// Adds what camera paths found in each pixel, after what is known has faded.
#[pass(name = "weigh.seen", over = params.pixel_count(), work = Guide)]
pub fn weigh_seen(
    pixel: u32,
    params: &FrameParams,
    path_radiance: &[Vec3],
    #[len = params.pixel_count()] mut pixel_sums: Slots<'_, PixelSum>,
) {
    let before = pixel_sums.read(pixel);
    let keep = kept(before.path_frames, params);
    let now = PixelSum {
        path: before.path * keep + mean(path_radiance[pixel as usize]).min(MAX_LIGHT),
        path_frames: before.path_frames * keep + 1.0,
        caustics: before.caustics * keep,
        caustic_frames: before.caustic_frames * keep,
    };
    pixel_sums.write(pixel, now);
}

/// Adds what light paths brought to each pixel.
#[pass(name = "weigh.learn", over = params.pixel_count(), work = Guide)]
pub fn weigh_learn(
    pixel: u32,
    caustic_radiance: &[Vec3],
    #[len = params.pixel_count()] mut pixel_sums: Slots<'_, PixelSum>,
) {
    let sum = pixel_sums.read(pixel);
    let caustics = sum.caustics + mean(caustic_radiance[pixel as usize]).min(MAX_LIGHT);
    pixel_sums.write(pixel, PixelSum { caustics, caustic_frames: sum.caustic_frames + 1.0, ..sum });
}

/// The mean light of each pixel; at level 1 the pilot of the frame counts as the part of a frame that it is.
#[pass(name = "weigh.means", over = params.pixel_count(), work = Guide)]
pub fn weigh_means(
    pixel: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    #[len = params.pixel_count() * accumulator::WORDS] accumulator: &[u32],
    pixel_sums: &[PixelSum],
    #[len = params.pixel_count()] mut pixel_means: Slots<'_, f32>,
) {
    let mut sum = pixel_sums[pixel as usize];
    let point = &point_geometry[pixel as usize];
    if dispatch.level > 0 {
        if point.exists() {
            let (pilot, _) = GatheredSum::read(accumulator, pixel, params.quantum);
            sum.caustics += mean(estimate_radiance(point, &point_shading[pixel as usize], pilot));
        }
        sum.caustic_frames += 1.0 / PILOT as f32;
    }
    pixel_means.write(pixel, sum.mean());
}

/// The mean light of each row; at level 1 that of the image, and behind it the square of what it was relative to it.
#[pass(name = "weigh.rows", over = params.height, work = Guide)]
pub fn weigh_rows(
    row: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    pixel_means: &[f32],
    #[len = params.height + 2] mut image_rows: Slots<'_, f32>,
) {
    let count = if dispatch.level == 0 { params.width } else { params.height };
    let mut sum = 0.0;
    let mut index = 0;
    while index < count {
        sum += if dispatch.level == 0 {
            pixel_means[(row * params.width + index) as usize]
        } else {
            image_rows.read(index)
        };
        index += 1;
    }
    let mean = sum / count as f32;
    if dispatch.level == 0 {
        image_rows.write(row, mean);
    } else {
        let ratio = if mean > 0.0 { image_rows.read(params.height) / mean } else { 1.0 };
        image_rows.write(params.height, mean);
        image_rows.write(params.height + 1, ratio * ratio);
    }
}

/// How much an error of each pixel counts: 1 / (its light, or that around it, squared), or that of what is dark beside the image's mean.
#[pass(name = "weigh.pixels", over = params.pixel_count(), work = Guide)]
pub fn weigh_pixels(
    pixel: u32,
    params: &FrameParams,
    pixel_means: &[f32],
    image_rows: &[f32],
    #[len = params.pixel_count()] mut pixel_weights: Slots<'_, f32>,
) {
    // Of few light paths, most pixels saw none.
    let sum = params.sum_around(pixel, AROUND, |other| Vec2::new(pixel_means[other as usize], 1.0));
    let light = (sum.x / sum.y).max(pixel_means[pixel as usize]);
    let dark = DARK * image_rows[params.height as usize];
    let square = light * light + dark * dark;
    pixel_weights.write(pixel, if square > MIN_SQUARE { 1.0 / square } else { 0.0 });
}
