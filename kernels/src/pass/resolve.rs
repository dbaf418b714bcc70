//! `resolve`: photon density estimation, L = T a / (pi R^2) [Jensen 1996; Hachisuka et al. 2008; pbrt: `SPPMIntegrator`]. T is
//! the throughput of the prefix, a the sum of BSDF times flux over the photons in the point's disc.

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
        caustic = estimate_radiance(point, &point_shading[pixel as usize], sum);
    }
    caustic_radiance.write(pixel, caustic);
}

/// Photon density estimate: radiance of the caustic at a point (W m^-2 sr^-1) from its sum of BSDF times flux (W sr^-1).
#[inline(always)]
pub fn estimate_radiance(point: &PointGeometry, shading: &PointShading, sum: Vec3) -> Vec3 {
    // Divide twice: the square of a small radius may underflow.
    shading.throughput * (sum / point.radius) / (PI * point.radius)
}
