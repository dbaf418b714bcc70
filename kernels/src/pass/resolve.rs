//! `resolve`: flux to radiance, L = T a / (pi R^2).

use crate::declare::pass;
use crate::gather::accumulator::{self, GatheredSum};
use crate::interface::frame::FrameParams;
use crate::interface::point::{PointGeometry, PointShading};
use crate::math::PI;
use crate::platform::Slots;
use spirv_std::glam::Vec3;

/// Radiance of the caustic at each pixel.
#[pass(name = "resolve", over = params.pixel_count(), work = Resolve)]
pub fn resolve(
    pixel: u32,
    params: &FrameParams,
    point_geometry: &[PointGeometry],
    point_shading: &[PointShading],
    #[len = params.pixel_count() * accumulator::WORDS] accumulator: &[u32],
    mut caustic_radiance: Slots<'_, Vec3>,
) {
    let point = &point_geometry[pixel as usize];
    let mut caustic = Vec3::ZERO;
    if point.exists() {
        let (sum, _) = GatheredSum::read(accumulator, pixel, params.quantum);
        caustic = radiance(point, &point_shading[pixel as usize], sum);
    }
    caustic_radiance.write(pixel, caustic);
}

/// Radiance of the caustic at a point (W m^-2 sr^-1) from its sum of f times flux (W sr^-1).
#[inline(always)]
pub fn radiance(point: &PointGeometry, shading: &PointShading, sum: Vec3) -> Vec3 {
    // Divide twice: the square of a small radius may underflow.
    shading.throughput * (sum / point.radius) / (PI * point.radius)
}
