//! A shine of matte surfaces at grazing angles, f = 0.3 (1 - cos) (1 - cos') / pi (1/sr). The example shows all parts of a diffuse
//! lobe.

use crate::interface::material::Material;
use crate::math::{INV_PI, PI, warp};
use crate::surface::Bsdf;
use spirv_std::glam::Vec3;

/// f at grazing angles (1/sr).
const MAX_F: f32 = 0.3 * INV_PI;

/// Whether a material has it.
#[inline]
pub fn occurs(material: &Material) -> bool {
    material.roughness == 1.0 && material.metallic == 0.0 && material.transmission == 0.0
}

#[inline(always)]
fn reflected(bsdf: &Bsdf) -> f32 {
    // The integral of (1 - cos) cos over directions is pi / 3.
    if occurs(&bsdf.material) { MAX_F * PI / 3.0 * (1.0 - bsdf.to_previous.z) } else { 0.0 }
}

/// Share of flux that the lobe scatters.
#[inline(always)]
pub fn sampling_weight(bsdf: &Bsdf) -> f32 {
    reflected(bsdf)
}

/// f (1/sr).
#[inline(always)]
pub fn eval(bsdf: &Bsdf, direction: Vec3) -> Vec3 {
    if !occurs(&bsdf.material) {
        return Vec3::ZERO;
    }
    Vec3::splat(MAX_F * (1.0 - bsdf.to_previous.z) * (1.0 - direction.z))
}

/// A cosine-distributed direction.
#[inline(always)]
pub fn sample(_bsdf: &Bsdf, u: f32, v: f32) -> Vec3 {
    warp::cosine_hemisphere(u, v)
}

/// pdf_solid_angle of `sample`.
#[inline(always)]
pub fn pdf(_bsdf: &Bsdf, direction: Vec3) -> f32 {
    warp::cosine_hemisphere_pdf(direction.z)
}

/// Share of flux that it scatters.
#[inline(always)]
pub fn albedo(bsdf: &Bsdf) -> Vec3 {
    Vec3::splat(reflected(bsdf))
}
