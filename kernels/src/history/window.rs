//! Position of a collection point in the image of the previous frame, and the pixels around that position.
//!
//! The collection points of a frame are an image too: neighbours on a surface, seen the same way, are neighbours in it. A point
//! is projected to the previous camera as the eye sees it, at its virtual image. Behind plane mirrors, the image lies on the
//! point's own ray, at the length of its path. Behind curved mirrors and glass, `math::pencil` gives the image to first order in
//! the motion of the eye.
//!
//! Cost: nine rows of 32 bytes a point, and no structure. A structure in space finds more: a point seen directly and in a mirror
//! is reused in both. But pixels behind curved glass scatter over the room and slow down every search. Over mirror-room's points,
//! a BVH in the order of the pixels cost 1.2 frames.

use crate::interface::frame::{Camera, FrameParams};
use crate::interface::history::HistoryPoint;
use crate::interface::point::{PointGeometry, PointShading};
use crate::math::pencil::VirtualImage;
use spirv_std::glam::{Vec2, Vec3};

/// Half width of the window (px) for light seen through specular events, if no point is reusable in the small window.
pub const WIDE_HALF_WIDTH: i32 = 3;

/// Vector from the eye of the previous frame in the direction in which it saw the point. It ends at the virtual image, or has any
/// length. `position` is the point in the previous frame.
#[inline(always)]
pub fn seen_from(
    before: &Camera,
    pixel: u32,
    point: &PointGeometry,
    shading: &PointShading,
    position: Vec3,
    params: &FrameParams,
) -> Vec3 {
    if point.depth == 1 {
        return position - before.position;
    }
    let camera = &params.camera;
    let (column, row) = params.on_film(pixel);
    let along = camera.direction_of(column as f32 + 0.5, row as f32 + 0.5, params);
    if shading.astigmatism == 0 && shading.distance > 0.0 {
        return camera.position + along * shading.distance - before.position;
    }
    let virtual_image = VirtualImage::from_packed(shading.distance, shading.astigmatism);
    virtual_image.from_eye(camera.position - before.position, along, camera.right)
}

/// Position in a camera's image (px) of what lies along `from_eye`; far outside of the image if that is behind the eye.
#[inline(always)]
pub fn project(from_eye: Vec3, camera: &Camera, params: &FrameParams) -> Vec2 {
    let (is_before, at) = camera.on_plane(from_eye);
    if !is_before {
        return Vec2::splat(-1.0e6);
    }
    let at = params.raster_position(at);
    at.clamp(Vec2::splat(-1.0e6), Vec2::splat(1.0e6))
}

/// Points and light of the previous frame, by pixel.
pub struct PreviousFrame<'a, L = Vec3> {
    /// Collection points.
    pub points: &'a [HistoryPoint],
    /// Light of the points.
    pub light: &'a [L],
}

impl<L> Clone for PreviousFrame<'_, L> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<L> Copy for PreviousFrame<'_, L> {}

/// Visitor of pixels of the previous frame. Callers pass buffers beside it, as in `gather::Visit`.
pub trait Look<L = Vec3> {
    /// Visits a pixel.
    fn look(&mut self, history: PreviousFrame<'_, L>, pixel: u32);
}

/// Visits the pixels up to `half` columns and rows from the pixel that holds `at`, row by row.
#[inline(always)]
pub fn for_each_around<L, V: Look<L>>(
    at: Vec2,
    half: i32,
    params: &FrameParams,
    history: PreviousFrame<'_, L>,
    look: &mut V,
) {
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
            look.look(history, y as u32 * params.width + x as u32);
            x += 1;
        }
        y += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::frame::Window;

    const EYE: Vec3 = Vec3::new(0.3, 1.2, 2.0);

    fn params(forward: Vec3) -> FrameParams {
        let forward = forward.normalize();
        let right = forward.cross(Vec3::Y).normalize();
        let camera = Camera { position: EYE, right: right * 0.8, up: right.cross(forward) * 0.45, forward };
        FrameParams { camera, width: 160, height: 90, window: Window::all(160, 90), ..FrameParams::default() }
    }

    /// Centre of a pixel (px), and the unit direction of its ray.
    fn ray(pixel: u32, params: &FrameParams) -> (Vec2, Vec3) {
        let centre =
            Vec2::new((pixel % params.width) as f32, (pixel / params.width) as f32) + Vec2::splat(0.5);
        let camera = &params.camera;
        let x = centre.x / params.width as f32 * 2.0 - 1.0;
        let y = 1.0 - centre.y / params.height as f32 * 2.0;
        (centre, (camera.forward + camera.right * x + camera.up * y).normalize())
    }

    /// Point on the floor y = -20 that a pixel sees in the mirror z = -1, and the point's virtual image.
    fn mirrored(pixel: u32, params: &FrameParams) -> (PointGeometry, PointShading, Vec3) {
        let (_, direction) = ray(pixel, params);
        let to_mirror = (-1.0 - EYE.z) / direction.z;
        let to_floor = (-20.0 - EYE.y) / direction.y;
        assert!(0.0 < to_mirror && to_mirror < to_floor, "the pixel sees the mirror");
        let virtual_image = EYE + direction * to_floor;
        let position = Vec3::new(virtual_image.x, virtual_image.y, -2.0 - virtual_image.z);
        let point = PointGeometry { position, radius: 0.01, normal: Vec3::Y, depth: 2 };
        (point, PointShading { distance: to_floor, ..Default::default() }, virtual_image)
    }

    #[test]
    fn points_behind_a_plane_mirror_come_back_to_their_pixel() {
        let params = params(Vec3::new(0.1, -1.0, -0.9));
        for pixel in (0..160 * 90).step_by(77) {
            let (point, shading, virtual_image) = mirrored(pixel, &params);
            let seen = seen_from(&params.camera, pixel, &point, &shading, point.position, &params);
            // Tolerance: a few ulp of 40 m.
            assert!((EYE + seen - virtual_image).length() < 2.0e-5, "{seen} should lead to {virtual_image}");
            let at = project(seen, &params.camera, &params);
            let centre = ray(pixel, &params).0;
            assert!((at - centre).length() < 1.0e-3, "{at} should be {centre}");
            // The point itself projects elsewhere.
            assert!((project(point.position - EYE, &params.camera, &params) - centre).length() > 1.0);
        }
    }

    #[test]
    fn points_seen_directly_are_seen_at_their_previous_position() {
        let params = params(Vec3::NEG_Z);
        let point = PointGeometry { position: Vec3::ONE, depth: 1, ..Default::default() };
        let before = Vec3::new(0.5, 1.0, -1.0);
        let camera = Camera { position: EYE + Vec3::X, ..params.camera };
        let seen = seen_from(&camera, 7, &point, &PointShading::default(), before, &params);
        assert_eq!(seen, before - camera.position);
    }

    #[test]
    fn a_camera_that_moved_saw_points_elsewhere() {
        let params = params(Vec3::NEG_Z);
        let position = EYE + Vec3::new(0.0, 0.0, -4.0);
        let middle = Vec2::new(80.0, 45.0);
        let project = |camera: &Camera| project(position - camera.position, camera, &params);
        assert!((project(&params.camera) - middle).length() < 1.0e-4);
        // The eye stood 0.1 m further left: the point was 0.1 / (4 0.8) of half an image further right.
        let left = Camera { position: EYE - Vec3::X * 0.1, ..params.camera };
        let right = Vec2::new(80.0 * 0.1 / 3.2, 0.0);
        assert!((project(&left) - middle - right).length() < 1.0e-3);
        // 0.1 m further down: the point was higher, in smaller rows.
        let below = Camera { position: EYE - Vec3::Y * 0.1, ..params.camera };
        let up = Vec2::new(0.0, -45.0 * 0.1 / (4.0 * 0.45));
        assert!((project(&below) - middle - up).length() < 1.0e-3);
        // It looked further left by 0.2 rad: tan(0.2) / 0.8 of half an image.
        let (sin, cos) = 0.2f32.sin_cos();
        let forward = Vec3::new(-sin, 0.0, -cos);
        let panned = Camera { forward, right: forward.cross(Vec3::Y) * 0.8, ..params.camera };
        let right = Vec2::new(80.0 * 0.2f32.tan() / 0.8, 0.0);
        assert!((project(&panned) - middle - right).length() < 1.0e-3);
    }

    struct Pixels(Vec<u32>);

    impl Look for Pixels {
        fn look(&mut self, _: PreviousFrame<'_>, pixel: u32) {
            self.0.push(pixel);
        }
    }

    fn around(at: Vec2, half: i32, params: &FrameParams) -> Vec<u32> {
        let mut pixels = Pixels(vec![]);
        for_each_around(at, half, params, PreviousFrame { points: &[], light: &[] }, &mut pixels);
        pixels.0
    }

    #[test]
    fn points_behind_the_eye_are_in_no_pixel() {
        let params = params(Vec3::NEG_Z);
        for position in [EYE + Vec3::Z, EYE, EYE + Vec3::X] {
            let at = project(position - EYE, &params.camera, &params);
            assert_eq!(around(at, WIDE_HALF_WIDTH, &params), []);
        }
        // Points far beside the image are in no pixel either, at any distance.
        let beside = project(Vec3::new(1.0e9, 0.0, -1.0e-5), &params.camera, &params);
        assert_eq!((beside.x, around(beside, WIDE_HALF_WIDTH, &params)), (1.0e6, vec![]));
    }

    #[test]
    fn windows_end_at_the_border_of_the_image() {
        let params = params(Vec3::NEG_Z);
        assert_eq!(around(Vec2::new(5.99, 2.0), 0, &params), [2 * 160 + 5]);
        assert_eq!(around(Vec2::new(0.5, 0.5), 1, &params), [0, 1, 160, 161]);
        assert_eq!(around(Vec2::new(159.5, 89.5), 1, &params).len(), 4);
        assert_eq!(around(Vec2::new(80.0, 45.0), WIDE_HALF_WIDTH, &params).len(), 49);
        // The pixel beside the first column holds no points, but it has a neighbour that does.
        assert_eq!(around(Vec2::new(-0.5, 0.5), 0, &params), []);
        assert_eq!(around(Vec2::new(-0.5, 0.5), 1, &params), [0, 160]);
    }
}
