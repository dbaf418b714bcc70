//! `balance.*`: chooses the number of light paths of the next frame, so that a frame's time reduces the noise most.
//!
//! Camera paths of a frame cost C and leave the variance V; n light paths at the cost c each leave A / n. The product of variance
//! and cost, (V + A / n) (C + n c), is smallest at n^2 = A C / (V c). V is measured by the differences of pixels from their
//! neighbours, A by the squares of photons. Costs are counted rather than timed, so that a run repeats to the bit. Later frames
//! use the result, so that every frame is unbiased and frames may be averaged.
//!
//! Limitations: light that a history reuses for caustics is not accounted for; with a history, fewer light paths would do.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{FrameStage, Step};
use crate::gather::accumulator::{self, GatheredSum};
use crate::interface::balance::{Balance, MAX_PATHS, MIN_PATHS};
use crate::interface::counters::{COUNTER_COUNT, Counter};
use crate::interface::frame::FrameParams;
use crate::interface::point::{PointGeometry, PointShading};
use crate::interface::seen::PixelSum;
use crate::math::mean;
use crate::pass::resolve::estimate_radiance;
use crate::pass::weigh::FADE;
#[cfg(not(target_arch = "spirv"))]
use crate::pass::weigh::WEIGH;
use crate::platform::Slots;
use spirv_std::glam::{Vec2, Vec3};

/// Stage that chooses the number of light paths of the next frame.
#[cfg(not(target_arch = "spirv"))]
pub const BALANCE: FrameStage = FrameStage {
    after_resolve: |params| vec![Step::new(&BALANCE_ROWS, params), Step::new(&BALANCE_PATHS, params)],
    keeps: &["balance"],
    needs: &[&WEIGH],
    ..FrameStage::new("balance")
};

/// Share of earlier measurements that counts on in a still view: eight frames average out rare paths.
pub const KEEP: f32 = 0.875;
/// Cost of a ray of a light path, its start and its photons included (rays of camera paths). This and the other costs were
/// measured on a CPU, in six scenes.
const LIGHT_RAY: f32 = 2.3;
/// Cost of a photon that is stored and searched with (rays of camera paths).
const PHOTON: f32 = 1.0;
/// Cost of a pair of photon and point (rays of camera paths).
const PAIR: f32 = 0.6;
/// Largest variance that is used; light without bounds is above it.
pub const MAX_VARIANCE: f32 = 1.0e30;
/// Ratio of neighbouring numbers of light paths, so large that roundings of a device seldom decide.
const GRAIN: f32 = core::f32::consts::SQRT_2;

/// Means over the pixels of each row: the variance of camera paths, by the difference from neighbours, and that of light paths,
/// by their photons.
#[pass(name = "balance.rows", over = params.height, work = Guide)]
pub fn balance_rows(
    row: u32,
    params: &FrameParams,
    path_radiance: &[Vec3],
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    #[len = params.pixel_count() * accumulator::WORDS] accumulator: &[u32],
    pixel_weights: &[f32],
    #[len = params.height] mut balance_rows: Slots<'_, Vec2>,
) {
    let mut sum = Vec2::ZERO;
    let mut column = 0;
    while column < params.width {
        let pixel = row * params.width + column;
        let path = square_from_neighbours(column, row, path_radiance, params);
        let point = &point_geometry[pixel as usize];
        let mut caustics = 0.0;
        if point.exists() {
            let (value, count) = GatheredSum::read(accumulator, pixel, params.quantum);
            let light = mean(estimate_radiance(point, &point_shading[pixel as usize], value));
            // Take the sum of the squares of equal photons. The camera path is the same for all of them: its noise, which no
            // number of light paths lowers, is left out.
            caustics = light * light / count.max(1) as f32;
        }
        sum += Vec2::new(path, caustics) * pixel_weights[pixel as usize];
        column += 1;
    }
    balance_rows.write(row, sum / params.width as f32);
}

/// Smaller square of two differences of a pixel. One is from the mean of the two pixels beside it, one from the mean of those
/// above and below. An edge along either axis is in one of them, noise in both. For rare bright samples the square is the
/// variance. For normal samples it is a fifth less, and for light that a denoiser has spread still less.
#[inline(always)]
fn square_from_neighbours(column: u32, row: u32, path_radiance: &[Vec3], params: &FrameParams) -> f32 {
    let light = |column: u32, row: u32| mean(path_radiance[(row * params.width + column) as usize]);
    let (left, right) = (column.max(1) - 1, (column + 1).min(params.width - 1));
    let (above, below) = (row.max(1) - 1, (row + 1).min(params.height - 1));
    let own = light(column, row);
    let across = own - 0.5 * (light(left, row) + light(right, row));
    let along = own - 0.5 * (light(column, above) + light(column, below));
    if params.width == 1 {
        along * along
    } else if params.height == 1 {
        across * across
    } else {
        (across * across).min(along * along)
    }
}

/// Chooses the light paths of the next frame. Keeps their number where this frame shows no usable variance.
#[pass(name = "balance.paths", over = 1, work = Guide)]
pub fn balance_paths(
    _index: u32,
    params: &FrameParams,
    #[len = COUNTER_COUNT as u32] counters: &[u32],
    pixel_sums: &[PixelSum],
    balance_rows: &[Vec2],
    #[len = 1] mut balance: Slots<'_, Balance>,
) {
    let light_paths = params.light_path_count as f32;
    let variance = mean_of_rows(balance_rows, params);
    let mut next = balance.read(0);
    if next.light_paths == 0 {
        next.light_paths = params.light_path_count;
    }
    let seen = variance.x + variance.y * light_paths;
    // Skip the first frame, whose emissions know nothing yet, and black images.
    if pixel_sums[0].path_frames > 1.0 && seen > 0.0 && seen < MAX_VARIANCE {
        let keep = if params.moved != 0 { FADE } else { KEEP };
        let (camera_cost, light_cost) = costs(counters, params);
        // Average variance and cost over frames
        next.path_variance = next.path_variance * keep + variance.x;
        next.caustic_variance = next.caustic_variance * keep + variance.y * light_paths;
        next.camera_cost = next.camera_cost * keep + camera_cost;
        next.light_cost = next.light_cost * keep + light_cost / light_paths;
        let pixels = params.pixel_count();
        // Minimise variance times cost: n^2 = A C / (V c). Divide twice: products may overflow.
        let ratio = next.caustic_variance / next.path_variance * (next.camera_cost / next.light_cost);
        let best = if next.path_variance > 0.0 { ratio.sqrt() } else { (pixels * MAX_PATHS) as f32 };
        next.light_paths = grain(best, pixels);
    }
    balance.write(0, next);
}

/// Mean over the rows of the image.
#[inline(always)]
pub fn mean_of_rows(rows: &[Vec2], params: &FrameParams) -> Vec2 {
    let mut mean = Vec2::ZERO;
    let mut row = 0;
    while row < params.height {
        mean += rows[row as usize] / params.height as f32;
        row += 1;
    }
    mean
}

/// Costs of the camera paths and of the light paths of a frame (rays of camera paths).
#[inline(always)]
pub fn costs(counters: &[u32], params: &FrameParams) -> (f32, f32) {
    let count = |counter: Counter| counters[counter as usize] as f32;
    // Few validation paths, which start by power, go on behind their first hit.
    let validation_cost = LIGHT_RAY * params.validation_path_count as f32;
    let camera_cost = count(Counter::CameraRays) + count(Counter::ShadowRays) + validation_cost;
    (camera_cost, light_cost(count(Counter::LightRays), count(Counter::Photons), count(Counter::Gathered)))
}

/// Cost of these numbers of rays of light paths, of photons, and of pairs of photon and point (rays of camera paths).
#[inline(always)]
pub fn light_cost(rays: f32, photons: f32, pairs: f32) -> f32 {
    LIGHT_RAY * rays + PHOTON * photons + PAIR * pairs
}

/// Number of light paths nearest to the best, on the grid of `GRAIN` within the bounds.
#[inline(always)]
fn grain(best: f32, pixels: u32) -> u32 {
    let max_paths = (pixels * MAX_PATHS) as f32;
    let mut paths = pixels as f32 * MIN_PATHS;
    let between = GRAIN.sqrt();
    while paths * between < best && paths * GRAIN <= max_paths {
        paths *= GRAIN;
    }
    (paths as u32).max(1)
}
