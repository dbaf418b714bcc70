//! The dielectric coat: GGX reflection over the base. The coat attenuates light that enters the base and light that leaves it.
//!
//! glTF's `fresnel_mix` scales the base by 1 - F(v.h), which gains energy at grazing angles (up to 1.8 over white). The product
//! below is reciprocal. With a smooth coat over a white base it reflects exactly the light that arrives [Ashikhmin and Shirley
//! 2000, section 2.2, with exact normalisation].

use crate::interface::material::Material;
use crate::surface::{Bsdf, fresnel};
use spirv_std::glam::Vec3;

/// Whether a material has this lobe.
#[inline]
pub fn occurs(material: &Material) -> bool {
    material.metallic < 1.0 && material.transmission < 1.0 && material.specular > 0.0
}

/// Reflectance at this cosine: Schlick from ((n-1)/(n+1))^2, scaled by the specular factor.
#[inline]
pub fn reflectance(material: &Material, cos: f32) -> f32 {
    let ratio = (material.ior - 1.0) / (material.ior + 1.0);
    let f0 = ratio * ratio;
    material.specular * (f0 + (1.0 - f0) * fresnel::schlick_weight(cos))
}

/// Approximate share of flux that the lobe scatters.
#[inline(always)]
pub fn sampling_weight(bsdf: &Bsdf) -> f32 {
    bsdf.opaque_share() * reflectance(&bsdf.material, bsdf.to_previous.z)
}

/// f (1/sr); `facets` = D G / (4 cos cos).
#[inline(always)]
pub fn eval(bsdf: &Bsdf, facets: f32, cos_half: f32) -> Vec3 {
    Vec3::splat(bsdf.opaque_share() * (reflectance(&bsdf.material, cos_half) * facets))
}

/// Reflectance of a smooth surface.
#[inline(always)]
pub fn smooth(bsdf: &Bsdf) -> Vec3 {
    Vec3::splat(bsdf.opaque_share() * reflectance(&bsdf.material, bsdf.to_previous.z))
}

/// Share of the base's own scattering that passes the coat both ways, for the cosines of both directions. It is (1 - F(viewer))
/// (1 - F(light)) over the mean of 1 - F: light thrown back inside scatters until it leaves.
#[inline]
pub fn base_share(material: &Material, cos_viewer: f32, cos_light: f32) -> f32 {
    let ratio = (material.ior - 1.0) / (material.ior + 1.0);
    let f0 = ratio * ratio;
    // The cosine-weighted mean of (1 - cos)^5 is 1/21.
    let mean = material.specular * (f0 + (1.0 - f0) * (1.0 / 21.0));
    (1.0 - reflectance(material, cos_viewer)) * (1.0 - reflectance(material, cos_light)) / (1.0 - mean)
}
