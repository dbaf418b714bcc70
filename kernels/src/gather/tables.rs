//! Tables that the passes of a gather read and write.

use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::material::Material;
use crate::interface::point::{PhotonGeometry, PhotonLight, PointGeometry, PointShading};
use crate::platform::{AtomicWords, Slots};

/// Tables for building an index.
pub struct Build<'a> {
    /// Settings.
    pub params: &'a FrameParams,
    /// Pixel at each position of the image's Morton order.
    pub pixel_order: &'a [u32],
    /// Points by pixel.
    pub point_geometry: &'a [PointGeometry],
    /// Photons of the batch.
    pub photon_geometry: &'a [PhotonGeometry],
    /// Their light.
    pub photon_light: &'a [PhotonLight],
    /// Number of photons.
    pub photon_count: u32,
    /// First words of the index.
    pub index_0: AtomicWords<'a>,
    /// Second words.
    pub index_1: AtomicWords<'a>,
    /// Third words.
    pub index_2: AtomicWords<'a>,
    /// Fourth words.
    pub index_3: AtomicWords<'a>,
    /// Photons in the order of the index.
    pub sorted_geometry: Slots<'a, PhotonGeometry>,
    /// Their light.
    pub sorted_light: Slots<'a, PhotonLight>,
}

impl Build<'_> {
    /// Point at an index of `pixel_order`; its `depth` is 0 where there is none.
    #[inline(always)]
    pub fn point(&self, index: u32) -> PointGeometry {
        self.point_geometry[self.pixel_order[index as usize] as usize]
    }
}

/// Tables that a gather reads, and sums that it adds to.
#[cfg_attr(not(target_arch = "spirv"), derive(Clone, Copy))]
pub struct Tables<'a> {
    /// Settings.
    pub params: &'a FrameParams,
    /// Code that is compiled in.
    pub features: Features,
    /// All materials.
    pub materials: &'a [Material],
    /// Pixel at each position of the image's Morton order.
    pub pixel_order: &'a [u32],
    /// Points by pixel.
    pub point_geometry: &'a [PointGeometry],
    /// Their shading.
    pub point_shading: &'a [PointShading],
    /// Photons of the batch; in the order of the index, if it sorts.
    pub photon_geometry: &'a [PhotonGeometry],
    /// Their light.
    pub photon_light: &'a [PhotonLight],
    /// Number of photons.
    pub photon_count: u32,
    /// First words of the index.
    pub index_0: &'a [u32],
    /// Second words.
    pub index_1: &'a [u32],
    /// Third words.
    pub index_2: &'a [u32],
    /// Fourth words.
    pub index_3: &'a [u32],
    /// Weight of an error of each pixel (1 / its light squared), where an emission learns.
    pub pixel_weights: &'a [f32],
    /// Sums by pixel, see `accumulator`.
    pub accumulator: AtomicWords<'a>,
    /// Scores of starts by texel and by leaf of the light pyramids, see `score`.
    pub start_scores: AtomicWords<'a>,
}
