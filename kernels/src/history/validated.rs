//! `reuse.validated`: temporal reuse by reprojection (`nearest.rs`). It takes the light of the nearest collection point of the
//! last frame, as means over neighbours blur more with every frame. The light counts as many frames as it holds, and fewer where
//! validation paths saw it change.

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{History, Step};
use crate::history::cells::{self, Change, LightFrame};
use crate::history::nearest::{Nearest, max_samples_by_view};
use crate::history::reprojected::ReprojectedPoint;
#[cfg(not(target_arch = "spirv"))]
use crate::history::resolve_history::RESOLVE_HISTORY;
use crate::history::window::{PreviousFrame, project, seen_from};
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::history::{HistoryPoint, HistorySettings, Reprojected};
use crate::interface::instance::Instance;
use crate::interface::material::Material;
use crate::interface::point::{PointGeometry, PointShading};
use crate::platform::Slots;
use spirv_std::glam::Vec3;

pub mod validate;

#[cfg(not(target_arch = "spirv"))]
use validate::VALIDATE;

/// Share of light lost in a frame above which nothing is reused.
const MAX_LOST: f32 = 0.25;
/// Maximum share of a fading position's light that is late. It is below the promised 0.02 for two reasons. Few paths see less of
/// a fade than there is, and paths of unlike flux scatter though they fade alike.
const MAX_LATE: f32 = 0.013;

#[cfg(not(target_arch = "spirv"))]
/// Light of the nearest previous point. It counts the frames that it holds, as far as light paths with the same random numbers
/// show that it still arrives.
pub const VALIDATED: History = History {
    name: "validated",
    description: "the mean of all frames that validation paths confirm, from the nearest point",
    cost: "as paper, and validation paths: an eighth of the light paths, or a quarter a pixel with --light-paths auto",
    limitations: "light that moves by more than about a disc a frame is as noisy as without a history; where validation paths leave few \
            photons, cells are large and changes in a part of a cell are detected late; motion is measured in radii of a direct \
            view, behind curved mirrors too",
    settings: Some(HistorySettings { search_radius: 1.3, lag: 0.25, max_samples: 1024.0, demodulates: 1 }),
    before: |params| {
        vec![
            Step::Clear { buffer: "validation_cells" },
            Step::new(&VALIDATE, params),
            Step::new(&REUSE_VALIDATED, params),
        ]
    },
    resolve: &RESOLVE_HISTORY,
    forget: &["history_points", "validation_photons"],
    keeps: &["history_points", "history_mean", "validation_photons"],
    validates: true,
};

/// Reuses light as far as it still holds, a pixel an invocation.
#[pass(name = "reuse.validated", over = params.pixel_count(), work = Reuse)]
pub fn reuse_validated(
    pixel: u32,
    params: &FrameParams,
    features: Features,
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    materials: &[Material],
    instances: &[Instance],
    history_points: &[HistoryPoint],
    history_mean: &[Vec3],
    validation_cells: &[u32],
    mut reprojected: Slots<'_, Reprojected>,
) {
    let (point, shading) = (&point_geometry[pixel as usize], &point_shading[pixel as usize]);
    let history = PreviousFrame { points: history_points, light: history_mean };
    let found =
        nearest(pixel, point, shading, materials, instances, history, validation_cells, params, features);
    reprojected.write(pixel, Reprojected { radius: point.radius, ..found });
}

/// Finds the light of the nearest previous point of the same surface. Validation paths and the turn of the view of a glossy lobe
/// limit the number of frames that it counts.
#[inline(always)]
fn nearest(
    pixel: u32,
    point: &PointGeometry,
    shading: &PointShading,
    materials: &[Material],
    instances: &[Instance],
    history: PreviousFrame<'_>,
    validation_cells: &[u32],
    params: &FrameParams,
    features: Features,
) -> Reprojected {
    let settings = &params.history;
    if !point.exists() {
        return Reprojected::default();
    }
    // A mesh that moves carries its light along, or slides below it: take the light that changed less.
    let mut reprojected_point = ReprojectedPoint::new(point, shading, instances);
    let carrier = LightFrame::instance(shading.instance);
    let mut change = cells::change(validation_cells, reprojected_point.position, carrier, params);
    if shading.instance != 0 {
        let carrier = LightFrame::world_below(shading.instance);
        let below = cells::change(validation_cells, point.position, carrier, params);
        if max_samples(&below, settings) > max_samples(&change, settings) {
            change = below;
            reprojected_point.position = point.position;
            reprojected_point.normal = point.normal;
        }
    }
    let mut visit = Nearest::new(reprojected_point, settings.search_radius);
    let before = &params.previous_camera;
    let at =
        project(seen_from(before, pixel, point, shading, reprojected_point.position, params), before, params);
    visit.search(at, point.depth, params, history);
    if !visit.found {
        return Reprojected::default();
    }
    let history_point = history.points[visit.pixel as usize];

    let by_view = max_samples_by_view(&history_point, shading, materials, instances, params, features);
    let samples = history_point.samples.min(by_view).min(max_samples(&change, settings));
    if samples <= 0.0 {
        return Reprojected::default();
    }
    Reprojected {
        mean: history.light[visit.pixel as usize],
        samples,
        offset: history_point.position - reprojected_point.position,
        ..Reprojected::default()
    }
}

/// Maximum number of frames that reused light counts, by its change.
///
/// Light that counts n frames is n frames late. Late light is not only blurred: it is lost, frame by frame, where a moved surface
/// hides its old position. An example is the wall of a ring that carries its caustic along. No weighing of that loss against
/// noise is safe, so the function bounds the lag itself. For light that moves, the bound is a part of a disc; for light that
/// fades, a part of its brightness. If a quarter or more is lost in a frame, a light went out, and nothing is kept.
///
/// Validation paths alone decide, with random numbers of their own: a choice that depends on the noise of what it averages would
/// be biased.
#[inline(always)]
fn max_samples(change: &Change, settings: &HistorySettings) -> f32 {
    let mut max = settings.max_samples;
    if change.lost > 0.0 {
        max = max.min(MAX_LATE * (1.0 / change.lost - 1.0 / MAX_LOST).max(0.0));
    }
    if change.moved > 0.0 {
        max = max.min(settings.lag / change.moved);
    }
    max
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(lost: f32, moved: f32) -> f32 {
        let settings = HistorySettings { lag: 0.25, max_samples: 1024.0, ..Default::default() };
        max_samples(&Change { lost, moved }, &settings)
    }

    #[test]
    fn reused_light_is_late_by_a_part_of_a_disc_or_of_its_brightness() {
        assert_eq!(samples(0.0, 0.0), 1024.0);
        for moved in [0.001, 0.1, 2.5, cells::MAX_STEP] {
            assert!((samples(0.0, moved) * moved - 0.25).abs() < 1.0e-6, "{moved}");
        }
        for lost in [0.001, 0.02, 0.1, 0.2] {
            assert!(samples(lost, 0.0) * lost <= MAX_LATE);
            // The smaller of both limits counts.
            assert_eq!(samples(lost, 2.5), samples(lost, 0.0).min(0.1));
        }
        for lost in [0.25, 0.5, 1.0] {
            assert_eq!(samples(lost, 0.0), 0.0);
        }
    }
}
