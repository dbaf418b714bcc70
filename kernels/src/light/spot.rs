//! Spot lights: the falloff of their cone, and directions into it (KHR_lights_punctual).
//!
//! Angles are carried as 1 - cos, taken from the length of a chord: cosines near 1 would leave a narrow cone few bits.

use crate::interface::features::Features;
use crate::interface::light::Light;
use crate::interface::ray::Ray;
use crate::interface::scene::SceneTables;
use crate::light::emit::{EmissionSample, EvaluatedEmission};
use crate::light::light_sampling::LightSample;
use crate::light::point;
use crate::math::frame::ShadingFrame;
use crate::math::{PI, clamp, warp};
use spirv_std::glam::{Vec3, Vec4};

/// Share of a spot's intensity at `from_axis` = 1 - cos of the angle to its axis. It is 1 in the inner cone and 0 outside of the
/// outer one. Between them it is the square of a linear ramp in the cosine.
#[inline(always)]
pub fn falloff(light: &Light, from_axis: f32) -> f32 {
    let line = clamp((light.cone - from_axis) * light.falloff, 0.0, 1.0);
    line * line
}

/// Share of a spot's intensity towards a position that sees it in the unit direction `to_light`.
#[inline(always)]
pub fn falloff_seen(light: &Light, to_light: Vec3) -> f32 {
    falloff(light, 0.5 * (light.direction + to_light).length_squared())
}

/// Samples a direction uniformly over the outer cone. Returns it, and the share of the light's intensity over its density (sr).
#[inline(always)]
pub fn sample(light: &Light, u: f32, v: f32) -> (Vec3, f32) {
    let to = ShadingFrame::new(light.direction).to_world(warp::uniform_cone(light.cone, u, v));
    (to, falloff(light, u * light.cone) * (2.0 * PI * light.cone))
}

/// Samples the start of a light path in the outer cone (pbrt: `SampleLe`).
#[inline(always)]
pub fn sample_emission(
    light: &Light,
    _scene: SceneTables<'_>,
    _features: Features,
    _u_position: Vec4,
    direction: Vec4,
) -> EmissionSample {
    let (to, solid_angle) = sample(light, direction.x, direction.y);
    start(light, to, solid_angle)
}

/// Start of a light path in a direction. `solid_angle` is the share of the light's intensity over the density (sr).
#[inline(always)]
fn start(light: &Light, direction: Vec3, solid_angle: f32) -> EmissionSample {
    let flux = light.emission * (solid_angle / light.pdf_light_choice);
    let cone = 2.0 * PI * light.cone / light.pdf_light_choice;
    EmissionSample::new(Ray::endless(light.position, direction), flux, cone)
}

/// Evaluates the start of a light path in a direction (pbrt: `PDF_Le`).
#[inline(always)]
pub fn eval_emission(
    light: &Light,
    _scene: SceneTables<'_>,
    _features: Features,
    _u_position: Vec4,
    direction: Vec3,
) -> EvaluatedEmission {
    let solid_angle = 2.0 * PI * light.cone;
    let share = falloff_seen(light, -direction);
    let sample = start(light, direction, share * solid_angle);
    EvaluatedEmission { sample, pdf: if share > 0.0 { 1.0 / solid_angle } else { 0.0 } }
}

/// Samples the light as a point light, times the falloff.
#[inline(always)]
pub fn sample_light(
    light: &Light,
    scene: SceneTables<'_>,
    features: Features,
    position: Vec3,
    u: f32,
    v: f32,
) -> LightSample {
    let mut light_sample = point::sample_light(light, scene, features, position, u, v);
    light_sample.radiance_over_pdf *= falloff_seen(light, light_sample.to_light);
    light_sample
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Inner angle 0.1 of the outer. Samples average to the integral over the cone, given in closed form.
    #[test]
    fn samples_average_to_the_integral_of_the_falloff() {
        for outer in [1.5_f64, 0.5, 0.01] {
            let versine = |angle: f64| 2.0 * (0.5 * angle).sin().powi(2);
            let cone = versine(outer);
            let light = Light {
                direction: Vec3::new(0.6, 0.0, -0.8),
                cone: cone as f32,
                falloff: (1.0 / (cone - versine(0.1 * outer))) as f32,
                ..Light::default()
            };
            let steps = 1000;
            let (mut sampled, mut seen) = (0.0, 0.0);
            for step in 0..steps {
                let u = (step as f32 + 0.5) / steps as f32;
                let (direction, share) = sample(&light, u, 0.3);
                assert!((direction.length() - 1.0).abs() < 1e-6);
                sampled += f64::from(share) / f64::from(steps);
                seen += f64::from(falloff_seen(&light, -direction)) * 2.0 * core::f64::consts::PI * cone
                    / f64::from(steps);
            }
            let width = cone - versine(0.1 * outer);
            let expected = 2.0 * core::f64::consts::PI * (cone - width + width / 3.0);
            // A chord of a 0.01 rad cone has 1e-5 of relative error.
            assert!((sampled / expected - 1.0).abs() < 1e-5, "{sampled:e} {expected:e}");
            assert!((seen / expected - 1.0).abs() < 5e-5, "{seen:e} {expected:e}");
        }
    }

    #[test]
    fn falloff_is_zero_outside_the_outer_cone_and_one_in_the_inner() {
        let light = Light { direction: Vec3::Z, cone: 0.5, falloff: 1.0 / 0.25, ..Light::default() };
        assert_eq!(falloff_seen(&light, Vec3::NEG_Z), 1.0);
        assert_eq!((falloff(&light, 0.25), falloff(&light, 0.375)), (1.0, 0.25));
        assert_eq!((falloff(&light, 0.5), falloff(&light, 0.6)), (0.0, 0.0));
        assert_eq!(falloff_seen(&light, Vec3::Z), 0.0);
    }
}
