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
use crate::light::emit::{EmissionSample, Emit};
use crate::light::power::ByPower;
use crate::light::{choose, leave, place_on, towards};
use crate::math::PI;
use crate::math::frame::ShadingFrame;
use crate::math::trig::sin_cos_turns;
use spirv_std::glam::{Vec2, Vec3, Vec4};

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

/// Directions into which a place sees a caster.
struct Cone {
    /// Unit direction to its middle.
    axis: Vec3,
    /// 1 - cos of the angle to its rim; 0: no cone.
    versine: f32,
    /// Weight in the choice of a caster.
    weight: f32,
}

impl Cone {
    #[inline(always)]
    fn new(caster: &Caster, from: Vec3) -> Cone {
        let along = caster.centre - from;
        let square = along.length_squared();
        let sin_squared = caster.radius * caster.radius / square;
        let mut cone =
            Cone { axis: Vec3::Z, versine: 0.0, weight: if caster.radius > 0.0 { 1.0 } else { 0.0 } };
        // sin^2 / (1 + cos): cosines near 1 would leave narrow cones few bits.
        if sin_squared < 1.0 {
            let versine = sin_squared / (1.0 + (1.0 - sin_squared).sqrt());
            if versine <= MAX_VERSINE {
                cone = Cone { axis: along / square.sqrt(), versine, weight: versine.sqrt() };
            }
        }
        cone
    }

    #[inline(always)]
    fn holds(&self, direction: Vec3) -> bool {
        0.5 * (direction - self.axis).length_squared() <= self.versine
    }

    /// A uniform direction.
    #[inline(always)]
    fn sample(&self, u: f32, v: f32) -> Vec3 {
        let versine = u * self.versine;
        let sin = (versine * (2.0 - versine)).max(0.0).sqrt();
        let (y, x) = sin_cos_turns(v);
        ShadingFrame::new(self.axis).to_world(Vec3::new(sin * x, sin * y, 1.0 - versine))
    }

    /// Its density (1/sr).
    #[inline(always)]
    fn density(&self) -> f32 {
        1.0 / (2.0 * PI * self.versine)
    }
}

/// The shadow of a caster across parallel light, relative to the disc that its paths start on.
struct Disc {
    /// Its middle on the light's axes, from the middle of the light's disc (m).
    centre: Vec2,
    /// Radius (m); 0: no disc.
    radius: f32,
    /// Weight in the choice of a caster.
    weight: f32,
}

impl Disc {
    #[inline(always)]
    fn new(caster: &Caster, light: &Light, frame: &ShadingFrame) -> Disc {
        let along = caster.centre - light.position;
        let centre = Vec2::new(along.dot(frame.x), along.dot(frame.y));
        let share = caster.radius / light.radius;
        let radius = if share <= MAX_RADIUS { caster.radius } else { 0.0 };
        Disc { centre, radius, weight: share.min(1.0) }
    }

    #[inline(always)]
    fn holds(&self, place: Vec2) -> bool {
        (place - self.centre).length_squared() <= self.radius * self.radius
    }

    #[inline(always)]
    fn sample(&self, u: f32, v: f32) -> Vec2 {
        let (sin, cos) = sin_cos_turns(v);
        self.centre + Vec2::new(cos, sin) * (u.sqrt() * self.radius)
    }

    /// Its density (1/m^2).
    #[inline(always)]
    fn density(&self) -> f32 {
        1.0 / (PI * self.radius * self.radius)
    }
}

impl Aimed<'_> {
    /// A start at a place by power, most often into a cone.
    #[inline(always)]
    fn around(&self, light: &Light, place: Vec4, numbers: Vec4) -> EmissionSample {
        let ByPower { scene, params, features } = self.power;
        let from = place_on(light, scene, features, place);
        let count = params.casters.count;
        let cone = |index: u32| Cone::new(&params.casters.spheres[index as usize], from);
        let (mut total, mut index) = (0.0, 0);
        while index < count {
            total += cone(index).weight;
            index += 1;
        }

        // What is left of the number below 0 before the first caster: by power.
        let mut left = (numbers.w - BY_POWER) * (total / (1.0 - BY_POWER));
        let mut to = leave(light, scene, features, place, numbers).ray.direction;
        let mut chosen = 0;
        while chosen < count && left >= 0.0 {
            let cone = cone(chosen);
            left -= cone.weight;
            chosen += 1;
            if left < 0.0 && cone.versine > 0.0 {
                to = cone.sample(numbers.x, numbers.y);
            }
        }

        let scale = if total > 0.0 { (1.0 - BY_POWER) / total } else { 0.0 };
        let (mut by_power, mut aimed) = (1.0 - scale * total, 0.0);
        index = 0;
        while index < count {
            let cone = cone(index);
            index += 1;
            if cone.versine == 0.0 {
                by_power += scale * cone.weight;
            } else if (index == chosen && left < 0.0) || cone.holds(to) {
                aimed += scale * cone.weight * cone.density();
            }
        }
        let leaving = towards(light, scene, features, place, to);
        leaving.sample.over(leaving.pdf_solid_angle, by_power, aimed)
    }

    /// A start of parallel light, most often onto a disc.
    #[inline(always)]
    fn across(&self, light: &Light, place: Vec4, numbers: Vec4) -> EmissionSample {
        let ByPower { scene, params, features } = self.power;
        let frame = ShadingFrame::new(light.direction);
        let count = params.casters.count;
        let disc = |index: u32| Disc::new(&params.casters.spheres[index as usize], light, &frame);
        let (mut total, mut index) = (0.0, 0);
        while index < count {
            total += disc(index).weight;
            index += 1;
        }

        let mut sample = leave(light, scene, features, place, numbers);
        let from = sample.ray.origin - light.position;
        let mut at = Vec2::new(from.dot(frame.x), from.dot(frame.y));
        let mut left = (numbers.w - BY_POWER) * (total / (1.0 - BY_POWER));
        let mut chosen = 0;
        while chosen < count && left >= 0.0 {
            let disc = disc(chosen);
            left -= disc.weight;
            chosen += 1;
            if left < 0.0 && disc.radius > 0.0 {
                at = disc.sample(place.z, place.w);
                sample.ray.origin = light.position + frame.x * at.x + frame.y * at.y;
            }
        }

        let scale = if total > 0.0 { (1.0 - BY_POWER) / total } else { 0.0 };
        let (mut by_power, mut aimed) = (1.0 - scale * total, 0.0);
        index = 0;
        while index < count {
            let disc = disc(index);
            index += 1;
            if disc.radius == 0.0 {
                by_power += scale * disc.weight;
            } else if (index == chosen && left < 0.0) || disc.holds(at) {
                aimed += scale * disc.weight * disc.density();
            }
        }
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
