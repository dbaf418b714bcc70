//! Emission mixtures: starts of light paths in sampled emission directions, mixed with starts by power.

use crate::interface::light::Light;
use crate::light::emit::{EmissionSample, EvaluatedEmission};
use crate::light::power::ByPower;
use crate::light::{eval_emission, sample_emission, sample_environment, sample_position};
use crate::math::rng::Rng;
use spirv_std::glam::{Vec3, Vec4};

/// A mixture of sampled emission directions with emission by power.
pub trait EmissionMixture {
    /// Choices that it makes for a path.
    type Choice: Copy + Default;

    /// Whether it samples directions at all. Otherwise paths start by power, with the density of that alone.
    #[inline(always)]
    fn mixes(&self) -> bool {
        true
    }
    /// Chooses the light that a path starts from, by the numbers of `sample_emission` and further ones where they do not suffice.
    fn light(&self, u_position: Vec4, numbers: Vec4, rng: &mut Rng) -> (u32, Self::Choice);
    /// Samples an emission direction from a position.
    fn sample_direction(&self, choice: &mut Self::Choice, context: &EmissionContext) -> EmissionDirection;
    /// Divides a start by the density of the whole mixture.
    fn weigh(
        &self,
        choice: &Self::Choice,
        context: &EmissionContext,
        direction: Vec3,
        emission: &EvaluatedEmission,
    ) -> EmissionSample;
}

/// Emission context: the light and the position that a path starts from.
#[derive(Clone, Copy, Debug)]
pub struct EmissionContext {
    /// Id of its light.
    pub light_id: u32,
    /// Its light; for an environment, the parallel light of a direction.
    pub light: Light,
    /// Position on the light (m).
    pub position: Vec3,
    /// Four uniform numbers.
    pub numbers: Vec4,
}

/// Emission direction, if one was sampled.
#[derive(Clone, Copy, Debug)]
pub struct EmissionDirection {
    is_chosen: bool,
    at: Vec3,
}

impl EmissionDirection {
    /// No direction: the path starts by power.
    pub const BY_POWER: EmissionDirection = EmissionDirection { is_chosen: false, at: Vec3::ZERO };

    /// Emission direction that was sampled; for parallel light a position (see `emission_cone`).
    #[inline(always)]
    pub fn at(at: Vec3) -> EmissionDirection {
        EmissionDirection { is_chosen: true, at }
    }
}

/// Samples the start of a light path from a mixture.
#[inline(always)]
pub fn start<A: EmissionMixture>(mixture: &A, power: &ByPower<'_>, rng: &mut Rng) -> EmissionSample {
    let ByPower { scene, features, .. } = *power;
    let (mut u_position, numbers) = (rng.next4(), rng.next4());
    // Choose a light
    let (light_id, mut choice) = mixture.light(u_position, numbers, rng);
    let mut light = scene.lights[light_id as usize];
    let (mut position, mut direction) = (Vec3::ZERO, EmissionDirection::BY_POWER);
    if mixture.mixes() {
        // Sample a position on it, and an emission direction from there
        (light, u_position) = sample_environment(scene, features, light_id, u_position, numbers);
        position = sample_position(&light, scene, features, u_position);
        direction =
            mixture.sample_direction(&mut choice, &EmissionContext { light_id, light, position, numbers });
    }
    let (mut sample, mut at) = (EmissionSample::NONE, direction.at);

    // Sample the emission by power where no direction was sampled
    if !direction.is_chosen {
        sample = sample_emission(&light, scene, features, u_position, numbers);
        at = light.emission_direction(&sample.ray);
    }
    if mixture.mixes() {
        // Divide by the density of the whole mixture
        let emission = eval_emission(&light, scene, features, u_position, at);
        sample =
            mixture.weigh(&choice, &EmissionContext { light_id, light, position, numbers }, at, &emission);
    }
    sample
}
