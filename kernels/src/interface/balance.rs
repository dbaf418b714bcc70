//! Balance of a frame's time between camera paths and light paths, which outlives a frame.

use bytemuck::{Pod, Zeroable};

/// Sums over frames of the variance and the cost of camera paths and light paths, old frames weighted less. Variances are means
/// over pixels, relative to the square of a pixel's value.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Balance {
    /// Sum over frames of the variance of light of camera paths.
    pub path_variance: f32,
    /// Sum of the variance of light of light paths, each times their number.
    pub caustic_variance: f32,
    /// Sum of the cost of camera paths (rays of camera paths).
    pub camera_cost: f32,
    /// Sum of the cost of a light path (rays of camera paths).
    pub light_cost: f32,
    /// Number of light paths of the next frame; 0: unknown.
    pub light_paths: u32,
}

/// Light paths per pixel in a first frame.
pub const FIRST_PATHS: f32 = 0.5;
/// Minimum number of light paths per pixel.
pub const MIN_PATHS: f32 = 0.0625;
/// Maximum number of light paths per pixel.
pub const MAX_PATHS: u32 = 4;

const _: () = assert!(size_of::<Balance>() == 20);
