//! Emission by power: lights by their share of the flux, uniform over the area, cosine (or uniform) in direction.
//! Spots: uniform over the outer cone. Directional lights: uniform over their disc.

use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::light::{LIGHT_DIRECTIONAL, LIGHT_SPOT};
use crate::interface::ray::Ray;
use crate::interface::scene::SceneTables;
use crate::light::emit::{EmissionSample, Emit};
use crate::light::{choose, directional, spot};
use crate::math::frame::ShadingFrame;
use crate::math::{PI, offset, warp};
use crate::texture::emission::emission_at;
use spirv_std::glam::Vec4;

/// Starts every path with flux in proportion to the whole scene's.
#[derive(Clone, Copy)]
pub struct ByPower<'a> {
    /// The scene with its light table.
    pub scene: SceneTables<'a>,
    /// Length of the light table.
    pub light_count: u32,
    /// What the scene needs.
    pub features: Features,
}

impl Emit for ByPower<'_> {
    #[inline(always)]
    fn sample(&self, place: Vec4, direction: Vec4) -> EmissionSample {
        let light = self.scene.lights[choose(self.scene.lights, self.light_count, place.x, place.y) as usize];
        if self.features.has(Features::DIRECTIONAL_LIGHTS) && light.kind == LIGHT_DIRECTIONAL {
            let (origin, area) = directional::sample(&light, place.z, place.w);
            return EmissionSample {
                ray: Ray::endless(origin, light.direction),
                flux: light.emission * (area / light.pdf_light_choice),
                solid_angle: 0.0,
                area: area / light.pdf_light_choice,
                texel: 0,
            };
        }
        if self.features.has(Features::SPOT_LIGHTS) && light.kind == LIGHT_SPOT {
            let (to, solid_angle) = spot::sample(&light, direction.x, direction.y);
            return EmissionSample {
                ray: Ray::endless(light.position, to),
                flux: light.emission * (solid_angle / light.pdf_light_choice),
                solid_angle: 2.0 * PI * light.cone / light.pdf_light_choice,
                area: 0.0,
                texel: 0,
            };
        }
        if self.features.has(Features::POINT_LIGHTS) && light.triangle == NONE {
            let to = warp::uniform_sphere(direction.x, direction.y);
            return EmissionSample {
                ray: Ray::endless(light.position, to),
                flux: light.emission * (4.0 * PI / light.pdf_light_choice),
                solid_angle: 4.0 * PI / light.pdf_light_choice,
                area: 0.0,
                texel: 0,
            };
        }
        let triangle = self.scene.triangles[light.triangle as usize];
        let b = warp::uniform_triangle(place.z, place.w);
        let (edge_b, edge_c) = (triangle.b - triangle.a, triangle.c - triangle.a);
        let point = triangle.a + edge_b * b.x + edge_c * b.y;
        let mut normal = edge_b.cross(edge_c).normalize();
        if light.sides == 2 && direction.z < 0.5 {
            normal = -normal;
        }
        let local = warp::cosine_hemisphere(direction.x, direction.y);
        let to = ShadingFrame::new(normal).to_world(local);
        let share = emission_at(self.scene, self.features, light.triangle, b.x, b.y);
        let clearance = offset::clearance(offset::magnitude(triangle.a, triangle.b, triangle.c));
        EmissionSample {
            ray: Ray::endless(offset::leave(point, normal, normal, clearance), to),
            flux: light.emission * share * (PI * light.area * light.sides as f32 / light.pdf_light_choice),
            // Triangles are pieces of lamps: all of them light the places around, so that no choice counts.
            solid_angle: PI / local.z.max(1.0e-3),
            area: 0.0,
            texel: 0,
        }
    }
}
