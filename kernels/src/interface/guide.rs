//! State of guided emission, which outlives a frame, and its layout.

use bytemuck::{Pod, Zeroable};

/// Largest number of maps of guided emission.
const MAX_MAPS: u32 = 256;
/// Largest number of groups of lights.
const MAX_GROUPS: u32 = 32;
/// Largest number of leaves of all light pyramids.
const MAX_LEAVES: u32 = 1 << 14;

/// Groups of lights: lights of consecutive keys share the maps of guided emission. Where a group has several lights, each of its
/// maps has a light pyramid. A leaf of it holds one light, or several of consecutive keys.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct LightGroups {
    /// Number of keys: all lights of the scene, whether they shine in this frame or not.
    pub key_count: u32,
    /// Base-2 logarithm of the number of keys of a leaf.
    pub leaf_keys_log2: u32,
    /// Base-2 logarithm of the number of leaves of a group.
    pub group_leaves_log2: u32,
}

impl LightGroups {
    /// Largest number of groups beside this number of casters.
    #[inline(always)]
    pub fn max_count(casters: u32) -> u32 {
        (MAX_MAPS / (casters + 1)).min(MAX_GROUPS)
    }

    /// Groups of this number of keys: as many as there are maps for, with at most twice the lights of equal shares.
    pub fn new(key_count: u32, casters: u32) -> LightGroups {
        let (mut leaf_keys_log2, mut group_leaves_log2) = (0, 0);
        while key_count.div_ceil(1 << leaf_keys_log2) > MAX_LEAVES {
            leaf_keys_log2 += 1;
        }
        while key_count.div_ceil(1 << (leaf_keys_log2 + group_leaves_log2)) > LightGroups::max_count(casters)
        {
            group_leaves_log2 += 1;
        }
        LightGroups { key_count, leaf_keys_log2, group_leaves_log2 }
    }

    /// Number of groups.
    #[inline(always)]
    pub fn count(&self) -> u32 {
        self.key_count.div_ceil(1 << (self.leaf_keys_log2 + self.group_leaves_log2)).max(1)
    }

    /// Whether some lights share their maps.
    #[inline(always)]
    pub fn share_maps(&self) -> bool {
        self.leaf_keys_log2 + self.group_leaves_log2 > 0
    }
}

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

/// Sum over the starts of a texel or of a light, or of several of them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GuideSum {
    /// Sum of scores.
    pub score: f32,
    /// Number of starts, those of earlier poses weighted less.
    pub starts: f32,
}

const _: () = assert!(size_of::<LightGroups>() == 12);
const _: () = assert!(size_of::<GuideMap>() == 16);
const _: () = assert!(size_of::<GuideSum>() == 8);
