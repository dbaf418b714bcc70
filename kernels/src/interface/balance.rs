//! Balance of a frame's time between camera paths, light paths and shared light, which outlives a frame.

use bytemuck::{Pod, Zeroable};

/// Sums over frames of the variance and the cost of camera paths and light paths, old frames weighted less. Variances are means
/// over pixels, relative to the square of a pixel's value.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Balance {
    /// Sum over frames of the variance of light of camera paths.
    pub path_variance: f32,
    /// Sum of the variance of caustics, each times the number of light paths.
    pub caustic_variance: f32,
    /// Sum of the cost of camera paths (rays of camera paths).
    pub camera_cost: f32,
    /// Sum of the cost of a light path (rays of camera paths).
    pub light_cost: f32,
    /// Number of light paths of the next frame; 0: unknown.
    pub light_paths: u32,
}

/// Sums over the frames that share indirect light, old frames weighted less: gain and cost of sharing. Variances are means over
/// pixels, relative to the square of a pixel's value.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ShareBalance {
    /// Sum of the variance that sharing removes.
    pub gain: f32,
    /// Sum of the variance of all light without sharing.
    pub variance: f32,
    /// Sum of the cost of sharing (rays of camera paths).
    pub cost: f32,
    /// Sum of the cost of all else (rays of camera paths).
    pub other_cost: f32,
    /// Number of next frames that do not share.
    pub pause: u32,
}

impl ShareBalance {
    /// Gain of sharing over its cost. Above 1, variance times cost is smaller with sharing: (V - G) (C + c) < V C.
    /// 0 where no point shares.
    pub fn worth(&self) -> f32 {
        let (gain, cost) = (self.gain / self.variance, self.cost / self.other_cost);
        if cost > 0.0 { gain * (1.0 + cost) / cost } else { 0.0 }
    }

    /// Sums that count less, by a factor.
    pub fn faded(&self, factor: f32) -> ShareBalance {
        ShareBalance {
            gain: self.gain * factor,
            variance: self.variance * factor,
            cost: self.cost * factor,
            other_cost: self.other_cost * factor,
            pause: self.pause,
        }
    }
}

/// Light paths per pixel in a first frame.
pub const FIRST_PATHS: f32 = 0.5;
/// Minimum number of light paths per pixel.
pub const MIN_PATHS: f32 = 0.0625;
/// Maximum number of light paths per pixel.
pub const MAX_PATHS: u32 = 4;

const _: () = assert!(size_of::<Balance>() == 20);
const _: () = assert!(size_of::<ShareBalance>() == 20);
