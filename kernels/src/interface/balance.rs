//! How a frame's time is shared between camera paths and light paths, as it outlives a frame.

use bytemuck::{Pod, Zeroable};

/// What frames said of their camera paths and light paths, those of long ago less. Variances are means over pixels, relative to
/// the squares of what they show.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Balance {
    /// Sum over frames of the variance of what camera paths found.
    pub path_variance: f32,
    /// Sum of that of what light paths brought, each times their number.
    pub caustic_variance: f32,
    /// Sum of what camera paths cost (rays of theirs).
    pub camera_cost: f32,
    /// Sum of what a light path cost (rays of camera paths).
    pub light_cost: f32,
    /// Light paths of the next frame; 0: nothing is known.
    pub light_paths: u32,
}

/// Light paths a pixel in a first frame.
pub const FIRST_PATHS: f32 = 0.5;
/// Fewest light paths a pixel.
pub const MIN_PATHS: f32 = 0.0625;
/// Most light paths a pixel.
pub const MAX_PATHS: u32 = 4;

const _: () = assert!(size_of::<Balance>() == 20);
