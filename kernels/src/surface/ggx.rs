//! GGX microfacets: Trowbridge-Reitz normals, height-correlated Smith shadowing [Heitz 2014], visible normals.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::math::PI;
use spirv_std::glam::Vec3;

/// Perceptual roughness below which reflections are delta lobes.
pub const DELTA_ROUGHNESS: f32 = 0.08;

/// Width alpha of GGX: the square of the perceptual roughness.
#[inline]
pub fn alpha(roughness: f32) -> f32 {
    roughness * roughness
}

/// Density D of microfacet normals (1/sr) at a unit local normal.
#[inline]
pub fn distribution(half: Vec3, alpha: f32) -> f32 {
    let square = alpha * alpha;
    // Compute 1 + cos^2 (a^2 - 1) as a sum: 1 - cos^2 would lose the peak of a narrow lobe.
    let t = square * half.z * half.z + half.x * half.x + half.y * half.y;
    square / (PI * t * t)
}

/// Lambda of Smith's shadowing for GGX [Heitz 2014].
#[inline]
fn lambda(cos: f32, alpha: f32) -> f32 {
    let cos2 = cos * cos;
    let tan2 = (1.0 - cos2).max(0.0) / cos2;
    0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0)
}

/// Height-correlated shadowing G = 1 / (1 + Lambda(viewer) + Lambda(light)): share of facets that see both directions, given by
/// their cosines.
#[inline]
pub fn shadowing(cos_viewer: f32, cos_light: f32, alpha: f32) -> f32 {
    1.0 / (1.0 + lambda(cos_viewer, alpha) + lambda(cos_light, alpha))
}

/// Microfacet reflection D G / (4 cos cos) (1/sr), without Fresnel.
#[inline]
pub fn eval(to_previous: Vec3, direction: Vec3, half: Vec3, alpha: f32) -> f32 {
    let shadowing = shadowing(to_previous.z, direction.z, alpha);
    distribution(half, alpha) * shadowing / (4.0 * to_previous.z * direction.z)
}

/// Density (1/sr) of directions mirrored at visible microfacet normals, in the direction of normal `half`.
#[inline]
pub fn visible_pdf(to_previous: Vec3, half: Vec3, alpha: f32) -> f32 {
    distribution(half, alpha) / ((1.0 + lambda(to_previous.z, alpha)) * 4.0 * to_previous.z)
}

/// Direction mirrored at a microfacet normal; may point below the surface.
#[inline]
pub fn mirrored(to_previous: Vec3, half: Vec3) -> Vec3 {
    half * (2.0 * to_previous.dot(half)) - to_previous
}
