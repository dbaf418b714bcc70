//! Emission by a density map [Yang and Ouyang 2021]. Lights and positions on them are sampled by power, as in `ByPower`,
//! directions by the map of the light. For a directional light the map samples positions. The flux of a path is divided by the
//! density, so that no map changes the mean.

use crate::light::choose;
use crate::light::density_map::{Pyramid, to_polar};
use crate::light::emit::{EmissionSample, Emit};
use crate::light::power::ByPower;
use crate::math::rng::Rng;
use spirv_std::glam::{Vec2, Vec4};

/// The layout of its maps.
pub type DensityPyramid = Pyramid<7>;
/// Number of maps. A light has the map of its id modulo this number, so that lights of many triangles share maps.
pub const MAPS: u32 = 8;
/// Number of words of a texel's feedback: sum of screen areas, of their squares (two words each), photons, paths.
pub const FEEDBACK_WORDS: u32 = 6;

/// Index of the map of a light.
#[inline]
pub fn map_of(light: u32) -> u32 {
    light % MAPS
}

/// Number of maps that a table of `light_count` lights uses.
#[inline]
pub fn map_count(light_count: u32) -> u32 {
    light_count.min(MAPS)
}

/// Emission by density maps of the lights.
#[derive(Clone, Copy)]
pub struct ByDensity<'a> {
    /// Emission by power, which chooses lights.
    pub power: ByPower<'a>,
    /// The pyramids of all maps.
    pub pyramid: &'a [f32],
}

impl Emit for ByDensity<'_> {
    #[inline(always)]
    fn sample(&self, rng: &mut Rng) -> EmissionSample {
        let (u_position, direction) = (rng.next4(), rng.next4());
        // Choose a light by power
        let lights = self.power.scene.lights;
        let light = choose(lights, self.power.params.light_count, u_position.x, u_position.y);
        // Sample its map, in place of the direction or of the position across parallel light
        let parallel = lights[light as usize].is_parallel();
        let (u, v) = if parallel { (u_position.z, u_position.w) } else { (direction.x, direction.y) };
        let sampled = DensityPyramid::sample(self.pyramid, map_of(light), Vec2::new(u, v));
        let polar = to_polar(sampled.at);
        // Sample the emission by the numbers of the map, and divide by their density
        let emission = if parallel {
            self.power.start(Vec4::new(u_position.x, u_position.y, polar.x, polar.y), direction)
        } else {
            self.power.start(u_position, Vec4::new(polar.x, polar.y, direction.z, direction.w))
        };
        EmissionSample {
            flux: emission.flux / sampled.density,
            solid_angle: emission.solid_angle / sampled.density,
            area: emission.area / sampled.density,
            start_code: sampled.texel,
            ..emission
        }
    }
}
