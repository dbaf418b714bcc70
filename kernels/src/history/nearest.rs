//! Temporal reprojection. The history sample of a collection point is the nearest collection point of the last frame on the same
//! surface. The change of the view limits how long its light counts.

use crate::history::reprojected::ReprojectedPoint;
use crate::history::window::{Look, PreviousFrame, WIDE_HALF_WIDTH, for_each_around};
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::history::HistoryPoint;
use crate::interface::instance::Instance;
use crate::interface::material::Material;
use crate::interface::point::PointShading;
use crate::math::octahedral;
use crate::surface::class::{self, Classes};
use crate::surface::textured::material_of;
use spirv_std::glam::Vec2;

/// Maximum ratio of the radii of history point and reprojected point.
const MAX_RADIUS_RATIO: f32 = 1.5;
/// Distance below which no other history point is likely to be nearer, relative to the radius: half a pixel.
const NEAREST_RADII: f32 = 0.85;
/// Maximum turn of the view for light of a glossy lobe, relative to the lobe's width (squared roughness).
const VIEW_LAG: f32 = 0.5;

/// Search for the nearest point.
pub struct Nearest {
    /// Point that looks for light to reuse.
    pub reprojected_point: ReprojectedPoint,
    /// Pixel of the nearest point so far.
    pub pixel: u32,
    /// Whether a point was found.
    pub found: bool,
    square: f32,
    search_radius: f32,
}

impl Nearest {
    /// Starts a search within a radius, in radii of the history point.
    #[inline(always)]
    pub fn new(reprojected_point: ReprojectedPoint, search_radius: f32) -> Self {
        Nearest { reprojected_point, pixel: 0, found: false, square: f32::MAX, search_radius }
    }

    /// Searches around a position in the previous frame (px). The wide window is used only for a point behind specular events
    /// (`depth` above 1) without a reusable point near by.
    #[inline(always)]
    pub fn search<L>(&mut self, at: Vec2, depth: u32, params: &FrameParams, history: PreviousFrame<'_, L>) {
        for_each_around(at, 0, params, history, self);
        if !self.is_near() {
            for_each_around(at, 1, params, history, self);
        }
        if !self.found && depth > 1 {
            for_each_around(at, WIDE_HALF_WIDTH, params, history, self);
        }
    }

    /// Takes the point of a pixel, at up to twice the search radius.
    #[inline(always)]
    pub fn prefer<L>(&mut self, pixel: u32, history: PreviousFrame<'_, L>) {
        self.pixel = pixel;
        self.found =
            is_reusable(&history.points[pixel as usize], &self.reprojected_point, 2.0 * self.search_radius);
    }

    /// Whether the point found is so near that another is unlikely to be nearer.
    #[inline(always)]
    fn is_near(&self) -> bool {
        let near = NEAREST_RADII * self.reprojected_point.radius;
        self.square <= near * near
    }
}

impl<L> Look<L> for Nearest {
    #[inline(always)]
    fn look(&mut self, history: PreviousFrame<'_, L>, pixel: u32) {
        let history_point = history.points[pixel as usize];
        let square = (history_point.position - self.reprojected_point.position).length_squared();
        if square < self.square && is_reusable(&history_point, &self.reprojected_point, self.search_radius) {
            self.pixel = pixel;
            self.square = square;
            self.found = true;
        }
    }
}

/// Whether a point with light is reusable: within a number of its radii, on the same surface, and of a similar radius.
#[inline(always)]
pub fn is_reusable(
    history_point: &HistoryPoint,
    reprojected_point: &ReprojectedPoint,
    search_radius: f32,
) -> bool {
    let along = history_point.position - reprojected_point.position;
    let search_radius = search_radius * history_point.radius;
    let (small, large) = (
        history_point.radius.min(reprojected_point.radius),
        history_point.radius.max(reprojected_point.radius),
    );
    history_point.samples > 0.0
        && along.length_squared() <= search_radius * search_radius
        && large <= MAX_RADIUS_RATIO * small
        && history_point.material == reprojected_point.material
        && reprojected_point.accepts(history_point, along)
}

/// Maximum number of frames that reused light counts, by the turn of the view of a glossy lobe. A still view has no
/// limit: it turns only within its pixels.
#[inline(always)]
pub fn max_samples_by_view(
    history_point: &HistoryPoint,
    shading: &PointShading,
    materials: &[Material],
    instances: &[Instance],
    params: &FrameParams,
    features: Features,
) -> f32 {
    let material = material_of(shading, materials, features);
    if params.moved == 0 || !is_glossy(&material, params.specular_roughness) {
        return f32::MAX;
    }
    let mut to_viewer = shading.to_viewer;
    if shading.instance != 0 {
        to_viewer = instances[shading.instance as usize].to_previous.vector(to_viewer).normalize();
    }
    let turn = (to_viewer - octahedral::decode(history_point.to_viewer)).length();
    VIEW_LAG * material.roughness * material.roughness / turn.max(1.0e-9)
}

/// Whether reflection depends on the view by more than a factor: a glossy lobe.
#[inline(always)]
fn is_glossy(material: &Material, specular_roughness: f32) -> bool {
    let reflects = material.metallic > 0.0 || material.specular > 0.0;
    reflects && class::reflection(material.roughness, specular_roughness) == Classes::NON_SPECULAR
}
