//! Directional lights: parallel light from infinitely far away. Its paths start on a disc before the whole scene. The host makes
//! the disc as wide as the scene is seen from there.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::features::Features;
use crate::interface::light::Light;
use crate::interface::ray::Ray;
use crate::interface::scene::SceneTables;
use crate::light::emit::{EmissionSample, EvaluatedEmission};
use crate::light::light_sampling::LightSample;
use crate::math::PI;
use crate::math::frame::ShadingFrame;
use crate::math::trig::sin_cos_turns;
use spirv_std::glam::{Vec3, Vec4};

/// Samples the start of a path uniformly over the disc (m). Returns it, and the disc's area (m^2).
#[inline(always)]
pub fn sample(light: &Light, u: f32, v: f32) -> (Vec3, f32) {
    let frame = ShadingFrame::new(light.direction);
    let (sin, cos) = sin_cos_turns(v);
    let across = (frame.x * cos + frame.y * sin) * (u.sqrt() * light.radius);
    (light.position + across, area(light))
}

/// Area of the disc (m^2).
#[inline(always)]
fn area(light: &Light) -> f32 {
    PI * light.radius * light.radius
}

/// Samples the start of a light path along the light's direction (pbrt: `SampleLe`).
#[inline(always)]
pub fn sample_emission(
    light: &Light,
    _scene: SceneTables<'_>,
    _features: Features,
    u_position: Vec4,
    _direction: Vec4,
) -> EmissionSample {
    start(light, sample(light, u_position.z, u_position.w).0)
}

#[inline(always)]
fn start(light: &Light, origin: Vec3) -> EmissionSample {
    let area = area(light) / light.pdf_light_choice;
    let sample = EmissionSample::new(Ray::endless(origin, light.direction), light.emission * area, 0.0);
    EmissionSample { area, ..sample }
}

/// Evaluates the start of a light path at an offset from the middle of the disc (m). Its density is 0 outside of the disc, where
/// the light meets nothing.
#[inline(always)]
pub fn eval_emission(
    light: &Light,
    _scene: SceneTables<'_>,
    _features: Features,
    _u_position: Vec4,
    offset: Vec3,
) -> EvaluatedEmission {
    let on_disc = offset.length_squared() <= light.radius * light.radius;
    let pdf = if on_disc { 1.0 / area(light) } else { 0.0 };
    EvaluatedEmission { sample: start(light, light.position + offset), pdf }
}

/// Samples the light: the direction against its own, at infinite distance.
#[inline(always)]
pub fn sample_light(
    light: &Light,
    _scene: SceneTables<'_>,
    _features: Features,
    position: Vec3,
    _u: f32,
    _v: f32,
) -> LightSample {
    LightSample {
        to_light: -light.direction,
        radiance_over_pdf: light.emission / light.pdf_light_choice,
        endless: true,
        ..LightSample::none(position)
    }
}
