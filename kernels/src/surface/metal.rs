//! Metal: GGX reflection with Schlick's Fresnel, base colour at normal incidence.

use crate::interface::material::Material;
use crate::math::mean;
use crate::surface::{Bsdf, fresnel};
use spirv_std::glam::Vec3;

/// Whether a material has this lobe.
#[inline]
pub fn occurs(material: &Material) -> bool {
    material.metallic > 0.0
}

/// Approximate share of flux that the lobe scatters.
#[inline(always)]
pub fn sampling_weight(bsdf: &Bsdf) -> f32 {
    let material = &bsdf.material;
    material.metallic * mean(fresnel::schlick(material.base_color, bsdf.to_previous.z))
}

/// f (1/sr); `facets` = D G / (4 cos cos).
#[inline(always)]
pub fn eval(bsdf: &Bsdf, facets: f32, cos_half: f32) -> Vec3 {
    fresnel::schlick(bsdf.material.base_color, cos_half) * (bsdf.material.metallic * facets)
}

/// Reflectance of a smooth surface.
#[inline(always)]
pub fn smooth(bsdf: &Bsdf) -> Vec3 {
    fresnel::schlick(bsdf.material.base_color, bsdf.to_previous.z) * bsdf.material.metallic
}
