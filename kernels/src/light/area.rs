//! Area lights: triangles that emit uniformly over their area, by the cosine. Light samples of a near triangle are uniform over
//! its solid angle [Arvo 1995]. Samples uniform over the area would find its nearest points too rarely for their contribution.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::features::Features;
use crate::interface::light::Light;
use crate::interface::ray::Ray;
use crate::interface::scene::SceneTables;
use crate::light::emit::{EmissionSample, EvaluatedEmission};
use crate::light::light_sampling::LightSample;
use crate::math::face::Face;
use crate::math::frame::ShadingFrame;
use crate::math::spherical_triangle::SphericalTriangle;
use crate::math::{PI, offset, warp};
use crate::texture::emission::emission_at;
use caustics_kernel_macros::shared;
use spirv_std::glam::{Vec2, Vec3, Vec4};

/// Largest squared distance of a near triangle's middle, over the square of its longer edge at the first corner.
const NEAR: f32 = 4.0;
/// Smallest solid angle that is sampled (sr). A smaller triangle is seen edge-on and gives little light.
const MIN_SOLID_ANGLE: f32 = 1.0e-3;

/// A point of a triangle.
struct TrianglePoint {
    /// Weights of the corners b and c.
    weights: Vec2,
    /// Position (m).
    position: Vec3,
}

impl TrianglePoint {
    #[shared]
    fn uniform(face: Face, u: f32, v: f32) -> TrianglePoint {
        TrianglePoint::new(face, warp::uniform_triangle(u, v))
    }

    /// Point of the triangle that a position sees in a direction; rounding is clamped to the triangle.
    #[shared]
    fn seen(face: Face, position: Vec3, direction: Vec3) -> TrianglePoint {
        let (edge_b, edge_c) = (face.b - face.a, face.c - face.a);
        let normal = edge_b.cross(edge_c);
        let mut weights = Vec2::ZERO;
        let approach = direction.dot(normal);
        if approach != 0.0 {
            let from_a = position - face.a;
            let met = from_a - direction * (from_a.dot(normal) / approach);
            let square = normal.length_squared();
            weights = Vec2::new(met.cross(edge_c).dot(normal), edge_b.cross(met).dot(normal)) / square;
            weights = weights.clamp(Vec2::ZERO, Vec2::ONE);
            weights /= (weights.x + weights.y).max(1.0);
        }
        TrianglePoint::new(face, weights)
    }

    #[inline(always)]
    fn new(face: Face, weights: Vec2) -> TrianglePoint {
        TrianglePoint {
            weights,
            position: face.a + (face.b - face.a) * weights.x + (face.c - face.a) * weights.y,
        }
    }
}

/// Triangle of a light in the world.
#[inline(always)]
fn face(light: &Light, scene: SceneTables<'_>, features: Features) -> Face {
    Face::new(scene, features, light.instance, light.triangle)
}

/// Samples the start of a light path from any side that emits (pbrt: `SampleLe`).
#[inline(always)]
pub fn sample_emission(
    light: &Light,
    scene: SceneTables<'_>,
    features: Features,
    u_position: Vec4,
    direction: Vec4,
) -> EmissionSample {
    let point = TrianglePoint::uniform(face(light, scene, features), u_position.z, u_position.w);
    let mut normal = light.direction;
    if light.sides == 2 && direction.z < 0.5 {
        normal = -normal;
    }
    let local = warp::cosine_hemisphere(direction.x, direction.y);
    start(light, scene, features, &point, normal, ShadingFrame::new(normal).to_world(local), local.z)
}

/// Start of a light path from the side of a point that `normal` is on. `cos` is the cosine of the direction with `normal`.
#[inline(always)]
fn start(
    light: &Light,
    scene: SceneTables<'_>,
    features: Features,
    point: &TrianglePoint,
    normal: Vec3,
    direction: Vec3,
    cos: f32,
) -> EmissionSample {
    let TrianglePoint { weights, position } = *point;
    let share = emission_at(scene, features, light.triangle, weights.x, weights.y, 0.0);
    let ray = Ray::endless(offset::leave(position, normal, normal, light.clearance), direction);
    let flux = light.emission * share * (PI * light.area * light.sides as f32 / light.pdf_light_choice);
    // Leave the choice of the triangle out of the solid angle: all triangles of an area light illuminate the same points.
    EmissionSample::new(ray, flux, PI / cos.max(1.0e-3))
}

/// Position on the light where a path starts (m).
#[inline(always)]
pub fn sample_position(light: &Light, scene: SceneTables<'_>, features: Features, u_position: Vec4) -> Vec3 {
    TrianglePoint::uniform(face(light, scene, features), u_position.z, u_position.w).position
}

/// Evaluates the start of a light path in a direction, from the side that it leaves.
#[inline(always)]
pub fn eval_emission(
    light: &Light,
    scene: SceneTables<'_>,
    features: Features,
    u_position: Vec4,
    direction: Vec3,
) -> EvaluatedEmission {
    let point = TrianglePoint::uniform(face(light, scene, features), u_position.z, u_position.w);
    let mut normal = light.direction;
    let mut cos = direction.dot(normal);
    if light.sides == 2 && cos < 0.0 {
        (normal, cos) = (-normal, -cos);
    }
    let sample = start(light, scene, features, &point, normal, direction, cos);
    EvaluatedEmission { sample, pdf: warp::cosine_hemisphere_pdf(cos) / light.sides as f32 }
}

/// Samples a point of the triangle for a position, on the side that it sees. Samples a near triangle by solid angle, others by
/// area.
#[inline(always)]
pub fn sample_light(
    light: &Light,
    scene: SceneTables<'_>,
    features: Features,
    position: Vec3,
    u: f32,
    v: f32,
) -> LightSample {
    let face = face(light, scene, features);
    if is_in_plane(light, face, position) {
        return LightSample::none(position);
    }
    let near = near(face, position);
    let (point, to_light, square);
    if near.solid_angle > 0.0 {
        to_light = near.sample(u, v);
        point = TrianglePoint::seen(face, position, to_light);
        // The density by solid angle needs no distance.
        square = 1.0;
    } else {
        point = TrianglePoint::uniform(face, u, v);
        let along = point.position - position;
        square = along.length_squared();
        to_light = along / square.sqrt();
    }
    let cos = -to_light.dot(light.direction);
    if square == 0.0 || cos == 0.0 || (cos < 0.0 && light.sides != 2) {
        return LightSample::none(position);
    }
    let pdf_solid_angle = density(light, near.solid_angle, square, cos);
    let share = emission_at(scene, features, light.triangle, point.weights.x, point.weights.y, 0.0);
    LightSample {
        target: offset::leave(point.position, light.direction, -to_light, light.clearance),
        to_light,
        radiance_over_pdf: light.emission * share / pdf_solid_angle,
        pdf_solid_angle,
        endless: false,
    }
}

/// Whether a position lies in the plane of a light, which does not light it. A sampled direction would consist of rounding errors.
#[inline(always)]
fn is_in_plane(light: &Light, face: Face, position: Vec3) -> bool {
    (position - face.a).dot(light.direction).abs() <= light.clearance
}

/// Spherical triangle that a near position sees; its solid angle is 0 where the triangle is not near. It depends on triangle and
/// position alone. A path that finds the light by scattering can therefore compute the density of light sampling at its last
/// vertex.
#[shared]
fn near(face: Face, position: Vec3) -> SphericalTriangle {
    let (a, b, c) = (face.a - position, face.b - position, face.c - position);
    let three_middles = (a + b + c).length_squared();
    let edge = (b - a).length_squared().max((c - a).length_squared());
    let mut seen = SphericalTriangle::default();
    if three_middles < 9.0 * NEAR * edge {
        let whole = SphericalTriangle::new(a, b, c);
        // The solid angle is NaN where the position is a corner.
        if whole.solid_angle > MIN_SOLID_ANGLE {
            seen = whole;
        }
    }
    seen
}

/// Density (1/sr) of light sampling from a position, at a point of a triangle light at this squared distance (m^2). It includes
/// the choice of the light (pbrt: `PDF_Li`).
#[inline(always)]
pub fn pdf_solid_angle(
    light: &Light,
    scene: SceneTables<'_>,
    features: Features,
    position: Vec3,
    square: f32,
    cos: f32,
) -> f32 {
    let face = face(light, scene, features);
    if is_in_plane(light, face, position) {
        return 0.0;
    }
    density(light, near(face, position).solid_angle, square, cos)
}

/// Density (1/sr) of light sampling: by the solid angle of a near triangle, else by area.
#[inline(always)]
fn density(light: &Light, solid_angle: f32, square: f32, cos: f32) -> f32 {
    if solid_angle > 0.0 {
        light.pdf_light_choice / solid_angle
    } else {
        light.pdf_light_choice / light.area * square / cos.abs()
    }
}
