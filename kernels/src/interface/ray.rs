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
