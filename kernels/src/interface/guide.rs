//! State of guided emission, which outlives a frame.

use bytemuck::{Pod, Zeroable};

/// A map of starts: the emission directions of a group of lights into the cone of one caster, or into all other directions.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GuideMap {
    /// Sum of the shares of the maps before this one.
    pub below: f32,
    /// Share of the guided paths that are sampled from this map.
    pub share: f32,
    /// Unit of scores: the mean score of the map's starts, or a value far below any score while that is unknown.
    pub unit: f32,
    /// Number of texels over the sum of the texels; 0: all texels are alike.
    pub scale: f32,
}

/// Sum over the starts of a texel, or of several texels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GuideSum {
    /// Sum of scores.
    pub score: f32,
    /// Number of starts, those of earlier poses weighted less.
    pub starts: f32,
}

const _: () = assert!(size_of::<GuideMap>() == 16);
const _: () = assert!(size_of::<GuideSum>() == 8);
