//! Rays and their hits.

use crate::interface::NONE;
use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// A ray over the distances (0, `length`).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Ray {
    /// Start (m).
    pub origin: Vec3,
    /// Maximum distance (m); hits at it or beyond do not count.
    pub length: f32,
    /// Unit direction.
    pub direction: Vec3,
    /// Key of the blended surfaces that the ray meets (`texture/cut_out.rs`).
    pub key: u32,
}

/// Length of a ray without an end (m).
pub const MAX_DISTANCE: f32 = 1.0e30;

impl Ray {
    /// A ray without an end, of key 0.
    #[inline]
    pub fn endless(origin: Vec3, direction: Vec3) -> Self {
        Ray { origin, length: MAX_DISTANCE, direction, key: 0 }
    }

    /// Ray from one point to another one, of key 0.
    #[inline]
    pub fn between(origin: Vec3, end: Vec3) -> Self {
        let along = end - origin;
        let length = along.length();
        Ray { origin, length, direction: along / length, key: 0 }
    }

    /// Rest of this ray behind a surface that it met. `origin` is the hit, moved off the surface by its clearance. The rest ends
    /// at the end of this ray: beyond it may lie a light.
    #[inline]
    pub fn rest_from(&self, origin: Vec3) -> Self {
        let mut rest = Ray { origin, ..*self };
        if self.length < MAX_DISTANCE {
            let end = self.origin + self.direction * self.length;
            // Nothing is left where the surface lies within its clearance of the end.
            rest.length = 0.0;
            if (end - origin).dot(self.direction) > 0.0 {
                rest = Ray { key: self.key, ..Ray::between(origin, end) };
            }
        }
        rest
    }
}

/// Closest hit of a ray; `triangle` is `NONE` for a miss.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Hit {
    /// Distance along the ray (m).
    pub distance: f32,
    /// Triangle id, or `NONE`.
    pub triangle: u32,
    /// Barycentric weight of the triangle's corner b.
    pub u: f32,
    /// Barycentric weight of the triangle's corner c.
    pub v: f32,
    /// Index of the instance of the triangle; 0 is the world.
    pub instance: u32,
}

impl Hit {
    /// No hit.
    pub const MISS: Hit = Hit { distance: MAX_DISTANCE, triangle: NONE, u: 0.0, v: 0.0, instance: 0 };

    /// Whether nothing was hit.
    #[inline]
    pub fn is_miss(&self) -> bool {
        self.triangle == NONE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A light lies `gap` behind a wall whose clearance is larger than the light's. At any angle the rest of a ray must end
    /// where the ray ends.
    #[test]
    fn the_rest_of_a_ray_ends_where_the_ray_ends() {
        for degrees in [0.0f32, 30.0, 60.0, 85.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            for gap in [2e-4, 0.01, 1.0] {
                let (wall_clearance, light_clearance) = (1e-4, 1e-5);
                let end = Vec3::new((2.0 + gap) * sin / cos, 2.0 + gap - light_clearance, 0.5);
                let ray = Ray { key: 7, ..Ray::between(Vec3::ZERO, end) };
                let hit = ray.direction * (2.0 / ray.direction.y);
                let rest = ray.rest_from(hit + Vec3::Y * wall_clearance);
                let rest_end = rest.origin + rest.direction * rest.length;
                assert_eq!(rest.key, 7);
                assert!((rest_end - end).length() < 2e-6 * end.length(), "{degrees}, {gap}: {rest_end}");
                assert!((rest.direction.length() - 1.0).abs() < 1e-6);
            }
        }
        // The light is closer to the wall than the wall's clearance.
        let ray = Ray::between(Vec3::ZERO, 2.00005 * Vec3::Y);
        assert_eq!(ray.rest_from(2.0001 * Vec3::Y).length, 0.0);
        let sun = Ray::endless(Vec3::ZERO, Vec3::Y);
        assert_eq!(sun.rest_from(Vec3::X), Ray { origin: Vec3::X, ..sun });
    }
}
