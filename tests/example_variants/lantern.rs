//! A light that shines upwards, by the share (1 + cos) / 2 of its intensity. The example shows all parts of a type of light.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::features::Features;
use crate::interface::light::Light;
use crate::interface::ray::Ray;
use crate::interface::scene::SceneTables;
use crate::light::emit::{EmissionSample, EvaluatedEmission};
use crate::light::light_sampling::LightSample;
use crate::math::{PI, warp};
use spirv_std::glam::{Vec3, Vec4};

/// Share of the intensity in a direction.
#[inline(always)]
fn share(to: Vec3) -> f32 {
    0.5 + 0.5 * to.y
}

/// A path in any direction.
#[inline(always)]
pub fn sample_emission(
    light: &Light,
    scene: SceneTables<'_>,
    features: Features,
    u_position: Vec4,
    direction: Vec4,
) -> EmissionSample {
    eval_emission(light, scene, features, u_position, warp::uniform_sphere(direction.x, direction.y)).sample
}

/// A path in a direction.
#[inline(always)]
pub fn eval_emission(
    light: &Light,
    _scene: SceneTables<'_>,
    _features: Features,
    _u_position: Vec4,
    direction: Vec3,
) -> EvaluatedEmission {
    let solid_angle = 4.0 * PI / light.pdf_light_choice;
    let ray = Ray::endless(light.position, direction);
    let sample = EmissionSample::new(ray, light.emission * (share(direction) * solid_angle), solid_angle);
    EvaluatedEmission { sample, pdf: 1.0 / (4.0 * PI) }
}

/// Light sample by the law of the inverse square.
#[inline(always)]
pub fn sample_light(
    light: &Light,
    _scene: SceneTables<'_>,
    _features: Features,
    position: Vec3,
    _u: f32,
    _v: f32,
) -> LightSample {
    let along = light.position - position;
    let square = along.length_squared();
    if square == 0.0 {
        return LightSample::none(position);
    }
    let to_light = along / square.sqrt();
    LightSample {
        target: light.position,
        to_light,
        radiance_over_pdf: light.emission * (share(-to_light) / (square * light.pdf_light_choice)),
        ..LightSample::none(position)
    }
}
