//! Offset of a ray's start from the surface that it leaves.

use crate::math::{larger, max_abs};
use caustics_kernel_macros::shared;
use spirv_std::glam::Vec3;

/// Distance from a surface (m) below which a point cannot be told from it. `magnitude` is the largest coordinate (m) of the
/// triangle's corners. A hit point is interpolated to about 4 ulp of it; 2^-19 is 16 ulp.
#[inline]
pub fn clearance(magnitude: f32) -> f32 {
    magnitude * (1.0 / 524_288.0)
}

/// Moves `position` off the face (unit `face_normal`) to the side that `direction` points to, by `clearance` (m).
#[inline]
pub fn leave(position: Vec3, face_normal: Vec3, direction: Vec3, clearance: f32) -> Vec3 {
    let side = if direction.dot(face_normal) < 0.0 { -clearance } else { clearance };
    position + face_normal * side
}

/// Largest coordinate of three corners (m).
#[shared]
pub fn magnitude(a: Vec3, b: Vec3, c: Vec3) -> f32 {
    larger(larger(max_abs(a), max_abs(b)), max_abs(c))
}
