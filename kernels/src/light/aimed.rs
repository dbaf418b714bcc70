//! Aimed emission: lights and places on them by power, as `ByPower` does, and most directions into the cones in which the place
//! sees the casters; of parallel light, most places onto their shadows.
//!
//! A path chooses a caster, or by the share `BY_POWER` none, and starts uniformly in the caster's cone, else by power. Casters are
//! chosen by the root of the share of directions that they fill, halfway between evenly and by what they get of the light: evenly,
//! small ones take most paths from a wide mirror.
//! Its flux is divided by the density of the whole mixture, in which every cone counts that holds the direction: so no path is
//! heavier than 1 / `BY_POWER` of its weight by power. A caster that holds the place, or fills more than a quarter of the
//! directions from there, has no cone; paths that choose it start by power.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::caster::Caster;
use crate::interface::light::Light;
use crate::light::directional::across;
use crate::light::emit::{EmissionSample, Emit};
use crate::light::power::ByPower;
use crate::light::{choose, leave, place_on, towards};
use crate::math::frame::ShadingFrame;
use crate::math::{PI, warp};
use spirv_std::glam::{Vec3, Vec4};

/// Share of paths that start by power whatever there is to aim at.
pub const BY_POWER: f32 = 0.125;
/// 1 - cos of the widest cone: a quarter of all directions.
const MAX_VERSINE: f32 = 0.5;
/// Radius of the widest disc, relative to that of a directional light: a quarter of its area.
const MAX_RADIUS: f32 = 0.5;

/// See the head of the file.
#[derive(Clone, Copy)]
pub struct Aimed<'a> {
    /// The start before a direction is chosen.
    pub power: ByPower<'a>,
}

/// What a path can be aimed at: the directions into which a place sees a caster, or the places across parallel light in its
/// shadow.
#[derive(Clone, Copy)]
struct Target {
    /// Unit direction to the middle, or from the middle of the light's disc to it (m).
    middle: Vec3,
    /// Half of the squared distance from there to the rim, of directions 1 - cos of the angle; 0: nothing to aim at.
    reach: f32,
    /// Weight in the choice of a caster.
    weight: f32,
}

impl Target {
    /// The cone in which a place sees a caster.
    #[inline(always)]
    fn cone(caster: &Caster, from: Vec3) -> Target {
        let along = caster.centre - from;
        let square = along.length_squared();
        let sin_squared = caster.radius * caster.radius / square;
        let mut target =
            Target { middle: Vec3::Z, reach: 0.0, weight: if caster.radius > 0.0 { 1.0 } else { 0.0 } };
        // sin^2 / (1 + cos): cosines near 1 would leave narrow cones few bits.
        if sin_squared < 1.0 {
            let versine = sin_squared / (1.0 + (1.0 - sin_squared).sqrt());
            if versine <= MAX_VERSINE {
                target = Target { middle: along / square.sqrt(), reach: versine, weight: versine.sqrt() };
            }
        }
        target
    }

    /// The shadow of a caster.
    #[inline(always)]
    fn disc(caster: &Caster, light: &Light) -> Target {
        let along = caster.centre - light.position;
        let share = caster.radius / light.radius;
        let radius = if share <= MAX_RADIUS { caster.radius } else { 0.0 };
        Target {
            middle: along - light.direction * along.dot(light.direction),
            reach: 0.5 * radius * radius,
            weight: share.min(1.0),
        }
    }

    #[inline(always)]
    fn holds(&self, at: Vec3) -> bool {
        0.5 * (at - self.middle).length_squared() <= self.reach
    }

    /// Density with which it is hit uniformly (1/sr or 1/m^2).
    #[inline(always)]
    fn density(&self) -> f32 {
        1.0 / (2.0 * PI * self.reach)
    }
}

/// A caster chosen among targets.
#[derive(Clone, Copy)]
struct Choice {
    /// The caster; their number if the path starts by power.
    caster: u32,
    /// Sum of the weights.
    total: f32,
}

/// Chooses among `count` targets by a uniform number.
#[inline(always)]
fn choose_target(count: u32, u: f32, target: impl Fn(u32) -> Target) -> Choice {
    let (mut total, mut index) = (0.0, 0);
    while index < count {
        total += target(index).weight;
        index += 1;
    }
    // What is left of the number is below 0 before the first caster: by power.
    let mut left = (u - BY_POWER) * (total / (1.0 - BY_POWER));
    let mut caster = count;
    index = 0;
    while index < count && left >= 0.0 {
        left -= target(index).weight;
        if left < 0.0 {
            caster = index;
        }
        index += 1;
    }
    Choice { caster, total }
}

/// The mixture of which a start was drawn: the share of starts by power, and the density beside them.
#[inline(always)]
fn mixture(count: u32, choice: Choice, at: Vec3, target: impl Fn(u32) -> Target) -> (f32, f32) {
    let scale = if choice.total > 0.0 { (1.0 - BY_POWER) / choice.total } else { 0.0 };
    let (mut by_power, mut aimed) = (1.0 - scale * choice.total, 0.0);
    let mut index = 0;
    while index < count {
        let target = target(index);
        if target.reach == 0.0 {
            by_power += scale * target.weight;
        } else if index == choice.caster || target.holds(at) {
            aimed += scale * target.weight * target.density();
        }
        index += 1;
    }
    (by_power, aimed)
}

impl Aimed<'_> {
    /// A start at a place by power, most often into a cone.
    #[inline(always)]
    fn around(&self, light: &Light, place: Vec4, numbers: Vec4) -> EmissionSample {
        let ByPower { scene, params, features } = self.power;
        let from = place_on(light, scene, place);
        let count = params.casters.count;
        let cone = |index: u32| Target::cone(&params.casters.spheres[index as usize], from);
        let choice = choose_target(count, numbers.w, cone);
        let mut chosen = Target { middle: Vec3::Z, reach: 0.0, weight: 0.0 };
        if choice.caster < count {
            chosen = cone(choice.caster);
        }
        let to = if chosen.reach > 0.0 {
            ShadingFrame::new(chosen.middle).to_world(warp::uniform_cone(chosen.reach, numbers.x, numbers.y))
        } else {
            leave(light, scene, features, place, numbers).ray.direction
        };
        let (by_power, aimed) = mixture(count, choice, to, cone);
        let leaving = towards(light, scene, features, place, to);
        leaving.sample.over(leaving.pdf_solid_angle, by_power, aimed)
    }

    /// A start of parallel light, most often onto a shadow.
    #[inline(always)]
    fn across(&self, light: &Light, place: Vec4, numbers: Vec4) -> EmissionSample {
        let ByPower { scene, params, features } = self.power;
        let count = params.casters.count;
        let disc = |index: u32| Target::disc(&params.casters.spheres[index as usize], light);
        let choice = choose_target(count, numbers.w, disc);
        let mut sample = leave(light, scene, features, place, numbers);
        if choice.caster < count {
            let chosen = disc(choice.caster);
            if chosen.reach > 0.0 {
                let beside = across(light, (2.0 * chosen.reach).sqrt(), place.z, place.w);
                sample.ray.origin = light.position + chosen.middle + beside;
            }
        }
        let at = sample.ray.origin - light.position;
        let (by_power, aimed) = mixture(count, choice, at, disc);
        // Beyond its disc the light meets nothing.
        let on_disc = at.length_squared() <= light.radius * light.radius;
        let density = if on_disc { 1.0 / (PI * light.radius * light.radius) } else { 0.0 };
        sample.over(density, by_power, aimed)
    }
}

impl Emit for Aimed<'_> {
    #[inline(always)]
    fn sample(&self, place: Vec4, direction: Vec4) -> EmissionSample {
        let lights = self.power.scene.lights;
        let light = lights[choose(lights, self.power.params.light_count, place.x, place.y) as usize];
        if light.is_parallel() {
            self.across(&light, place, direction)
        } else {
            self.around(&light, place, direction)
        }
    }
}
