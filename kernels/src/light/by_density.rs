//! Emission by a density map [Yang and Ouyang 2021]: lights and positions on them by power, as `ByPower` does, and of a light
//! those directions (of a directional light, those positions) more often that the map asks for. The flux of a path is divided
//! by the density, so that no map changes the mean.

use crate::light::choose;
use crate::light::density_map::{Pyramid, to_polar};
use crate::light::emit::{EmissionSample, Emit};
use crate::light::power::ByPower;
use crate::math::rng::Rng;
use spirv_std::glam::{Vec2, Vec4};

/// The layout of its maps.
pub type DensityPyramid = Pyramid<7>;
/// Maps there are. A light has that of its row, modulo this: lamps of many triangles share them.
pub const MAPS: u32 = 8;
/// Words of a texel's feedback: sum of screen areas, of their squares (two words each), photons, paths.
pub const FEEDBACK_WORDS: u32 = 6;

/// The map of this light.
#[inline]
pub fn map_of(light: u32) -> u32 {
    light % MAPS
}

/// Maps that a table of so many lights uses.
#[inline]
pub fn map_count(light_count: u32) -> u32 {
    light_count.min(MAPS)
}

/// See the head of the file.
#[derive(Clone, Copy)]
pub struct ByDensity<'a> {
    /// The start before the maps.
    pub power: ByPower<'a>,
    /// The pyramids of all maps.
    pub pyramid: &'a [f32],
}

impl Emit for ByDensity<'_> {
    #[inline(always)]
    fn sample(&self, rng: &mut Rng) -> EmissionSample {
        let (u_position, direction) = (rng.next4(), rng.next4());
        let lights = self.power.scene.lights;
        let light = choose(lights, self.power.params.light_count, u_position.x, u_position.y);
        let parallel = lights[light as usize].is_parallel();
        let (u, v) = if parallel { (u_position.z, u_position.w) } else { (direction.x, direction.y) };
        let sampled = DensityPyramid::sample(self.pyramid, map_of(light), Vec2::new(u, v));
        let polar = to_polar(sampled.at);
        let emission = if parallel {
            self.power.start(Vec4::new(u_position.x, u_position.y, polar.x, polar.y), direction)
        } else {
            self.power.start(u_position, Vec4::new(polar.x, polar.y, direction.z, direction.w))
        };
        EmissionSample {
            flux: emission.flux / sampled.density,
            solid_angle: emission.solid_angle / sampled.density,
            area: emission.area / sampled.density,
            texel: sampled.texel,
            ..emission
        }
    }
}
