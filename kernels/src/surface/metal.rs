//! Metal: GGX reflection with Schlick's Fresnel, base colour at normal incidence.

use crate::interface::material::Material;
use crate::surface::fresnel;
use spirv_std::glam::Vec3;

/// f (1/sr) of the metal's share; `facets` = D G / (4 cos cos).
#[inline]
pub fn eval(material: &Material, facets: f32, cos_half: f32) -> Vec3 {
    fresnel::schlick(material.base_color, cos_half) * (material.metallic * facets)
}
