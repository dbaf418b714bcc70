//! The radiance cache: cells of diffuse surfaces with the light that camera paths found behind them.

use super::NONE;
use super::point::SHARED_DEPTHS;
use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// Cell of the cache. Two vertices have equal keys if they lie in one cell of one surface, and at one depth of their paths.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct CacheKey {
    /// Low halves of the cell's indices along x and y.
    pub xy: u32,
    /// Low half of the index along z. Above it are the exponent of the edge (8 bits), the side of the surface (3) and the camera
    /// vertex (5).
    pub z_edge_side_depth: u32,
    /// Index into the materials.
    pub material: u32,
}

/// Light that one camera path found behind a vertex.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct CacheSample {
    /// Cell of the vertex.
    pub key: CacheKey,
    /// Radiance that a white surface would show (W m^-2 sr^-1), as the light of an
    /// [`IndirectSample`](super::point::IndirectSample). `NONE`: the path gives nothing.
    pub light: [u32; SHARED_DEPTHS],
}

impl Default for CacheSample {
    fn default() -> Self {
        CacheSample { key: CacheKey::default(), light: [NONE; SHARED_DEPTHS] }
    }
}

/// A cell of the cache.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct CacheCell {
    /// Sums of the samples' light (W m^-2 sr^-1).
    pub light: [Vec3; SHARED_DEPTHS],
    /// Number of samples; 0 marks a free cell.
    pub count: f32,
    /// Its key.
    pub key: CacheKey,
}

/// Number of samples from which on paths end in a cell.
pub const MIN_SAMPLES: f32 = 4.0;

impl CacheCell {
    /// Whether its mean is known well enough for paths to end in it.
    #[inline(always)]
    pub fn is_known(&self) -> bool {
        self.count >= MIN_SAMPLES
    }
}

const _: () = assert!(size_of::<CacheSample>() == 24);
const _: () = assert!(size_of::<CacheCell>() == 52);
