//! Light of pixels, which outlives a frame.

use bytemuck::{Pod, Zeroable};

/// Light of a pixel, frames of earlier poses weighted less.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PixelSum {
    /// Sum of the light of camera paths, as the mean of its channels (W m^-2 sr^-1).
    pub path: f32,
    /// Number of frames in `path`.
    pub path_frames: f32,
    /// Sum of the light of light paths (W m^-2 sr^-1).
    pub caustics: f32,
    /// Number of frames in `caustics`.
    pub caustic_frames: f32,
}

impl PixelSum {
    /// Mean of all light (W m^-2 sr^-1).
    pub fn mean(&self) -> f32 {
        let over = |sum: f32, frames: f32| if frames > 0.0 { sum / frames } else { 0.0 };
        over(self.path, self.path_frames) + over(self.caustics, self.caustic_frames)
    }
}

const _: () = assert!(size_of::<PixelSum>() == 16);
