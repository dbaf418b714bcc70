//! `grey`: caustics without colour, the mean of their channels.

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{FrameStage, Step};
use crate::math::mean;
use crate::platform::Slots;
use spirv_std::glam::Vec3;

/// Takes the colour from caustics.
#[cfg(not(target_arch = "spirv"))]
pub const GREY: FrameStage =
    FrameStage { after_resolve: |params| vec![Step::new(&GREY_CAUSTICS, params)], ..FrameStage::new("grey") };

/// A pixel's caustics, the same in each channel.
#[pass(name = "grey.caustics", over = params.pixel_count(), work = Resolve)]
pub fn grey_caustics(pixel: u32, mut caustic_radiance: Slots<'_, Vec3>) {
    let caustics = caustic_radiance.read(pixel);
    caustic_radiance.write(pixel, Vec3::splat(mean(caustics)));
}
