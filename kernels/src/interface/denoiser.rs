//! What the filter of the path-traced part knows of a pixel.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// Levels of the filter, an odd number; level l reaches 2^l pixels.
pub const DENOISER_LEVELS: u32 = 5;

/// Features of a pixel's collection point, by which the filter tells with whom the pixel exchanges light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct DenoiserGuide {
    /// Position of the point (m).
    pub position: Vec3,
    /// Its radius (m): the scale of distances.
    pub radius: f32,
    /// The unit normal of its face, on the viewer's side.
    pub normal: Vec3,
    /// A number of the point's camera vertex, instance and material, or `NONE`: this pixel neither gives nor takes.
    pub surface: u32,
    /// What light at the point is multiplied with: throughput times texture, positive.
    pub share: Vec3,
    /// One over the sum of its channels.
    pub inverse_share: f32,
}

const _: () = assert!(size_of::<DenoiserGuide>() == 48);
