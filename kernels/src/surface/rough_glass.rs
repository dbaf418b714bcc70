//! Rough dielectric: GGX facets that reflect and refract by exact Fresnel [Walter et al. 2007], visible normals.
//!
//! Reflection shares the facets of the other reflections. All f here are those of flux, whose integral over cos is the
//! share that passes; radiance takes eta^2 besides (see `collect`). A rough thin wall passes its reflection lobe
//! mirrored through its plane, as glTF says.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::material::{FLAG_THIN, Material};
use crate::math::warp;
use crate::surface::{ggx, glass};
use spirv_std::glam::Vec3;

/// Interfaces that bend less are smooth: the normal that refracts one direction to another is lost in rounding.
const MIN_BEND: f32 = 0.01;

/// Whether the interface is rough. `eta` = index on the path's side over index behind.
#[inline]
pub fn is_rough(material: &Material, eta: f32) -> bool {
    let bends = material.flags & FLAG_THIN != 0 || (eta - 1.0).abs() > MIN_BEND;
    material.transmission > 0.0 && material.roughness >= ggx::DELTA_ROUGHNESS && bends
}

/// Chance to choose reflection: about what the visible facets reflect, never so near 0 or 1 that a rare facet of the
/// other kind would carry a large weight.
#[inline]
pub fn reflection_chance(material: &Material, cos: f32, eta: f32) -> f32 {
    let spread = ggx::alpha(material.roughness);
    let around = glass::reflectance(material, (cos - spread).max(0.0), eta)
        + glass::reflectance(material, cos, eta)
        + glass::reflectance(material, (cos + spread).min(1.0), eta);
    0.02 + 0.31 * around
}

/// f (1/sr) of transmission before tint, and pdf_solid_angle of `sample`, towards a direction behind (z < 0).
#[inline]
pub fn eval(material: &Material, to_previous: Vec3, direction: Vec3, eta: f32) -> (f32, f32) {
    let alpha = ggx::alpha(material.roughness);
    let mirrored = Vec3::new(direction.x, direction.y, -direction.z);
    let (mut half, mut stretch) = ((to_previous + mirrored).normalize(), 1.0);
    if material.flags & FLAG_THIN == 0 {
        // Snell's law at the facet: both directions' tangential parts cancel along this vector.
        let along = to_previous * eta + direction;
        let square = along.length_squared();
        half = along / square.sqrt();
        if half.z < 0.0 {
            half = -half;
        }
        let (cos, cos_behind) = (to_previous.dot(half), -direction.dot(half));
        if cos <= 0.0 || cos_behind <= 0.0 {
            return (0.0, 0.0);
        }
        // d half / d direction is cos_behind / |along|^2, where mirroring has 1 / (4 cos).
        stretch = 4.0 * cos * cos_behind / square;
    }
    let passed = 1.0 - glass::reflectance(material, to_previous.dot(half), eta);
    let f = passed * stretch * ggx::eval(to_previous, mirrored, half, alpha);
    (f, stretch * ggx::visible_pdf(to_previous, half, alpha))
}

/// A direction refracted at a visible facet. It may leave on the near side, and does where the facet reflects totally:
/// then nothing passes.
#[inline]
pub fn sample(material: &Material, to_previous: Vec3, eta: f32, u: f32, v: f32) -> Vec3 {
    let half = warp::visible_ggx_normal(to_previous, ggx::alpha(material.roughness), u, v);
    let cos = to_previous.dot(half);
    if material.flags & FLAG_THIN != 0 {
        let reflected = half * (2.0 * cos) - to_previous;
        return Vec3::new(reflected.x, reflected.y, -reflected.z);
    }
    let square = 1.0 - eta * eta * (1.0 - cos * cos);
    if square <= 0.0 {
        return to_previous;
    }
    (half * (eta * cos - square.sqrt()) - to_previous * eta).normalize()
}
