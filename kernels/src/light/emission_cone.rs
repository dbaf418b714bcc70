//! Emission cones: the directions in which a position of a light sees a caster, or the positions across parallel light in the
//! caster's shadow. One geometry serves both. An *emission direction* is a unit direction, or for parallel light the offset from
//! the middle of its disc (m). A cone holds all emission directions within a distance of its middle.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::caster::Caster;
use crate::interface::light::Light;
use crate::math::frame::ShadingFrame;
use crate::math::trig::{sin_cos_turns, turns};
use crate::math::{PI, warp};
use spirv_std::glam::{Vec2, Vec3};

/// 1 - cos of the widest cone: a quarter of all directions.
const MAX_VERSINE: f32 = 0.5;
/// Radius of the widest disc, relative to that of a directional light: a quarter of its area.
const MAX_RADIUS: f32 = 0.5;

/// Emission directions towards one caster.
#[derive(Clone, Copy)]
pub struct EmissionCone {
    /// Emission direction of its middle.
    pub middle: Vec3,
    /// Half of the squared distance from the middle to the rim; for directions, 1 - cos of the angle. 0 for a closed cone, which
    /// holds no direction.
    pub reach: f32,
    /// Weight by which the caster is chosen: the root of its share of the directions, times the caster's own weight, at most 1.
    pub weight: f32,
}

impl EmissionCone {
    /// A closed cone, of no weight.
    pub const NONE: EmissionCone = EmissionCone { middle: Vec3::Z, reach: 0.0, weight: 0.0 };

    /// Emission cone of a caster, seen from a position of a light. It is closed if the caster holds the position, or fills more
    /// than a quarter of all directions.
    #[inline(always)]
    pub fn at(caster: &Caster, light: &Light, from: Vec3) -> EmissionCone {
        if light.is_parallel() {
            EmissionCone::shadow(caster, light)
        } else {
            EmissionCone::cone(caster, from)
        }
    }

    /// All emission directions of a light. Most lights shine down: the middle of a map is its finest part, and around the opposite
    /// direction its texels are long and thin.
    #[inline(always)]
    pub fn everywhere(light: &Light) -> EmissionCone {
        if light.is_parallel() {
            EmissionCone { middle: Vec3::ZERO, reach: 0.5 * light.radius * light.radius, weight: 1.0 }
        } else {
            EmissionCone { middle: Vec3::NEG_Y, reach: 2.0, weight: 1.0 }
        }
    }

    #[inline(always)]
    fn cone(caster: &Caster, from: Vec3) -> EmissionCone {
        let along = caster.centre - from;
        let square = along.length_squared();
        let sin_squared = caster.radius * caster.radius / square;
        let mut cone = EmissionCone {
            weight: if caster.radius > 0.0 { caster.weight } else { 0.0 },
            ..EmissionCone::NONE
        };
        // Compute 1 - cos as sin^2 / (1 + cos): cosines near 1 would leave narrow cones few bits.
        if sin_squared < 1.0 {
            let versine = sin_squared / (1.0 + (1.0 - sin_squared).sqrt());
            if versine <= MAX_VERSINE {
                let weight = versine.sqrt() * caster.weight;
                cone = EmissionCone { middle: along / square.sqrt(), reach: versine, weight };
            }
        }
        cone
    }

    #[inline(always)]
    fn shadow(caster: &Caster, light: &Light) -> EmissionCone {
        let along = caster.centre - light.position;
        let share = caster.radius / light.radius;
        let radius = if share <= MAX_RADIUS { caster.radius } else { 0.0 };
        EmissionCone {
            middle: along - light.direction * along.dot(light.direction),
            reach: 0.5 * radius * radius,
            weight: share.min(1.0) * caster.weight,
        }
    }

    /// Whether it holds any direction.
    #[inline(always)]
    pub fn is_open(&self) -> bool {
        self.reach > 0.0
    }

    /// Whether it holds this direction.
    #[inline(always)]
    pub fn holds(&self, direction: Vec3) -> bool {
        0.5 * (direction - self.middle).length_squared() <= self.reach
    }

    /// Its solid angle (sr), or its area (m^2).
    #[inline(always)]
    pub fn size(&self) -> f32 {
        2.0 * PI * self.reach
    }

    /// Frame around the middle, or across parallel light.
    #[inline(always)]
    fn frame(&self, light: &Light) -> ShadingFrame {
        ShadingFrame::steady(if light.is_parallel() { light.direction } else { self.middle })
    }

    /// Emission direction with these polar numbers: the share of the cone's size nearer to the middle, and the share of a turn.
    /// The map keeps areas.
    #[inline(always)]
    pub fn direction(&self, light: &Light, polar: Vec2) -> Vec3 {
        let frame = self.frame(light);
        if light.is_parallel() {
            let (sin, cos) = sin_cos_turns(polar.y);
            return self.middle + (frame.x * cos + frame.y * sin) * (2.0 * self.reach * polar.x).sqrt();
        }
        frame.to_world(warp::uniform_cone(self.reach, polar.x, polar.y))
    }

    /// Polar numbers of an emission direction that the cone holds; the inverse of `direction`.
    #[inline(always)]
    pub fn polar(&self, light: &Light, direction: Vec3) -> Vec2 {
        let frame = self.frame(light);
        let beside = direction - self.middle;
        let share = 0.5 * beside.length_squared() / self.reach;
        Vec2::new(share.min(1.0), turns(beside.dot(frame.y), beside.dot(frame.x)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::{Rng, Stream};

    /// Cones of every width and direction, the sphere, shadows and a whole disc.
    #[test]
    fn polar_inverts_direction_for_every_cone() {
        let around = Light::default();
        let parallel = Light {
            position: Vec3::new(1.0, 5.0, 2.0),
            direction: Vec3::new(0.6, -0.8, 0.0),
            radius: 10.0,
            ..Light::default()
        };
        for path in 0..100_000 {
            let mut rng = Rng::new(Stream::Light, 8, path, 0);
            let (u, v) = (rng.next4(), rng.next4());
            let centre = warp::uniform_sphere(u.x, u.y) * (2.0 + u.z);
            let caster = Caster { centre, radius: 2.0 * u.w * u.w, weight: 1.0 };
            let polar = Vec2::new(v.x, v.y);
            for (light, from) in [(&around, Vec3::ZERO), (&parallel, Vec3::ZERO)] {
                for cone in [EmissionCone::at(&caster, light, from), EmissionCone::everywhere(light)] {
                    if cone.reach < 1e-4 {
                        continue;
                    }
                    let direction = cone.direction(light, polar);
                    let back = cone.polar(light, direction);
                    assert!(cone.holds(direction) || polar.x > 0.9999);
                    // An ulp of a direction, relative to the width of the cone.
                    let slack = 4e-7 / cone.reach.min(1.0).sqrt();
                    let turn = (back.y - polar.y).abs();
                    assert!((back.x - polar.x).abs() < 4.0 * slack, "{polar} {back} {}", cone.reach);
                    // A turn is worth little near the middle, and on the far side of the sphere.
                    let worth = (polar.x * (1.0 - 0.5 * polar.x * cone.reach)).max(0.0).sqrt();
                    assert!(turn.min(1.0 - turn) * worth < 2.0 * slack, "{polar} {back} {}", cone.reach);
                }
            }
        }
    }
}
