//! The start of a camera path: its first ray, through a position in a pixel, and the cone around that ray.

use crate::interface::frame::FrameParams;
use crate::interface::ray::Ray;
use crate::math::cone::RayCone;
use crate::math::rng::{Rng, Stream};
use crate::math::sampler::next4;

/// Distance of the seeds of a pixel's paths, beyond the seeds that users choose.
const SEEDS_APART: u32 = 0x6a09_e667;

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
    /// Starts at the eye, through a pixel, with the random numbers of a stream. Paths of the pixel differ by their number.
    #[inline(always)]
    pub fn new(stream: Stream, number: u32, pixel: u32, params: &FrameParams) -> CameraPathStart {
        let seed = params.seed.wrapping_add(number.wrapping_mul(SEEDS_APART));
        let mut rng = Rng::new(stream, seed, params.film_pixel(pixel), params.frame);
        // Only one path of each pixel takes its part of an even set.
        if number != 0 && params.sequence.width != 0 {
            rng.skip(params.sequence.groups);
        }
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
