//! Directional lights: parallel light from infinitely far away. Its paths start on a disc before the whole scene,
//! which the host makes just as wide as the scene is seen from there.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::features::Features;
use crate::interface::light::Light;
use crate::interface::ray::Ray;
use crate::interface::scene::SceneTables;
use crate::light::connect::Connection;
use crate::light::emit::{EmissionSample, Towards};
use crate::math::PI;
use crate::math::frame::ShadingFrame;
use crate::math::trig::sin_cos_turns;
use spirv_std::glam::{Vec3, Vec4};

/// Where a path starts, uniform over the disc, and the disc's area (m^2).
#[inline(always)]
pub fn sample(light: &Light, u: f32, v: f32) -> (Vec3, f32) {
    (light.position + across(light, light.radius, u, v), PI * light.radius * light.radius)
}

/// From the middle of a disc of a radius across the light to a uniform place of it (m).
#[inline(always)]
pub fn across(light: &Light, radius: f32, u: f32, v: f32) -> Vec3 {
    let frame = ShadingFrame::new(light.direction);
    let (sin, cos) = sin_cos_turns(v);
    (frame.x * cos + frame.y * sin) * (u.sqrt() * radius)
}

/// A path along the light's direction.
#[inline(always)]
pub fn leave(
    light: &Light,
    _scene: SceneTables<'_>,
    _features: Features,
    place: Vec4,
    _direction: Vec4,
) -> EmissionSample {
    let (origin, area) = sample(light, place.z, place.w);
    EmissionSample {
        ray: Ray::endless(origin, light.direction),
        flux: light.emission * (area / light.pdf_light_choice),
        solid_angle: 0.0,
        area: area / light.pdf_light_choice,
        texel: 0,
    }
}

/// Parallel light has one direction.
#[inline(always)]
pub fn towards(
    light: &Light,
    scene: SceneTables<'_>,
    features: Features,
    place: Vec4,
    _direction: Vec3,
) -> Towards {
    Towards { sample: leave(light, scene, features, place, place), pdf_solid_angle: 0.0 }
}

/// A connection against the light's direction, without end.
#[inline(always)]
pub fn connect(
    light: &Light,
    _scene: SceneTables<'_>,
    _features: Features,
    position: Vec3,
    _u: f32,
    _v: f32,
) -> Connection {
    Connection {
        to_light: -light.direction,
        radiance_over_pdf: light.emission / light.pdf_light_choice,
        endless: true,
        ..Connection::none(position)
    }
}
