//! `widen.*`: wider discs where the last frame's photons were few, as far as blur is the smaller error. Progressive photon
//! mapping adapts radii from frame to frame, other methods take the k nearest photons [Jensen 1996]. This stage looks at the last
//! frame.
//!
//! A disc has the radius of the settings where photons suffice, and up to `WIDEST` times that where they do not. Earlier frames
//! alone decide, so the radius does not depend on the photons that the disc takes. Limitations: the bias of a wide disc remains.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{FrameStage, Step};
use crate::gather::accumulator;
use crate::interface::frame::FrameParams;
use crate::interface::point::PointGeometry;
use crate::math::clamp;
use crate::platform::Slots;
use spirv_std::glam::Vec2;

/// Stage that widens discs where the last frame's photons were few.
#[cfg(not(target_arch = "spirv"))]
pub const WIDEN: FrameStage = FrameStage {
    before_light: |params| vec![Step::new(&WIDEN_DISCS, params)],
    after_gather: |params| vec![Step::new(&WIDEN_LEARN, params)],
    keeps: &["radius_next"],
    ..FrameStage::new("widen")
};

/// Largest radius, relative to that of the settings.
pub const WIDEST: f32 = 3.0;
/// Photons that a disc of the radius of the settings must take on average, so that it need not be wider.
pub const ENOUGH: f32 = 4.0;
/// Number of pixels to each side whose photons are counted.
const AROUND: u32 = 2;

/// Widens the disc of each pixel; without an earlier frame it stays as it is.
#[pass(name = "widen.discs", over = params.pixel_count(), work = Resolve)]
pub fn widen_discs(
    pixel: u32,
    #[len = params.pixel_count()] radius_next: &[f32],
    #[len = params.pixel_count()] mut radius_now: Slots<'_, f32>,
    mut point_geometry: Slots<'_, PointGeometry>,
) {
    let scale = radius_next[pixel as usize].max(1.0);
    radius_now.write(pixel, scale);
    let point = point_geometry.read(pixel);
    point_geometry.write(pixel, PointGeometry { radius: point.radius * scale, ..point });
}

/// Computes the scale of each pixel's disc in the next frame.
#[pass(name = "widen.learn", over = params.pixel_count(), work = Resolve)]
pub fn widen_learn(
    pixel: u32,
    params: &FrameParams,
    point_geometry: &[PointGeometry],
    #[len = params.pixel_count() * accumulator::WORDS] accumulator: &[u32],
    radius_now: &[f32],
    #[len = params.pixel_count()] mut radius_next: Slots<'_, f32>,
) {
    let taken = params.sum_around(pixel, AROUND, |other| {
        if !point_geometry[other as usize].exists() {
            return Vec2::ZERO;
        }
        let count = accumulator[(other * accumulator::WORDS + accumulator::WORDS - 1) as usize];
        let scale = radius_now[other as usize];
        // Estimate the photons that a disc of the radius of the settings would have taken.
        Vec2::new(count as f32 / (scale * scale), 1.0)
    });
    let scale = if taken.x > 0.0 { (ENOUGH * taken.y / taken.x).sqrt() } else { WIDEST };
    radius_next.write(pixel, clamp(scale, 1.0, WIDEST));
}
