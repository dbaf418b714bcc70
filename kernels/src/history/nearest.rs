//! The nearest collection point of the frame before that is on the same surface, and how long the view of it lets light count.

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

/// Radii of lender and borrower differ at most by this factor.
const MAX_RADIUS_RATIO: f32 = 1.5;
/// A lender this near, relative to the radius, is nearer than any other: half a pixel.
const NEAREST_RADII: f32 = 0.85;
/// Turn of the view that light of a glossy lobe stands, relative to the lobe's width (squared roughness).
const VIEW_LAG: f32 = 0.5;

/// Looks for the nearest point.
pub struct Nearest {
    /// The point that looks.
    pub borrower: ReprojectedPoint,
    /// Pixel of the nearest so far.
    pub pixel: u32,
    /// Whether there is one.
    pub found: bool,
    square: f32,
    search_radius: f32,
}

impl Nearest {
    /// None yet, up to so many radii of a lender away.
    #[inline(always)]
    pub fn new(borrower: ReprojectedPoint, search_radius: f32) -> Self {
        Nearest { borrower, pixel: 0, found: false, square: f32::MAX, search_radius }
    }

    /// Looks around a place in the frame before (px): in a wide window only where the point at `depth` is seen by specular events
    /// and none lends near by.
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

    /// Takes the point of a pixel, wherever it lies in it: further away than others may be.
    #[inline(always)]
    pub fn prefer<L>(&mut self, pixel: u32, history: PreviousFrame<'_, L>) {
        self.pixel = pixel;
        self.found = lends(&history.points[pixel as usize], &self.borrower, 2.0 * self.search_radius);
    }

    /// Whether no other point is likely to be nearer.
    #[inline(always)]
    fn is_near(&self) -> bool {
        let near = NEAREST_RADII * self.borrower.radius;
        self.square <= near * near
    }
}

impl<L> Look<L> for Nearest {
    #[inline(always)]
    fn look(&mut self, history: PreviousFrame<'_, L>, pixel: u32) {
        let lender = history.points[pixel as usize];
        let square = (lender.position - self.borrower.position).length_squared();
        if square < self.square && lends(&lender, &self.borrower, self.search_radius) {
            self.pixel = pixel;
            self.square = square;
            self.found = true;
        }
    }
}

/// Whether a point up to so many of its radii away lends: it has light, and is of the same surface, seen as closely.
#[inline(always)]
pub fn lends(lender: &HistoryPoint, borrower: &ReprojectedPoint, search_radius: f32) -> bool {
    let along = lender.position - borrower.position;
    let search_radius = search_radius * lender.radius;
    let (small, large) = (lender.radius.min(borrower.radius), lender.radius.max(borrower.radius));
    lender.samples > 0.0
        && along.length_squared() <= search_radius * search_radius
        && large <= MAX_RADIUS_RATIO * small
        && lender.material == borrower.material
        && borrower.accepts(lender, along)
}

/// Frames' worth that lent light counts at most, by how far the view of a glossy lobe turned.
#[inline(always)]
pub fn max_samples_by_view(
    lender: &HistoryPoint,
    shading: &PointShading,
    materials: &[Material],
    instances: &[Instance],
    params: &FrameParams,
    features: Features,
) -> f32 {
    let material = material_of(shading, materials, features);
    if !is_glossy(&material, params.specular_roughness) {
        return f32::MAX;
    }
    let mut to_viewer = shading.to_viewer;
    if shading.instance != 0 {
        to_viewer = instances[shading.instance as usize].to_previous.vector(to_viewer).normalize();
    }
    let turn = (to_viewer - octahedral::decode(lender.to_viewer)).length();
    VIEW_LAG * material.roughness * material.roughness / turn.max(1.0e-9)
}

/// Whether what a point reflects depends on the view by more than a factor.
#[inline(always)]
fn is_glossy(material: &Material, specular_roughness: f32) -> bool {
    let reflects = material.metallic > 0.0 || material.specular > 0.0;
    reflects && class::reflection(material.roughness, specular_roughness) == Classes::NON_SPECULAR
}
