//! Positions of a frame's random numbers in low-discrepancy sequences.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::UVec4;

/// Number of groups of four numbers of a path that come from sequences; later numbers are independent.
pub const SEQUENCE_GROUPS: usize = 8;

/// A point of each group's sequence, equal in all pixels. A pixel scrambles it by itself, or moves it by the pixel's position in
/// the image.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Sequence {
    /// Four coordinates of each point, the first binary digit in the lowest bit.
    pub points: [UVec4; SEQUENCE_GROUPS],
    /// Seeds that scramble the points of all pixels alike, if pixels move them.
    pub seeds: [UVec4; SEQUENCE_GROUPS],
    /// Number of groups from sequences; 0: all numbers are independent.
    pub groups: u32,
    /// Index of the sequence; frames take turns in several.
    pub batch: u32,
    /// Width of the image (px) if pixels move points, else 0.
    pub width: u32,
    /// Zero.
    pub padding: u32,
}

const _: () = assert!(size_of::<Sequence>() == 32 * SEQUENCE_GROUPS + 16);
