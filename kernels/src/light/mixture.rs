//! Starts of light paths towards what somebody aims at, in a mixture with starts by power: what ways to aim have in common.

use crate::interface::light::Light;
use crate::light::emit::{EmissionSample, Towards};
use crate::light::power::ByPower;
use crate::light::{drawn, leave, place_on, towards};
use crate::math::rng::Rng;
use spirv_std::glam::{Vec3, Vec4};

/// Aims light paths.
pub trait Aims {
    /// What it has chosen for a path.
    type Choice: Copy + Default;

    /// Whether it aims at all; else paths start by power, undivided.
    #[inline(always)]
    fn mixes(&self) -> bool {
        true
    }
    /// The row of the light that a path starts from, by the numbers of `leave`, and more where they do not suffice.
    fn light(&self, place: Vec4, numbers: Vec4, rng: &mut Rng) -> (u32, Self::Choice);
    /// What it aims at from a place.
    fn aim(&self, choice: &mut Self::Choice, from: &From) -> Aim;
    /// The start that was made, over the density of the whole mixture.
    fn weigh(&self, choice: &Self::Choice, from: &From, aim: Vec3, leaving: &Towards) -> EmissionSample;
}

/// Where a path starts.
#[derive(Clone, Copy, Debug)]
pub struct From {
    /// Row of its light.
    pub row: u32,
    /// Its light; of an environment, the parallel light of a direction.
    pub light: Light,
    /// The place on it (m).
    pub position: Vec3,
    /// Four uniform numbers.
    pub numbers: Vec4,
}

/// What a path starts towards.
#[derive(Clone, Copy, Debug)]
pub struct Aim {
    is_chosen: bool,
    at: Vec3,
}

impl Aim {
    /// Wherever light goes by power.
    pub const BY_POWER: Aim = Aim { is_chosen: false, at: Vec3::ZERO };

    /// A direction, or of parallel light a place (see `target`).
    #[inline(always)]
    pub fn at(at: Vec3) -> Aim {
        Aim { is_chosen: true, at }
    }
}

/// A start of a light path.
#[inline(always)]
pub fn start<A: Aims>(aims: &A, power: &ByPower<'_>, rng: &mut Rng) -> EmissionSample {
    let ByPower { scene, features, .. } = *power;
    let (mut place, numbers) = (rng.next4(), rng.next4());
    let (row, mut choice) = aims.light(place, numbers, rng);
    let mut light = scene.lights[row as usize];
    let (mut position, mut aim) = (Vec3::ZERO, Aim::BY_POWER);
    if aims.mixes() {
        (light, place) = drawn(scene, features, row, place, numbers);
        position = place_on(&light, scene, features, place);
        aim = aims.aim(&mut choice, &From { row, light, position, numbers });
    }
    let (mut sample, mut at) = (EmissionSample::NONE, aim.at);
    if !aim.is_chosen {
        sample = leave(&light, scene, features, place, numbers);
        at = light.aim_of(&sample.ray);
    }
    if aims.mixes() {
        let leaving = towards(&light, scene, features, place, at);
        sample = aims.weigh(&choice, &From { row, light, position, numbers }, at, &leaving);
    }
    sample
}
