//! `balance.*`: how many light paths the next frame shoots, so that its time serves the image best.
//!
//! A frame whose camera paths cost C leaves the variance V, and n light paths that cost c each leave A / n. What the time of
//! a frame buys, (V + A / n) (C + n c), is least at n^2 = A C / (V c). V is measured by the distances of pixels from
//! their neighbours, A by the squares of photons, costs are counted: no clock is asked, so that a run repeats to the bit.
//! What is found in a frame is for those after it, so that every frame is unbiased and frames may be averaged. What a history
//! reuses for caustics is not seen: with one, fewer light paths would do.

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

/// The number of light paths of the next frame.
#[cfg(not(target_arch = "spirv"))]
pub const BALANCE: FrameStage = FrameStage {
    after_resolve: |params| vec![Step::new(&BALANCE_ROWS, params), Step::new(&BALANCE_PATHS, params)],
    keeps: &["balance"],
    needs: &[&WEIGH],
    ..FrameStage::new("balance")
};

/// Share of what earlier frames of a still view said that counts on: eight frames even out what one sees of rare paths.
const KEEP: f32 = 0.875;
/// What a ray of a light path costs, its start and its photons included (rays of camera paths). This and what follows were
/// measured on a CPU, in six scenes.
const LIGHT_RAY: f32 = 2.3;
/// What a photon costs that is stored and searched with (rays of camera paths).
const PHOTON: f32 = 1.0;
/// What a pair of photon and point costs (rays of camera paths).
const PAIR: f32 = 0.6;
/// What is above this is no variance: light without bounds.
const MAX_VARIANCE: f32 = 1.0e30;
/// Numbers of light paths are powers of this, so that roundings of a device seldom decide.
const GRAIN: f32 = core::f32::consts::SQRT_2;

/// For each row the variance of what camera paths and what light paths found, as means over its pixels: of camera paths by the
/// distance from neighbours, of light paths by their photons.
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
            // The sum of the squares of equal photons. What the camera chose is the same for all of them, so that its noise,
            // which no number of light paths lowers, is not in it.
            caustics = light * light / count.max(1) as f32;
        }
        sum += Vec2::new(path, caustics) * pixel_weights[pixel as usize];
        column += 1;
    }
    balance_rows.write(row, sum / params.width as f32);
}

/// The square of a pixel's distance from the mean of the two beside it, or of those above and below, the lesser: an edge along
/// either axis is in one of them, noise in both. Of rare bright samples it is the variance; of normal ones less, by a fifth; of
/// what a denoiser has spread, less than that.
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

/// The light paths of the next frame: as many as of this one where it shows nothing to judge by.
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
    let mut variance = Vec2::ZERO;
    let mut row = 0;
    while row < params.height {
        variance += balance_rows[row as usize] / params.height as f32;
        row += 1;
    }
    let mut next = balance.read(0);
    if next.light_paths == 0 {
        next.light_paths = params.light_path_count;
    }
    let seen = variance.x + variance.y * light_paths;
    // What emissions bring that know nothing yet says nothing of those after it, nor does black.
    if pixel_sums[0].path_frames > 1.0 && seen > 0.0 && seen < MAX_VARIANCE {
        let keep = if params.moved != 0 { FADE } else { KEEP };
        // Of validation paths, which start by power, few go on behind what they meet first.
        let validation_cost = LIGHT_RAY * params.validation_path_count as f32;
        let camera_cost = count(Counter::CameraRays) + count(Counter::ShadowRays) + validation_cost;
        let light_cost =
            light_cost(count(Counter::LightRays), count(Counter::Photons), count(Counter::Gathered));
        next.path_variance = next.path_variance * keep + variance.x;
        next.caustic_variance = next.caustic_variance * keep + variance.y * light_paths;
        next.camera_cost = next.camera_cost * keep + camera_cost;
        next.light_cost = next.light_cost * keep + light_cost / light_paths;
        let pixels = params.pixel_count();
        // Divide twice: products may overflow.
        let ratio = next.caustic_variance / next.path_variance * (next.camera_cost / next.light_cost);
        let best = if next.path_variance > 0.0 { ratio.sqrt() } else { (pixels * MAX_PATHS) as f32 };
        next.light_paths = grain(best, pixels);
    }
    balance.write(0, next);
}

/// What so many rays of light paths, photons, and pairs of photon and point cost (rays of camera paths).
#[inline(always)]
pub fn light_cost(rays: f32, photons: f32, pairs: f32) -> f32 {
    LIGHT_RAY * rays + PHOTON * photons + PAIR * pairs
}

/// The number of light paths within the bounds that is nearest to the best.
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
