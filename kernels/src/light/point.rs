//! Point lights: the same intensity in all directions.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::features::Features;
use crate::interface::light::Light;
use crate::interface::ray::Ray;
use crate::interface::scene::SceneTables;
use crate::light::connect::Connection;
use crate::light::emit::EmissionSample;
use crate::math::{PI, warp};
use spirv_std::glam::{Vec3, Vec4};

/// A path in any direction.
#[inline(always)]
pub fn leave(
    light: &Light,
    _scene: SceneTables<'_>,
    _features: Features,
    _place: Vec4,
    direction: Vec4,
) -> EmissionSample {
    let to = warp::uniform_sphere(direction.x, direction.y);
    EmissionSample {
        ray: Ray::endless(light.position, to),
        flux: light.emission * (4.0 * PI / light.pdf_light_choice),
        solid_angle: 4.0 * PI / light.pdf_light_choice,
        area: 0.0,
        texel: 0,
    }
}

/// A connection by the law of the inverse square.
#[inline(always)]
pub fn connect(
    light: &Light,
    _scene: SceneTables<'_>,
    _features: Features,
    position: Vec3,
    _u: f32,
    _v: f32,
) -> Connection {
    let along = light.position - position;
    let square = along.length_squared();
    if square == 0.0 {
        return Connection::none(position);
    }
    Connection {
        target: light.position,
        to_light: along / square.sqrt(),
        radiance_over_pdf: light.emission / (square * light.pdf_light_choice),
        ..Connection::none(position)
    }
}
