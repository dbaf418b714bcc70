//! `balance.*`: how many light paths the next frame shoots, so that its time serves the picture best.
//!
//! A frame whose camera paths cost C leaves the variance V, and n light paths that cost c each leave A / n. What the time of a
//! frame buys, (V + A / n) (C + n c), is least at n^2 = A C / (V c). V and A are measured as the distances of pixels from their
//! means over earlier frames, costs are counted: no clock is asked, so that a run repeats to the bit. What is found in a frame
//! is for those after it, so that every frame is unbiased and frames may be averaged.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::Step;
use crate::interface::balance::{Balance, LEAST_PATHS, MOST_PATHS};
use crate::interface::counters::{COUNTER_COUNT, Counter};
use crate::interface::frame::FrameParams;
use crate::interface::seen::PixelSum;
use crate::math::mean;
use crate::pass::weigh::FADE;
use crate::seam::Slots;
use spirv_std::glam::{Vec2, Vec3};

/// What outlives a frame, beside what `weigh` keeps.
#[cfg(not(target_arch = "spirv"))]
pub const KEPT: [&str; 1] = ["balance"];

/// Once a frame that shoots, after it is resolved.
#[cfg(not(target_arch = "spirv"))]
pub fn balance(params: &FrameParams) -> Vec<Step> {
    vec![Step::of(&BALANCE_ROWS, params), Step::of(&BALANCE_PATHS, params)]
}

/// Share of what earlier frames of a still view said that counts on: eight frames even out what one sees of rare paths.
const KEEP: f32 = 0.875;
/// What a ray of a light path costs, its start and its deposits included (rays of camera paths). This and what follows were
/// measured on a CPU, in six scenes.
const LIGHT_RAY: f32 = 2.3;
/// What a deposit costs that is stored and searched with (rays of camera paths).
const DEPOSIT: f32 = 1.0;
/// What a pair of deposit and point costs (rays of camera paths).
const PAIR: f32 = 0.6;
/// Numbers of light paths are powers of this, so that roundings of a device decide none.
const GRAIN: f32 = core::f32::consts::SQRT_2;

/// For each row, how far pixels are from what they showed before, by camera paths and by light paths: squares relative to what
/// they show, as means over the row.
#[pass(name = "balance.rows", over = params.height, work = Guide)]
pub fn balance_rows(
    row: u32,
    params: &FrameParams,
    path_radiance: &[Vec3],
    caustic_radiance: &[Vec3],
    pixel_sums: &[PixelSum],
    pixel_weights: &[f32],
    #[len = params.height] mut balance_rows: Slots<'_, Vec2>,
) {
    let mut sum = Vec2::ZERO;
    let mut column = 0;
    while column < params.width {
        let pixel = (row * params.width + column) as usize;
        let before = pixel_sums[pixel];
        // The mean of camera paths has this frame in it, that of light paths has not.
        let path = distance(mean(path_radiance[pixel]), before.path, before.path_frames);
        let caustics = distance(mean(caustic_radiance[pixel]), before.caustics, before.caustic_frames);
        sum += Vec2::new(path, caustics) * pixel_weights[pixel];
        column += 1;
    }
    balance_rows.write(row, sum / params.width as f32);
}

/// The square of the distance of a value from a mean; 0 without frames.
#[inline(always)]
fn distance(value: f32, sum: f32, frames: f32) -> f32 {
    if frames <= 0.0 {
        return 0.0;
    }
    let along = value - sum / frames;
    along * along
}

/// The light paths of the next frame.
#[pass(name = "balance.paths", over = 1, work = Guide)]
pub fn balance_paths(
    _index: u32,
    params: &FrameParams,
    #[len = COUNTER_COUNT as u32] counters: &[u32],
    pixel_sums: &[PixelSum],
    balance_rows: &[Vec2],
    #[len = 1] mut balance: Slots<'_, Balance>,
) {
    let count = |counter: Counter| counters[counter as usize] as f32;
    let light_paths = params.light_path_count as f32;
    let mut distance = Vec2::ZERO;
    let mut row = 0;
    while row < params.height {
        distance += balance_rows[row as usize] / params.height as f32;
        row += 1;
    }
    let mut next = balance.read(0);
    if next.light_paths == 0 {
        next.light_paths = params.light_path_count;
    }
    let (of_path, of_caustics) = (pixel_sums[0].path_frames, pixel_sums[0].caustic_frames);
    if of_path > 1.0 && of_caustics > 0.0 {
        // Of n values, one is on average (n - 1) / n of the variance from their mean, and another (n + 1) / n.
        let keep = if params.moved != 0 { FADE } else { KEEP };
        let path_variance = distance.x * of_path / (of_path - 1.0);
        let caustic_variance = distance.y * of_caustics / (of_caustics + 1.0) * light_paths;
        let camera_cost = count(Counter::CameraRays) + count(Counter::ShadowRays);
        let light_cost = LIGHT_RAY * count(Counter::LightRays)
            + DEPOSIT * count(Counter::Deposits)
            + PAIR * count(Counter::Gathered);
        next.path_variance = next.path_variance * keep + path_variance;
        next.caustic_variance = next.caustic_variance * keep + caustic_variance;
        next.camera_cost = next.camera_cost * keep + camera_cost;
        next.light_cost = next.light_cost * keep + light_cost / light_paths;
        // Divide twice: products may overflow.
        let ratio = next.caustic_variance / next.path_variance * (next.camera_cost / next.light_cost);
        let pixels = params.pixel_count();
        let best = if next.path_variance > 0.0 { ratio.sqrt() } else { (pixels * MOST_PATHS) as f32 };
        next.light_paths = grain(best, pixels);
    }
    balance.write(0, next);
}

/// The number of light paths within the bounds that is nearest to the best.
#[inline(always)]
fn grain(best: f32, pixels: u32) -> u32 {
    let most = (pixels * MOST_PATHS) as f32;
    let mut paths = pixels as f32 * LEAST_PATHS;
    let between = GRAIN.sqrt();
    while paths * between < best && paths * GRAIN <= most {
        paths *= GRAIN;
    }
    (paths as u32).max(1)
}
