//! Demodulation: light divided by the reflectance of its point, which texels of different colours can share.

use crate::gather::contribution::contribution;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::material::Material;
use crate::interface::point::{PhotonLight, PointShading};
use crate::surface::textured::material_of;
use spirv_std::glam::Vec3;

/// Minimum reflectance that light is divided by (1/sr).
pub const MIN_REFLECTANCE: f32 = 1.0e-4;

/// Reflectance of a point for light along its shading normal (1/sr). The light of a Lambertian point is multiplied with it, to
/// the bit; that of other points nearly.
#[inline(always)]
pub fn head_on(
    shading: &PointShading,
    materials: &[Material],
    params: &FrameParams,
    features: Features,
) -> Vec3 {
    let light = PhotonLight { to_light: shading.shading_normal, flux: Vec3::ONE, ..Default::default() };
    let material = material_of(shading, materials, features);
    contribution(shading, material, &light, params.specular_roughness, features)
}

/// Light over reflectance, of which at least one channel is `MIN_REFLECTANCE` or more. A channel below that gets the mean of the
/// others.
#[inline(always)]
pub fn demodulated(radiance: Vec3, reflectance: Vec3) -> Vec3 {
    let is_seen = |r: f32| if r >= MIN_REFLECTANCE { 1.0 } else { 0.0 };
    let seen = Vec3::new(is_seen(reflectance.x), is_seen(reflectance.y), is_seen(reflectance.z));
    let light = seen * radiance / reflectance.max(Vec3::splat(MIN_REFLECTANCE));
    let mean = light.element_sum() / seen.element_sum();
    light + (Vec3::ONE - seen) * mean
}
