//! `reuse`: the light that collection points of the frame before lend to one of today's.
//!
//! `reuse.paper` is the paper's: the mean of all points that overlap, with a fixed share in the blend. `reuse.validated`
//! takes the nearest point, since means over neighbours blur more with every frame, and lets it count as many frames as it
//! holds, less where validation paths saw the light change.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::gather::contribution::{DISC_THICKNESS, MIN_NORMAL_COS};
use crate::interface::frame::FrameParams;
use crate::interface::history::{HistoryPoint, HistorySettings, Lent};
use crate::interface::instance::Instance;
use crate::interface::material::Material;
use crate::interface::needs::Needs;
use crate::interface::point::{PointGeometry, PointShading};
use crate::math::octahedral;
use crate::reuse::cells::{self, Carrier, Change};
use crate::reuse::window::{History, Look, WIDE, for_each_around, project, seen_from};
use crate::surface::class::{self, Classes};
use crate::surface::textured::material_of;
use spirv_std::glam::Vec3;

/// Width of the paper's weights, relative to the radius.
const PAPER_SIGMA: f32 = 0.75;
/// Frames' worth of a share of 0.8 in the blend: 0.8 / 0.2.
const PAPER_SAMPLES: f32 = 4.0;
/// Radii of lender and borrower differ at most by this factor.
const MOST_RADIUS_RATIO: f32 = 1.5;
/// A lender this near, relative to the radius, is nearer than any other: half a pixel.
const NEAR: f32 = 0.85;
/// Cosine below which discs cross several pixels.
const FLAT: f32 = 0.3;
/// Share of the light that is lost a frame, above which nothing is lent.
const MOST_LOST: f32 = 0.25;
/// Share of the light by which that of a place which fades may be late.
const MOST_LATE: f32 = 0.02;
/// Turn of the view that light of a glossy lobe stands, relative to the lobe's width (squared roughness).
const VIEW_LAG: f32 = 0.5;

/// A point of today where it was in the frame before.
#[derive(Clone, Copy)]
struct Borrower {
    position: Vec3,
    normal: Vec3,
    radius: f32,
    material: u32,
}

impl Borrower {
    #[inline(always)]
    fn new(point: &PointGeometry, shading: &PointShading, instances: &[Instance]) -> Self {
        let mut borrower = Borrower {
            position: point.position,
            normal: point.normal,
            radius: point.radius,
            material: shading.material,
        };
        if shading.instance != 0 {
            let motion = instances[shading.instance as usize].to_previous;
            borrower.position = motion.point(point.position);
            borrower.normal = motion.vector(point.normal).normalize();
        }
        borrower
    }

    /// Whether a point of the same surface lends, `along` away from it.
    #[inline(always)]
    fn accepts(&self, lender: &HistoryPoint, along: Vec3) -> bool {
        let normal = octahedral::decode(lender.normal);
        let normals = self.normal + normal;
        let height = along.dot(normals);
        let limit = DISC_THICKNESS * self.radius;
        self.normal.dot(normal) > MIN_NORMAL_COS
            && height * height <= limit * limit * normals.length_squared()
    }
}

/// `reuse.paper`: the mean over all previous points whose disc holds this one, weighted by exp(-d^2 / (2 (0.75 R)^2)),
/// with 0.8 of the blend [Moreau and Doggett 2022].
#[inline(always)]
pub fn paper(
    pixel: u32,
    point: &PointGeometry,
    shading: &PointShading,
    instances: &[Instance],
    history_points: &[HistoryPoint],
    history_mean: &[Vec3],
    settings: &HistorySettings,
    params: &FrameParams,
) -> Lent {
    if point.depth == 0 {
        return Lent::default();
    }
    let borrower = Borrower::new(point, shading, instances);
    let history = History { points: history_points, mean: history_mean };
    let mut visit = Overlap { borrower, sum: Vec3::ZERO, weights: 0.0 };
    let before = &settings.camera;
    let at = project(seen_from(before, pixel, point, shading, borrower.position, params), before, params);
    // Discs are 0.56 pixels wide head on, and 2.5 across where they lie flat.
    let half = if shading.to_viewer.dot(point.normal) < FLAT { WIDE } else { 1 };
    for_each_around(at, half, params, history, &mut visit);
    if visit.weights <= 0.0 && point.depth > 1 {
        for_each_around(at, WIDE, params, history, &mut visit);
    }
    if visit.weights <= 0.0 {
        return Lent::default();
    }
    Lent { mean: visit.sum / visit.weights, samples: PAPER_SAMPLES, offset: Vec3::ZERO }
}

/// Sums over the points that overlap.
struct Overlap {
    borrower: Borrower,
    sum: Vec3,
    weights: f32,
}

impl Look for Overlap {
    #[inline(always)]
    fn look(&mut self, history: History<'_>, pixel: u32) {
        let lender = history.points[pixel as usize];
        let along = lender.position - self.borrower.position;
        let square = along.length_squared();
        if lender.samples > 0.0
            && square <= lender.radius * lender.radius
            && lender.material == self.borrower.material
            && self.borrower.accepts(&lender, along)
        {
            let width = PAPER_SIGMA * self.borrower.radius;
            let weight = (-0.5 * square / (width * width)).exp();
            self.sum += history.mean[pixel as usize] * weight;
            self.weights += weight;
        }
    }
}

/// `reuse.validated`: the nearest previous point of the same surface, as many frames' worth as hold by what validation
/// paths saw, and by how far the view of a glossy lobe turned.
#[inline(always)]
pub fn validated(
    pixel: u32,
    point: &PointGeometry,
    shading: &PointShading,
    materials: &[Material],
    instances: &[Instance],
    history_points: &[HistoryPoint],
    history_mean: &[Vec3],
    validation_cells: &[u32],
    settings: &HistorySettings,
    params: &FrameParams,
    needs: Needs,
) -> Lent {
    if point.depth == 0 {
        return Lent::default();
    }
    // A mesh that moves carries its light along, or slides below it: whichever changed less.
    let mut borrower = Borrower::new(point, shading, instances);
    let carrier = Carrier::instance(shading.instance);
    let mut change = cells::change(validation_cells, borrower.position, carrier, params);
    if shading.instance != 0 {
        let carrier = Carrier::world_below(shading.instance);
        let below = cells::change(validation_cells, point.position, carrier, params);
        if most_samples(&below, settings) > most_samples(&change, settings) {
            change = below;
            borrower.position = point.position;
            borrower.normal = point.normal;
        }
    }
    let history = History { points: history_points, mean: history_mean };
    let mut visit = Nearest { borrower, pixel: 0, square: f32::MAX, reach: settings.reach, found: false };
    let before = &settings.camera;
    let at = project(seen_from(before, pixel, point, shading, borrower.position, params), before, params);
    for_each_around(at, 0, params, history, &mut visit);
    if !visit.is_near() {
        for_each_around(at, 1, params, history, &mut visit);
    }
    if !visit.found && point.depth > 1 {
        for_each_around(at, WIDE, params, history, &mut visit);
    }
    if !visit.found {
        return Lent::default();
    }
    let lender = history_points[visit.pixel as usize];

    let mut most = most_samples(&change, settings);
    let material = material_of(shading, materials, needs);
    if is_glossy(&material, params.specular_roughness) {
        let mut to_viewer = shading.to_viewer;
        if shading.instance != 0 {
            to_viewer = instances[shading.instance as usize].to_previous.vector(to_viewer).normalize();
        }
        let turn = (to_viewer - octahedral::decode(lender.to_viewer)).length();
        most = most.min(VIEW_LAG * material.roughness * material.roughness / turn.max(1.0e-9));
    }
    let samples = lender.samples.min(most);
    if samples <= 0.0 {
        return Lent::default();
    }
    Lent { mean: history_mean[visit.pixel as usize], samples, offset: lender.position - borrower.position }
}

/// Frames' worth that lent light counts at most, by how it changed.
///
/// Light that counts n frames is n frames late. What is late is not only blurred: where its old place is hidden by what
/// moved, as behind the wall of a ring that carries its caustic along, it is lost, frame by frame. No weighing of that loss
/// against noise is safe, so the lag itself is bounded, to a part of a disc for light that moves and to a part of its
/// brightness for light that fades; from a quarter a frame on a light went out, and nothing is kept. Validation paths alone
/// decide, with random numbers of their own: a choice that knew the noise of what it averages would be biased.
#[inline(always)]
fn most_samples(change: &Change, settings: &HistorySettings) -> f32 {
    let mut most = settings.most_samples;
    if change.lost > 0.0 {
        most = most.min(MOST_LATE * (1.0 / change.lost - 1.0 / MOST_LOST).max(0.0));
    }
    if change.moved > 0.0 {
        most = most.min(settings.lag / change.moved);
    }
    most
}

/// Whether what a point reflects depends on the view by more than a factor.
#[inline(always)]
fn is_glossy(material: &Material, specular_roughness: f32) -> bool {
    let reflects = material.metallic > 0.0 || material.specular > 0.0;
    reflects && class::reflection(material.roughness, specular_roughness) == Classes::NON_SPECULAR
}

/// Looks for the nearest point.
struct Nearest {
    borrower: Borrower,
    pixel: u32,
    square: f32,
    reach: f32,
    found: bool,
}

impl Nearest {
    /// Whether no other point is likely to be nearer.
    #[inline(always)]
    fn is_near(&self) -> bool {
        let near = NEAR * self.borrower.radius;
        self.square <= near * near
    }
}

impl Look for Nearest {
    #[inline(always)]
    fn look(&mut self, history: History<'_>, pixel: u32) {
        let lender = history.points[pixel as usize];
        let along = lender.position - self.borrower.position;
        let square = along.length_squared();
        let reach = self.reach * lender.radius;
        let (small, large) =
            (lender.radius.min(self.borrower.radius), lender.radius.max(self.borrower.radius));
        if square < self.square
            && lender.samples > 0.0
            && square <= reach * reach
            && large <= MOST_RADIUS_RATIO * small
            && lender.material == self.borrower.material
            && self.borrower.accepts(&lender, along)
        {
            self.pixel = pixel;
            self.square = square;
            self.found = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(lost: f32, moved: f32) -> f32 {
        let settings = HistorySettings { lag: 0.25, most_samples: 1024.0, ..Default::default() };
        most_samples(&Change { lost, moved }, &settings)
    }

    #[test]
    fn lent_light_is_late_by_a_part_of_a_disc_or_of_its_brightness() {
        assert_eq!(samples(0.0, 0.0), 1024.0);
        for moved in [0.001, 0.1, 2.5, cells::LONGEST] {
            assert!((samples(0.0, moved) * moved - 0.25).abs() < 1.0e-6, "{moved}");
        }
        for lost in [0.001, 0.02, 0.1, 0.2] {
            assert!(samples(lost, 0.0) * lost <= MOST_LATE);
            // Whatever says less counts.
            assert_eq!(samples(lost, 2.5), samples(lost, 0.0).min(0.1));
        }
        for lost in [0.25, 0.5, 1.0] {
            assert_eq!(samples(lost, 0.0), 0.0);
        }
    }
}
