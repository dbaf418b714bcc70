//! Input of the filter of the path-traced part, by pixel.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// Number of levels of the filter, which is odd; level l reaches 2^l pixels.
pub const DENOISER_LEVELS: u32 = 5;

/// Features of a pixel's collection point, by which the filter decides which pixels exchange light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct DenoiserGuide {
    /// Position of the point (m).
    pub position: Vec3,
    /// Radius of the point (m): the scale of distances.
    pub radius: f32,
    /// Unit normal of the face, on the viewer's side.
    pub normal: Vec3,
    /// Hash of the point's camera vertex, instance and material; `NONE`: this pixel exchanges no light.
    pub surface: u32,
    /// Factor on light at the point: throughput times texture, positive.
    pub share: Vec3,
    /// One over the sum of the channels of `share`.
    pub inverse_share: f32,
}

const _: () = assert!(size_of::<DenoiserGuide>() == 48);
