//! Lambertian base under the coat: the same radiance in every direction, less what the coat takes.

use crate::interface::features::Features;
use crate::interface::material::Material;
use crate::math::{INV_PI, mean, warp};
use crate::surface::{Bsdf, coat};
use spirv_std::glam::Vec3;

/// Whether a material has this lobe.
#[inline]
pub fn occurs(material: &Material) -> bool {
    material.metallic < 1.0 && material.transmission < 1.0 && material.base_color.max_element() > 0.0
}

/// Approximate share of flux that the lobe scatters: base colour times what enters the coat.
#[inline(always)]
pub fn sampling_weight(bsdf: &Bsdf) -> f32 {
    let mut under_coat = 1.0;
    if bsdf.features.has(Features::COAT) {
        under_coat = 1.0 - coat::reflectance(&bsdf.material, bsdf.to_previous.z);
    }
    bsdf.opaque_share() * under_coat * mean(bsdf.material.base_color)
}

/// f = base colour / pi (1/sr), times the share that passes the coat.
#[inline(always)]
pub fn eval(bsdf: &Bsdf, direction: Vec3) -> Vec3 {
    let mut base = bsdf.opaque_share();
    if bsdf.features.has(Features::COAT) {
        base *= coat::base_share(&bsdf.material, bsdf.to_previous.z, direction.z);
    }
    bsdf.material.base_color * INV_PI * base
}

/// Samples a cosine-distributed direction.
#[inline(always)]
pub fn sample(_bsdf: &Bsdf, u: f32, v: f32) -> Vec3 {
    warp::cosine_hemisphere(u, v)
}

/// Density of `sample` (1/sr).
#[inline(always)]
pub fn pdf(_bsdf: &Bsdf, direction: Vec3) -> f32 {
    warp::cosine_hemisphere_pdf(direction.z)
}

/// Share of flux that the lobe scatters: base colour times what enters the coat. `coat::base_share` is normalised over the
/// cosine.
#[inline(always)]
pub fn albedo(bsdf: &Bsdf) -> Vec3 {
    let coated = coat::reflectance(&bsdf.material, bsdf.to_previous.z);
    bsdf.material.base_color * (bsdf.opaque_share() * (1.0 - coated))
}
