//! Direct connections: from a vertex to a point on a light, with the density of that choice.

use crate::interface::features::Features;
use crate::interface::scene::SceneTables;
use crate::light::{choose, connect_to};
use spirv_std::glam::{Vec3, Vec4};

/// A point on a light as a vertex sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Connection {
    /// Where a shadow ray ends, just before the light (m).
    pub target: Vec3,
    /// Unit direction to the light.
    pub to_light: Vec3,
    /// Radiance over pdf_solid_angle; for a punctual light its irradiance across over the chance of its choice
    /// (W m^-2).
    pub radiance_over_pdf: Vec3,
    /// Density of this direction (1/sr); 0 for a punctual light, which nothing else can find.
    pub pdf_solid_angle: f32,
    /// The light is infinitely far away: the shadow ray has no end, and `target` says nothing.
    pub endless: bool,
}

impl Connection {
    /// No light comes to this position.
    #[inline(always)]
    pub fn none(position: Vec3) -> Self {
        Connection {
            target: position,
            to_light: Vec3::Z,
            radiance_over_pdf: Vec3::ZERO,
            pdf_solid_angle: 0.0,
            endless: false,
        }
    }
}

/// Connects `position` to a light.
#[inline(always)]
pub fn connect(
    scene: SceneTables<'_>,
    light_count: u32,
    features: Features,
    position: Vec3,
    u: Vec4,
) -> Connection {
    if light_count == 0 {
        return Connection::none(position);
    }
    let light = scene.lights[choose(scene.lights, light_count, u.x, u.y) as usize];
    connect_to(&light, scene, features, position, u.z, u.w)
}
