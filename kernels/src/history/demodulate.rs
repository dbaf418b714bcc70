//! Light without what a point reflects of it: what texels of different colours can reuse of each other.

use crate::gather::contribution::contribution;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::material::Material;
use crate::interface::point::{PhotonLight, PointShading};
use crate::surface::textured::material_of;
use spirv_std::glam::Vec3;

/// Reflectance below which light cannot be told from what a point reflects (1/sr).
pub const MIN_REFLECTANCE: f32 = 1.0e-4;

/// What a point reflects of light that comes from straight above (1/sr): of a Lambertian point its light is multiplied with
/// this, to the bit; of others, nearly.
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

/// Light over reflectance, of which a channel is at least `MIN_REFLECTANCE`; a channel that is not reflected is taken for the
/// mean of the others.
#[inline(always)]
pub fn demodulated(radiance: Vec3, reflectance: Vec3) -> Vec3 {
    let is_seen = |r: f32| if r >= MIN_REFLECTANCE { 1.0 } else { 0.0 };
    let seen = Vec3::new(is_seen(reflectance.x), is_seen(reflectance.y), is_seen(reflectance.z));
    let light = seen * radiance / reflectance.max(Vec3::splat(MIN_REFLECTANCE));
    let mean = light.element_sum() / seen.element_sum();
    light + (Vec3::ONE - seen) * mean
}
