//! `bound.*`: bounds rare bright samples of camera paths (fireflies) by the pixels around, in single frames without a history.
//! Limitations: it loses energy, so methods that converge do not use it.
//!
//! It bounds the light that was found after the first non-delta bounce. Light found before stays as it is: a light in view or in
//! a mirror, and direct light on a surface seen so. It differs from its surroundings without being noise.

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{FrameStage, Step};
#[cfg(not(target_arch = "spirv"))]
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::math::mean;
use crate::platform::Slots;
use spirv_std::glam::{Vec2, Vec3};

/// Stage that bounds fireflies.
#[cfg(not(target_arch = "spirv"))]
pub const BOUND: FrameStage = FrameStage {
    after_collect: |params| vec![Step::new(&BOUND_LIMITS, params), Step::new(&BOUND_SAMPLES, params)],
    features: Features::PARTS,
    ..FrameStage::new("bound")
};

/// Largest ratio of a sample to the mean around it.
pub const MAX_OVER_MEAN: f32 = 8.0;
/// Number of pixels to each side in the mean around a sample.
const AROUND: u32 = 2;

/// Computes the limit of each pixel's sample.
#[pass(name = "bound.limits", over = params.pixel_count(), work = Denoiser)]
pub fn bound_limits(
    pixel: u32,
    params: &FrameParams,
    path_radiance: &[Vec3],
    delta_prefix_radiance: &[Vec3],
    #[len = params.pixel_count()] mut sample_limits: Slots<'_, f32>,
) {
    let non_delta = |other: u32| mean(path_radiance[other as usize] - delta_prefix_radiance[other as usize]);
    let sum = params.sum_around(pixel, AROUND, |other| {
        if other == pixel { Vec2::ZERO } else { Vec2::new(non_delta(other), 1.0) }
    });
    sample_limits.write(pixel, MAX_OVER_MEAN * sum.x.max(0.0) / sum.y.max(1.0));
}

/// Scales the sample of a pixel down to its limit.
#[pass(name = "bound.samples", over = params.pixel_count(), work = Denoiser)]
pub fn bound_samples(
    pixel: u32,
    #[len = params.pixel_count()] sample_limits: &[f32],
    delta_prefix_radiance: &[Vec3],
    mut prefix_radiance: Slots<'_, Vec3>,
    mut path_radiance: Slots<'_, Vec3>,
) {
    let (radiance, delta_prefix) = (path_radiance.read(pixel), delta_prefix_radiance[pixel as usize]);
    let (non_delta, limit) = (mean(radiance - delta_prefix), sample_limits[pixel as usize]);
    if non_delta > limit {
        let bounded = delta_prefix + (radiance - delta_prefix) * (limit / non_delta);
        path_radiance.write(pixel, bounded);
        prefix_radiance.write(pixel, prefix_radiance.read(pixel).min(bounded));
    }
}
