//! The density map of light paths, which outlives a frame.

use bytemuck::{Pod, Zeroable};

/// A texel of a density map.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct DensityTexel {
    /// Density of light paths; 1 is about the mean of a map.
    pub density: f32,
    /// Change of the density in the last update.
    pub change: f32,
}

const _: () = assert!(size_of::<DensityTexel>() == 8);
