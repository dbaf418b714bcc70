//! What guided emission learns, as it outlives a frame.

use bytemuck::{Pod, Zeroable};

/// A map of starts: of the aims of a group of lights at one caster, or at everything else.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GuideMap {
    /// Sum of the shares of the maps before it.
    pub below: f32,
    /// Share of guided paths that are sampled from it.
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

const _: () = assert!(size_of::<GuideMap>() == 16);
const _: () = assert!(size_of::<GuideSum>() == 8);
