//! Aimed emission: samples lights and positions on them by power, as `ByPower` does. It samples most directions in the cones in
//! which the position sees the casters. For parallel light it samples most positions in the shadows of the casters.
//!
//! A path chooses a caster and starts uniformly in its cone. With the probability `BY_POWER` it chooses none and starts by power.
//! A caster is chosen by the square root of the share of directions that it fills. That is halfway between a uniform choice and
//! one by the light that a caster gets. A uniform choice would give small casters most paths of a wide mirror. A thin wall that
//! light passes casts by its reflection alone. Its weight is smaller by the root of the share that it reflects. The flux of a path
//! is divided by the density of the whole mixture, summed over all cones that hold the direction. No path is therefore heavier
//! than 1 / `BY_POWER` times its weight by power.
//!
//! Cost: up to 16 cones a path. Limitations: a caster that holds the position, or fills more than a quarter of the directions
//! from there, has no cone. Paths that choose it start by power.

use crate::light::choose;
use crate::light::emission_cone::EmissionCone;
use crate::light::emit::{EmissionSample, Emit, EvaluatedEmission};
use crate::light::mixture::{EmissionContext, EmissionDirection, EmissionMixture, start};
use crate::light::power::ByPower;
use crate::math::rng::Rng;
use spirv_std::glam::{Vec2, Vec3, Vec4};

/// Share of paths that start by power, whatever casters there are.
pub const BY_POWER: f32 = 0.125;

/// Aimed emission: most paths start in the cone of a caster.
#[derive(Clone, Copy)]
pub struct Aimed<'a> {
    /// Emission by power, which chooses lights and positions.
    pub power: ByPower<'a>,
}

/// Choice of a caster by its cone.
#[derive(Clone, Copy, Default)]
pub struct CasterChoice {
    /// Index of the caster; the number of casters if the path starts by power.
    caster: u32,
    /// Sum of the weights of all cones.
    total: f32,
}

/// Chooses among `count` cones by a uniform number.
#[inline(always)]
fn choose_cone(count: u32, u: f32, cone: impl Fn(u32) -> EmissionCone) -> CasterChoice {
    let (mut total, mut index) = (0.0, 0);
    while index < count {
        total += cone(index).weight;
        index += 1;
    }
    // Start by power where the number is below 0 before the first caster.
    let mut left = (u - BY_POWER) * (total / (1.0 - BY_POWER));
    let mut caster = count;
    index = 0;
    while index < count && left >= 0.0 {
        left -= cone(index).weight;
        if left < 0.0 {
            caster = index;
        }
        index += 1;
    }
    CasterChoice { caster, total }
}

/// Mixture density of a start: the share of starts by power, and the density of the cones that hold its direction.
#[inline(always)]
fn mixture(
    count: u32,
    choice: CasterChoice,
    direction: Vec3,
    cone: impl Fn(u32) -> EmissionCone,
) -> (f32, f32) {
    let scale = if choice.total > 0.0 { (1.0 - BY_POWER) / choice.total } else { 0.0 };
    let (mut by_power, mut aimed) = (1.0 - scale * choice.total, 0.0);
    let mut index = 0;
    while index < count {
        let cone = cone(index);
        if !cone.is_open() {
            by_power += scale * cone.weight;
        } else if index == choice.caster || cone.holds(direction) {
            aimed += scale * cone.weight / cone.size();
        }
        index += 1;
    }
    (by_power, aimed)
}

impl Aimed<'_> {
    /// Emission cone of the caster of this index, seen from a position.
    #[inline(always)]
    fn cone(&self, context: &EmissionContext, index: u32) -> EmissionCone {
        EmissionCone::at(&self.power.params.casters.spheres[index as usize], &context.light, context.position)
    }
}

impl EmissionMixture for Aimed<'_> {
    type Choice = CasterChoice;

    #[inline(always)]
    fn light(&self, u_position: Vec4, _numbers: Vec4, _rng: &mut Rng) -> (u32, CasterChoice) {
        let ByPower { scene, params, .. } = self.power;
        (choose(scene.lights, params.light_count, u_position.x, u_position.y), CasterChoice::default())
    }

    #[inline(always)]
    fn sample_direction(&self, choice: &mut CasterChoice, context: &EmissionContext) -> EmissionDirection {
        let count = self.power.params.casters.count;
        *choice = choose_cone(count, context.numbers.w, |index| self.cone(context, index));
        let mut chosen = EmissionCone::NONE;
        if choice.caster < count {
            chosen = self.cone(context, choice.caster);
        }
        let mut direction = EmissionDirection::BY_POWER;
        if chosen.is_open() {
            direction = EmissionDirection::at(
                chosen.direction(&context.light, Vec2::new(context.numbers.x, context.numbers.y)),
            );
        }
        direction
    }

    #[inline(always)]
    fn weigh(
        &self,
        choice: &CasterChoice,
        context: &EmissionContext,
        direction: Vec3,
        emission: &EvaluatedEmission,
    ) -> EmissionSample {
        let count = self.power.params.casters.count;
        let (by_power, aimed) = mixture(count, *choice, direction, |index| self.cone(context, index));
        emission.sample.over(emission.pdf, by_power, aimed)
    }
}

impl Emit for Aimed<'_> {
    #[inline(always)]
    fn sample(&self, rng: &mut Rng) -> EmissionSample {
        start(self, &self.power, rng)
    }
}
