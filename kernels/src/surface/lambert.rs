//! Lambert: the same radiance in every direction.

use crate::interface::material::Material;
use crate::math::{INV_PI, warp};
use spirv_std::glam::Vec3;

/// f = base colour / pi (1/sr).
#[inline]
pub fn eval(material: &Material) -> Vec3 {
    material.base_color * INV_PI
}

/// A cosine-distributed direction.
#[inline]
pub fn sample(u: f32, v: f32) -> Vec3 {
    warp::cosine_hemisphere(u, v)
}

/// pdf_solid_angle of `sample`.
#[inline]
pub fn pdf(direction: Vec3) -> f32 {
    warp::cosine_hemisphere_pdf(direction.z)
}
