//! `denoise.pairs`: the mean of each two pixels: an example that shows all that a denoiser consists of.

use caustics_kernels::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use caustics_kernels::declare::{Denoiser, Step};
use caustics_kernels::platform::Slots;
use spirv_std::glam::Vec3;

/// The mean of each two pixels.
#[cfg(not(target_arch = "spirv"))]
pub const PAIRS: Denoiser = Denoiser {
    name: "pairs",
    description: "the mean of each two pixels: an example",
    cost: "a read and a write of 12 bytes a pixel",
    limitations: "everything is blurred",
    steps: |params| vec![Step::new(&DENOISE_PAIRS, params)],
};

/// Two pixels, one pair an invocation.
#[pass(name = "denoise.pairs", over = params.pixel_count() / 2, work = Denoiser)]
pub fn denoise_pairs(pair: u32, #[len = params.pixel_count()] mut path_radiance: Slots<'_, Vec3>) {
    let (first, second) = (2 * pair, 2 * pair + 1);
    let mean = (path_radiance.read(first) + path_radiance.read(second)) * 0.5;
    path_radiance.write(first, mean);
    path_radiance.write(second, mean);
}
