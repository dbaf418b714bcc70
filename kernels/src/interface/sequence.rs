//! Where the numbers of a frame stand in low-discrepancy sequences.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::UVec4;

/// Groups of four numbers of a path that come from sequences; later ones are independent.
pub const SEQUENCE_GROUPS: usize = 8;

/// A point of each group's sequence, the same in all pixels: each scrambles it by itself, or moves it by its position in the image.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Sequence {
    /// Four coordinates of each point, the first binary digit in the lowest bit.
    pub points: [UVec4; SEQUENCE_GROUPS],
    /// What scrambles the points of all pixels alike, where they are moved.
    pub seeds: [UVec4; SEQUENCE_GROUPS],
    /// Groups that there are: none where all numbers are independent.
    pub groups: u32,
    /// Which of the sequences that frames take in turns.
    pub batch: u32,
    /// Pixels to a row of the image where points are moved, else 0.
    pub width: u32,
    /// Zero.
    pub padding: u32,
}

const _: () = assert!(size_of::<Sequence>() == 32 * SEQUENCE_GROUPS + 16);
