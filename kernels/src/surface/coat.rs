//! The dielectric's coat: GGX reflection over the base, which gets what the coat lets through (glTF `fresnel_mix`).

use crate::interface::material::Material;
use crate::surface::fresnel;

/// Share reflected at this cosine: Schlick from ((n-1)/(n+1))^2, scaled by the specular factor.
#[inline]
pub fn reflectance(material: &Material, cos: f32) -> f32 {
    let ratio = (material.ior - 1.0) / (material.ior + 1.0);
    let f0 = ratio * ratio;
    material.specular * (f0 + (1.0 - f0) * fresnel::schlick_weight(cos))
}

/// f [1/sr]; `facets` = D G / (4 cos cos).
#[inline]
pub fn eval(material: &Material, facets: f32, cos_half: f32) -> f32 {
    reflectance(material, cos_half) * facets
}
