//! Directional lights: parallel light from infinitely far away. Its paths start on a disc before the whole scene,
//! which the host makes just as wide as the scene is seen from there.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::light::Light;
use crate::math::PI;
use crate::math::frame::ShadingFrame;
use crate::math::trig::sin_cos_turns;
use spirv_std::glam::Vec3;

/// Where a path starts, uniform over the disc, and the disc's area (m^2).
#[inline(always)]
pub fn sample(light: &Light, u: f32, v: f32) -> (Vec3, f32) {
    let frame = ShadingFrame::new(light.direction);
    let (sin, cos) = sin_cos_turns(v);
    let across = (frame.x * cos + frame.y * sin) * (u.sqrt() * light.radius);
    (light.position + across, PI * light.radius * light.radius)
}
