//! `reuse.same_pixel`: a point reuses the light that the same pixel had in the last frame. An example that shows all that a history
//! consists of.

use caustics_kernels::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use caustics_kernels::declare::{History, Step};
#[cfg(not(target_arch = "spirv"))]
use caustics_kernels::history::resolve_history::RESOLVE_HISTORY;
#[cfg(not(target_arch = "spirv"))]
use caustics_kernels::interface::history::HistorySettings;
use caustics_kernels::interface::history::{HistoryPoint, Reprojected};
use caustics_kernels::interface::point::PointGeometry;
use caustics_kernels::platform::Slots;
use spirv_std::glam::Vec3;

/// Half of the light that the same pixel had in the last frame.
#[cfg(not(target_arch = "spirv"))]
pub const SAME_PIXEL: History = History {
    name: "same-pixel",
    description: "half of the same pixel's last light: an example",
    cost: "a read of 44 bytes a pixel",
    limitations: "wherever anything moves",
    settings: Some(HistorySettings { search_radius: 1.0, lag: 0.0, max_samples: 1.0, demodulates: 0 }),
    before: |params| vec![Step::new(&REUSE_SAME_PIXEL, params)],
    resolve: &RESOLVE_HISTORY,
    forget: &[],
    keeps: &["history_points", "history_mean"],
    validates: false,
};

/// Finds the light to reuse, a pixel an invocation.
#[pass(name = "reuse.same_pixel", over = params.pixel_count(), work = Reuse)]
pub fn reuse_same_pixel(
    pixel: u32,
    point_geometry: &[PointGeometry],
    history_points: &[HistoryPoint],
    history_mean: &[Vec3],
    mut reprojected: Slots<'_, Reprojected>,
) {
    let point = &point_geometry[pixel as usize];
    let mut found = Reprojected { radius: point.radius, ..Reprojected::default() };
    if point.exists() && history_points[pixel as usize].samples > 0.0 {
        (found.mean, found.samples) = (history_mean[pixel as usize], 1.0);
    }
    reprojected.write(pixel, found);
}
