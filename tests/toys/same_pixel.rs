//! `reuse.same_pixel`: every point borrows from the same pixel of the frame before: a toy that shows all that a history
//! consists of.

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{History, Step};
#[cfg(not(target_arch = "spirv"))]
use crate::history::resolve_history::RESOLVE_HISTORY;
#[cfg(not(target_arch = "spirv"))]
use crate::interface::history::HistorySettings;
use crate::interface::history::{HistoryPoint, Reprojected};
use crate::interface::point::PointGeometry;
use crate::seam::Slots;
use spirv_std::glam::Vec3;

#[cfg(not(target_arch = "spirv"))]
/// See the head of the file.
pub const SAME_PIXEL: History = History {
    name: "same-pixel",
    about: "half of the same pixel's last light: a toy",
    cost: "a read of 44 bytes a pixel",
    wrong: "wherever anything moves",
    settings: Some(HistorySettings { reach: 1.0, lag: 0.0, most_samples: 1.0, demodulates: 0 }),
    before: |params| vec![Step::of(&REUSE_SAME_PIXEL, params)],
    resolve: &RESOLVE_HISTORY,
    forget: &[],
    keeps: &["history_points", "history_mean"],
};

/// What is lent, a pixel an invocation.
#[pass(name = "reuse.same_pixel", over = params.pixel_count(), work = Reuse)]
pub fn reuse_same_pixel(
    pixel: u32,
    point_geometry: &[PointGeometry],
    history_points: &[HistoryPoint],
    history_mean: &[Vec3],
    mut reprojected: Slots<'_, Reprojected>,
) {
    let mut lent = Reprojected::default();
    if point_geometry[pixel as usize].exists() && history_points[pixel as usize].samples > 0.0 {
        lent = Reprojected { mean: history_mean[pixel as usize], samples: 1.0, offset: Vec3::ZERO };
    }
    reprojected.write(pixel, lent);
}
