//! The start of a camera path: its first ray, through a position in a pixel, and the cone around that ray.

use crate::interface::frame::FrameParams;
use crate::interface::ray::Ray;
use crate::math::cone::RayCone;
use crate::math::rng::{Rng, Stream};
use crate::math::sampler::next4;

/// A camera path before its first ray is traced.
#[derive(Clone, Copy, Debug)]
pub struct CameraPathStart {
    /// Its first ray.
    pub ray: Ray,
    /// The cone around that ray.
    pub cone: RayCone,
    /// Its random numbers from here on.
    pub rng: Rng,
}

impl CameraPathStart {
    /// Starts at the eye, through a pixel, with the numbers of a stream.
    #[inline(always)]
    pub fn new(stream: Stream, pixel: u32, params: &FrameParams) -> CameraPathStart {
        let mut rng = Rng::new(stream, params.seed, params.film_pixel(pixel), params.frame);
        let ray = camera_ray(params, pixel, &mut rng);
        CameraPathStart { ray, cone: RayCone::at_eye(params.pixel_spread), rng }
    }
}

/// Samples the camera ray through a pixel. Takes the same numbers of `rng` with every filter, so that all later numbers agree.
#[inline(always)]
pub fn camera_ray(params: &FrameParams, pixel: u32, rng: &mut Rng) -> Ray {
    let u = next4(rng, &params.sequence);
    let (mut x, mut y) = (0.5, 0.5);
    if params.has_box_filter() {
        (x, y) = (u.x, u.y);
    }
    let (column, row) = params.on_film(pixel);
    let camera = &params.camera;
    Ray::endless(camera.position, camera.direction_of(column as f32 + x, row as f32 + y, params))
}
