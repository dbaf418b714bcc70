//! `resolve`: flux to radiance, L = T a / (pi R^2).

use crate::gather::accumulator::Sum;
use crate::interface::frame::FrameParams;
use crate::interface::point::{PointGeometry, PointShading};
use crate::math::PI;
use spirv_std::glam::Vec3;

/// Radiance of the caustic at a pixel [W m^-2 sr^-1] from the sum of f times flux at its point.
#[inline(always)]
pub fn resolve(
    pixel: u32,
    point: &PointGeometry,
    shading: &PointShading,
    accumulator: &[u32],
    params: &FrameParams,
) -> Vec3 {
    if point.depth == 0 {
        return Vec3::ZERO;
    }
    let (sum, _) = Sum::read(accumulator, pixel, params.quantum);
    // Divide twice: the square of a small radius may underflow.
    shading.throughput * (sum / point.radius) / (PI * point.radius)
}
