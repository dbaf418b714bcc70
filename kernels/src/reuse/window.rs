//! Where a point of today stood in the picture of the frame before, and the pixels around that place.
//!
//! The collection points of a frame are a picture too: neighbours on a surface, seen the same way, are neighbours in it. A
//! point is carried back to the previous camera as the eye sees it, in a mirror at its virtual image: on its own ray at the
//! length of its path. For plane mirrors that is exact, for others near. Cost: nine rows of 32 bytes a point, and no
//! structure. A structure in space finds more (a place seen directly and in a mirror lends to both), but pixels behind
//! curved glass scatter over the room and are in every search's way: over mirror-room's points, a tree in the order of the
//! pixels cost 1.2 frames.

use crate::gather::Visit;
use crate::interface::frame::{Camera, FrameParams};
use crate::interface::point::{PointGeometry, PointShading};
use spirv_std::glam::{Vec2, Vec3};

/// Half width of the window [px] where light was seen through specular events and none lends in the small one.
pub const WIDE: i32 = 3;

/// Where the eye sees the point: itself, or its virtual image [m]. `position` is the point in the frame before.
#[inline(always)]
pub fn seen_at(
    pixel: u32,
    point: &PointGeometry,
    shading: &PointShading,
    position: Vec3,
    params: &FrameParams,
) -> Vec3 {
    if point.depth == 1 {
        return position;
    }
    let camera = &params.camera;
    let column = (pixel % params.width) as f32 + 0.5;
    let row = (pixel / params.width) as f32 + 0.5;
    let along = camera.forward
        + camera.right * (2.0 * column / params.width as f32 - 1.0)
        + camera.up * (1.0 - 2.0 * row / params.height as f32);
    camera.position + along.normalize() * shading.distance
}

/// A place in a camera's picture [px], far outside of it if it lies behind the eye.
#[inline(always)]
pub fn project(place: Vec3, camera: &Camera, params: &FrameParams) -> Vec2 {
    let from_eye = place - camera.position;
    let depth = from_eye.dot(camera.forward);
    if depth <= 0.0 {
        return Vec2::splat(-1.0e6);
    }
    let x = from_eye.dot(camera.right) / (camera.right.length_squared() * depth);
    let y = from_eye.dot(camera.up) / (camera.up.length_squared() * depth);
    let at = Vec2::new((1.0 + x) * 0.5 * params.width as f32, (1.0 - y) * 0.5 * params.height as f32);
    at.clamp(Vec2::splat(-1.0e6), Vec2::splat(1.0e6))
}

/// Visits the pixels whose centres lie within `half` pixels of the one that holds `at`, row by row.
#[inline(always)]
pub fn for_each_around<V: Visit>(at: Vec2, half: i32, params: &FrameParams, visit: &mut V) {
    // Truncation rounds up below zero, where no pixel is: step back.
    let column = at.x as i32 - if at.x < 0.0 { 1 } else { 0 };
    let row = at.y as i32 - if at.y < 0.0 { 1 } else { 0 };
    let (left, top) = ((column - half).max(0), (row - half).max(0));
    let right = (column + half).min(params.width as i32 - 1);
    let bottom = (row + half).min(params.height as i32 - 1);
    let mut y = top;
    while y <= bottom {
        let mut x = left;
        while x <= right {
            visit.visit(y as u32 * params.width + x as u32);
            x += 1;
        }
        y += 1;
    }
}
