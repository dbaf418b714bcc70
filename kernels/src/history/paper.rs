//! `reuse.paper`: reuses light of the previous frame's collection points as published [Moreau and Doggett 2022]. The mean of all
//! points that overlap has a fixed share in the blend.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{History, Step};
use crate::history::reprojected::ReprojectedPoint;
#[cfg(not(target_arch = "spirv"))]
use crate::history::resolve_history::RESOLVE_HISTORY;
use crate::history::window::{Look, PreviousFrame, WIDE_HALF_WIDTH, for_each_around, project, seen_from};
use crate::interface::frame::FrameParams;
#[cfg(not(target_arch = "spirv"))]
use crate::interface::history::HistorySettings;
use crate::interface::history::{HistoryPoint, Reprojected};
use crate::interface::instance::Instance;
use crate::interface::point::{PointGeometry, PointShading};
use crate::platform::Slots;
use spirv_std::glam::Vec3;

/// Width of the paper's weights, in radii.
const PAPER_SIGMA: f32 = 0.75;
/// Number of frames that a share of 0.8 in the blend is worth: 0.8 / 0.2.
const PAPER_SAMPLES: f32 = 4.0;
/// Cosine below which discs cross several pixels.
const MIN_SAME_SIZE_COS: f32 = 0.3;

#[cfg(not(target_arch = "spirv"))]
/// OurTemporal as published: always 0.8 of the mean of the previous points that overlap, and 0.2 of this frame's light.
pub const PAPER: History = History {
    name: "paper",
    description: "OurTemporal as published: 0.8 of the overlapping points of the last frame, 0.2 of this frame",
    cost: "searches nine records of 32 bytes a point; 76 bytes of state a point",
    limitations: "the variance falls to a ninth and no further; light that is gone stays for 20 frames; repeated means blur; \
            reuse of radiance smears textures and glossy lobes",
    settings: Some(HistorySettings { search_radius: 1.0, lag: 0.0, max_samples: 0.0, demodulates: 0 }),
    before: |params| vec![Step::new(&REUSE_PAPER, params)],
    resolve: &RESOLVE_HISTORY,
    forget: &[],
    keeps: &["history_points", "history_mean"],
    validates: false,
};

/// Reuses light as published, a pixel an invocation.
#[pass(name = "reuse.paper", over = params.pixel_count(), work = Reuse)]
pub fn reuse_paper(
    pixel: u32,
    params: &FrameParams,
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    instances: &[Instance],
    history_points: &[HistoryPoint],
    history_mean: &[Vec3],
    mut reprojected: Slots<'_, Reprojected>,
) {
    let (point, shading) = (&point_geometry[pixel as usize], &point_shading[pixel as usize]);
    let history = PreviousFrame { points: history_points, light: history_mean };
    let found = overlapping(pixel, point, shading, instances, history, params);
    reprojected.write(pixel, Reprojected { radius: point.radius, ..found });
}

/// Mean over all previous points whose disc holds this point, with a share of 0.8 in the blend. The weights are `exp(-d^2 / (2
/// (0.75 R)^2))`.
#[inline(always)]
fn overlapping(
    pixel: u32,
    point: &PointGeometry,
    shading: &PointShading,
    instances: &[Instance],
    history: PreviousFrame<'_>,
    params: &FrameParams,
) -> Reprojected {
    if !point.exists() {
        return Reprojected::default();
    }
    let reprojected_point = ReprojectedPoint::new(point, shading, instances);
    let mut visit = Overlap { reprojected_point, sum: Vec3::ZERO, weights: 0.0 };
    let before = &params.previous_camera;
    let at =
        project(seen_from(before, pixel, point, shading, reprojected_point.position, params), before, params);
    // Discs are 0.56 pixels wide head on, and 2.5 across where they lie flat.
    let half = if shading.to_viewer.dot(point.normal) < MIN_SAME_SIZE_COS { WIDE_HALF_WIDTH } else { 1 };
    for_each_around(at, half, params, history, &mut visit);
    if visit.weights <= 0.0 && point.depth > 1 {
        for_each_around(at, WIDE_HALF_WIDTH, params, history, &mut visit);
    }
    if visit.weights <= 0.0 {
        return Reprojected::default();
    }
    Reprojected { mean: visit.sum / visit.weights, samples: PAPER_SAMPLES, ..Reprojected::default() }
}

/// Sum over the points that overlap.
struct Overlap {
    reprojected_point: ReprojectedPoint,
    sum: Vec3,
    weights: f32,
}

impl Look for Overlap {
    #[inline(always)]
    fn look(&mut self, history: PreviousFrame<'_>, pixel: u32) {
        let history_point = history.points[pixel as usize];
        let along = history_point.position - self.reprojected_point.position;
        let square = along.length_squared();
        if history_point.samples > 0.0
            && square <= history_point.radius * history_point.radius
            && history_point.material == self.reprojected_point.material
            && self.reprojected_point.accepts(&history_point, along)
        {
            let width = PAPER_SIGMA * self.reprojected_point.radius;
            let weight = (-0.5 * square / (width * width)).exp();
            self.sum += history.light[pixel as usize] * weight;
            self.weights += weight;
        }
    }
}
