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

/// Noise of a pixel with one collection point: sums over frames, those of earlier poses weighted less. Light is the mean of its
/// channels (W m^-2 sr^-1).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PixelNoise {
    /// Number of frames.
    pub frames: f32,
    /// Sum of the light.
    pub light: f32,
    /// Sum of its squares.
    pub light_square: f32,
    /// Sum of the caustics.
    pub caustic: f32,
    /// Sum of their squares.
    pub caustic_square: f32,
    /// Sum of the variances that their photons explain.
    pub photon_variance: f32,
}

impl PixelNoise {
    /// Variance of the light of a frame.
    pub fn variance(&self) -> f32 {
        variance(self.frames, self.light, self.light_square)
    }

    /// Variance of the caustics of a frame by the choice of the prefix: what their photons do not explain.
    pub fn variance_by_prefix(&self) -> f32 {
        let caustics = variance(self.frames, self.caustic, self.caustic_square);
        if self.frames > 0.0 { (caustics - self.photon_variance / self.frames).max(0.0) } else { 0.0 }
    }
}

/// Variance of one value, by the number of values and their sums; 0 for fewer than two.
fn variance(count: f32, sum: f32, square_sum: f32) -> f32 {
    if count < 2.0 {
        return 0.0;
    }
    let mean = sum / count;
    (square_sum / count - mean * mean).max(0.0)
}

const _: () = assert!(size_of::<PixelSum>() == 16);
const _: () = assert!(size_of::<PixelNoise>() == 24);
