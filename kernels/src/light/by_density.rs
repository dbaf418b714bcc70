//! Emission by a density map [Yang and Ouyang 2021]: lights and places on them by power, as `ByPower` does, and of a light
//! those directions (of a directional light, those places) more often that the map asks for. The flux of a path is divided
//! by the density, so that no map changes the mean.

use crate::light::choose;
use crate::light::density_map::{draw, map_of, to_polar};
use crate::light::emit::{EmissionSample, Emit};
use crate::light::power::ByPower;
use spirv_std::glam::{Vec2, Vec4};

/// See the head of the file.
#[derive(Clone, Copy)]
pub struct ByDensity<'a> {
    /// The start before the maps.
    pub power: ByPower<'a>,
    /// The pyramids of all maps.
    pub tree: &'a [f32],
}

impl Emit for ByDensity<'_> {
    #[inline(always)]
    fn sample(&self, place: Vec4, direction: Vec4) -> EmissionSample {
        let lights = self.power.scene.lights;
        let light = choose(lights, self.power.params.light_count, place.x, place.y);
        let parallel = lights[light as usize].is_parallel();
        let (u, v) = if parallel { (place.z, place.w) } else { (direction.x, direction.y) };
        let drawn = draw(self.tree, map_of(light), Vec2::new(u, v));
        let polar = to_polar(drawn.at);
        let leaving = if parallel {
            self.power.sample(Vec4::new(place.x, place.y, polar.x, polar.y), direction)
        } else {
            self.power.sample(place, Vec4::new(polar.x, polar.y, direction.z, direction.w))
        };
        EmissionSample {
            flux: leaving.flux / drawn.density,
            solid_angle: leaving.solid_angle / drawn.density,
            area: leaving.area / drawn.density,
            texel: drawn.texel,
            ..leaving
        }
    }
}
