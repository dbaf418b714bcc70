//! `weigh.*`: weights of an error of each pixel, by the light that the pixel showed. Emissions that learn use them, and the
//! balance of a frame's time. They depend on earlier frames and on passes before the light paths that use them.

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

/// Stage that weighs an error of each pixel.
#[cfg(not(target_arch = "spirv"))]
pub const WEIGH: FrameStage = FrameStage {
    // Add what camera paths found, and weigh pixels.
    before_light: |params| {
        let mut steps = vec![Step::new(&WEIGH_SEEN, params)];
        steps.extend(weigh(params, 0));
        steps
    },
    // Add what light paths brought.
    after_resolve: |params| vec![Step::new(&WEIGH_LEARN, params)],
    keeps: &["image_rows", "pixel_sums"],
    ..FrameStage::new("weigh")
};

/// Steps that weigh pixels, with the light that this frame has gathered so far (eighths of its light paths).
#[cfg(not(target_arch = "spirv"))]
pub fn weigh(params: &FrameParams, gathered: u32) -> Vec<Step> {
    vec![
        Step::level(&WEIGH_MEANS, gathered, params.pixel_count()),
        Step::level(&WEIGH_ROWS, 0, params.height),
        Step::level(&WEIGH_ROWS, 1, 1),
        Step::new(&WEIGH_PIXELS, params),
    ]
}

/// Share of earlier light that counts on where something moved.
pub const FADE: f32 = 0.5;

/// Share of the light of this number of frames that counts on: all of it in a still view. After something moved it is one half,
/// but at most the worth of one frame.
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

/// Light that is added to a pixel's in its weight, relative to the mean of the image. It bounds the weight of dark pixels.
const DARK: f32 = 0.1;
/// Squares of light below this have no inverse in an f32.
const MIN_SQUARE: f32 = 1.0e-37;
/// Largest light of a frame that counts (W m^-2 sr^-1): its square has an inverse.
pub const MAX_LIGHT: f32 = 1.0e15;
/// Number of pixels to each side over which the light of a pixel is averaged.
const AROUND: u32 = 2;

/// Lets earlier light fade, and adds the light of camera paths in each pixel.
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

/// Adds the light of light paths in each pixel.
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

/// Mean light of each pixel. The level is the number of light paths that this frame has gathered so far (eighths of all).
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
            let (gathered, _) = GatheredSum::read(accumulator, pixel, params.quantum);
            sum.caustics += mean(estimate_radiance(point, &point_shading[pixel as usize], gathered));
        }
        sum.caustic_frames += dispatch.level as f32 / PILOT as f32;
    }
    pixel_means.write(pixel, sum.mean());
}

/// Mean light of each row. Level 1 makes that of the image, and behind it the square of the last mean over this one.
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

/// Weight of an error of each pixel: 1 / (light^2 + dark^2). Light is the larger of the pixel's and the mean around it; dark is
/// `DARK` times the image's mean.
#[pass(name = "weigh.pixels", over = params.pixel_count(), work = Guide)]
pub fn weigh_pixels(
    pixel: u32,
    params: &FrameParams,
    pixel_means: &[f32],
    image_rows: &[f32],
    #[len = params.pixel_count()] mut pixel_weights: Slots<'_, f32>,
) {
    // Average over the pixels around: with few light paths, most pixels see none.
    let sum = params.sum_around(pixel, AROUND, |other| Vec2::new(pixel_means[other as usize], 1.0));
    let light = (sum.x / sum.y).max(pixel_means[pixel as usize]);
    let dark = DARK * image_rows[params.height as usize];
    let square = light * light + dark * dark;
    pixel_weights.write(pixel, if square > MIN_SQUARE { 1.0 / square } else { 0.0 });
}
