//! Emission by power: samples a light by its share of the flux, then a position and a direction by the light's type.

use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::scene::SceneTables;
use crate::light::emit::{EmissionSample, Emit};
use crate::light::{choose, sample_emission};
use crate::math::rng::Rng;
use spirv_std::glam::Vec4;

/// Starts every path with flux in proportion to that of the whole scene.
#[derive(Clone, Copy)]
pub struct ByPower<'a> {
    /// The scene with its light table.
    pub scene: SceneTables<'a>,
    /// The settings of the frame.
    pub params: &'a FrameParams,
    /// Code that is compiled in.
    pub features: Features,
}

impl<'a> ByPower<'a> {
    /// Emission from all lights of a frame.
    #[inline(always)]
    pub fn new(scene: SceneTables<'a>, params: &'a FrameParams, features: Features) -> Self {
        ByPower { scene, params, features }
    }

    /// Samples a start by the uniform numbers of `sample_emission`.
    #[inline(always)]
    pub fn start(&self, u_position: Vec4, direction: Vec4) -> EmissionSample {
        let ByPower { scene, params, .. } = *self;
        let light =
            scene.lights[choose(scene.lights, params.light_count, u_position.x, u_position.y) as usize];
        sample_emission(&light, scene, self.features, u_position, direction)
    }
}

impl Emit for ByPower<'_> {
    #[inline(always)]
    fn sample(&self, rng: &mut Rng) -> EmissionSample {
        let u_position = rng.next4();
        self.start(u_position, rng.next4())
    }
}
