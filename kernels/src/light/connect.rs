//! Direct connections: from a vertex to a point on a light, with the density of that choice.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::light::{LIGHT_DIRECTIONAL, LIGHT_SPOT, Light};
use crate::interface::scene::SceneTables;
use crate::light::{choose, spot};
use crate::math::{offset, warp};
use crate::texture::emission::emission_at;
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

/// Connects `position` to a light.
#[inline(always)]
pub fn connect(
    scene: SceneTables<'_>,
    light_count: u32,
    features: Features,
    position: Vec3,
    u: Vec4,
) -> Connection {
    let nothing = Connection {
        target: position,
        to_light: Vec3::Z,
        radiance_over_pdf: Vec3::ZERO,
        pdf_solid_angle: 0.0,
        endless: false,
    };
    if light_count == 0 {
        return nothing;
    }
    let light = scene.lights[choose(scene.lights, light_count, u.x, u.y) as usize];
    if features.has(Features::DIRECTIONAL_LIGHTS) && light.kind == LIGHT_DIRECTIONAL {
        return Connection {
            to_light: -light.direction,
            radiance_over_pdf: light.emission / light.pdf_light_choice,
            endless: true,
            ..nothing
        };
    }
    if features.has(Features::POINT_LIGHTS | Features::SPOT_LIGHTS) && light.triangle == NONE {
        let along = light.position - position;
        let square = along.length_squared();
        if square == 0.0 {
            return nothing;
        }
        let to_light = along / square.sqrt();
        let mut radiance_over_pdf = light.emission / (square * light.pdf_light_choice);
        if features.has(Features::SPOT_LIGHTS) && light.kind == LIGHT_SPOT {
            radiance_over_pdf *= spot::falloff_seen(&light, to_light);
        }
        return Connection { target: light.position, to_light, radiance_over_pdf, ..nothing };
    }

    // A uniform point of the triangle, on the side that we see.
    let triangle = scene.triangles[light.triangle as usize];
    let b = warp::uniform_triangle(u.z, u.w);
    let (edge_b, edge_c) = (triangle.b - triangle.a, triangle.c - triangle.a);
    let point = triangle.a + edge_b * b.x + edge_c * b.y;
    let normal = edge_b.cross(edge_c).normalize();
    let along = point - position;
    let square = along.length_squared();
    let to_light = along / square.sqrt();
    let cos = -to_light.dot(normal);
    if square == 0.0 || cos == 0.0 || (cos < 0.0 && light.sides != 2) {
        return nothing;
    }
    let pdf_solid_angle = pdf_solid_angle(&light, square, cos);
    let share = emission_at(scene, features, light.triangle, b.x, b.y);
    let clearance = offset::clearance(offset::magnitude(triangle.a, triangle.b, triangle.c));
    Connection {
        target: offset::leave(point, normal, -to_light, clearance),
        to_light,
        radiance_over_pdf: light.emission * share / pdf_solid_angle,
        pdf_solid_angle,
        endless: false,
    }
}

/// Density (1/sr) with which `connect` finds a point of a triangle light at this squared distance (m^2).
#[inline(always)]
pub fn pdf_solid_angle(light: &Light, square: f32, cos: f32) -> f32 {
    light.pdf_light_choice / light.area * square / cos.abs()
}
