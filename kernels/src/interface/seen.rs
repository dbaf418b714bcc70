//! What pixels showed, as it outlives a frame.

use bytemuck::{Pod, Zeroable};

/// What a pixel showed, frames of earlier poses less.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PixelSum {
    /// Sum of what camera paths found, the mean of its channels (W m^-2 sr^-1).
    pub path: f32,
    /// Frames in that sum.
    pub path_frames: f32,
    /// Sum of what light paths brought (W m^-2 sr^-1).
    pub caustics: f32,
    /// Frames in that sum.
    pub caustic_frames: f32,
}

impl PixelSum {
    /// The mean of all light (W m^-2 sr^-1).
    pub fn mean(&self) -> f32 {
        let over = |sum: f32, frames: f32| if frames > 0.0 { sum / frames } else { 0.0 };
        over(self.path, self.path_frames) + over(self.caustics, self.caustic_frames)
    }
}

const _: () = assert!(size_of::<PixelSum>() == 16);
