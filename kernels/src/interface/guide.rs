//! What guided emission learns, as it outlives a frame.

use bytemuck::{Pod, Zeroable};

/// A map of starts: of the aims of a group of lights at one caster, or at everything else.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GuideMap {
    /// Sum of the shares of the maps before it.
    pub below: f32,
    /// Share of guided paths that are drawn from it.
    pub share: f32,
    /// Unit of what is scored: the mean score of its starts, or what is far below any where nothing is known.
    pub unit: f32,
    /// Texels over the sum of its texels; 0: all are alike.
    pub scale: f32,
}

/// What the starts of a texel gave, or those of some.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GuideSum {
    /// Sum of their scores.
    pub score: f32,
    /// How many they are, those of earlier poses less.
    pub starts: f32,
}

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

const _: () = assert!(size_of::<GuideMap>() == 16);
const _: () = assert!(size_of::<GuideSum>() == 8);
const _: () = assert!(size_of::<PixelSum>() == 16);
