//! Light pyramids of guided emission: learnt distributions over the lights of a group, one for each map of the group.
//!
//! A pyramid is binary, over leaves of one light or of a few. Its leaves stand in the order of their keys, so that neighbours in space
//! are near each other in it. A leaf has its share of the group's power times the root of its mean score; other nodes have
//! the sum of their children. Light pyramids lie behind the guiding pyramids, in the same buffers.

use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::light::Light;
use crate::light::guided::{GuidingPyramid, maps_of_group, max_map_count};
use crate::math::BELOW_ONE;

/// Lights of consecutive keys, which lie one behind the other in the light table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightRange {
    /// Id of the first light.
    pub first: u32,
    /// Id behind the last light.
    pub end: u32,
    /// Share of the power of the lights before the range.
    pub below: f32,
    /// Share of the power of its own lights.
    pub power: f32,
}

/// Share of the power of the lights before this one.
#[inline(always)]
fn power_below(lights: &[Light], params: &FrameParams, light_id: u32) -> f32 {
    if light_id < params.light_count { lights[light_id as usize].power_below } else { 1.0 }
}

/// Id of the first light of this key or of a larger one.
#[inline(always)]
fn first_light(lights: &[Light], params: &FrameParams, key: u32) -> u32 {
    let count = params.light_count;
    if count == params.light_groups.key_count {
        // All lights shine
        return key.min(count);
    }
    let (mut low, mut high) = (0, count);
    while low < high {
        let middle = (low + high) / 2;
        if lights[middle as usize].key < key {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}

impl LightRange {
    /// Lights of `2^keys_log2` keys; `index` counts such ranges from the first key on.
    #[inline(always)]
    fn new(lights: &[Light], params: &FrameParams, index: u32, keys_log2: u32) -> LightRange {
        let first = first_light(lights, params, index << keys_log2);
        let end = first_light(lights, params, (index + 1) << keys_log2);
        let below = power_below(lights, params, first);
        let mut power = power_below(lights, params, end) - below;
        if first + 1 == end {
            // Behind a bright light the difference of a dim one would be rounded to 0
            power = lights[first as usize].pdf_light_choice;
        }
        LightRange { first, end, below, power }
    }

    /// Lights of a group.
    #[inline(always)]
    pub fn group(lights: &[Light], params: &FrameParams, group: u32) -> LightRange {
        let groups = params.light_groups;
        LightRange::new(lights, params, group, groups.leaf_keys_log2 + groups.group_leaves_log2)
    }

    /// Lights of a leaf, counted over all groups.
    #[inline(always)]
    pub fn leaf(lights: &[Light], params: &FrameParams, leaf: u32) -> LightRange {
        LightRange::new(lights, params, leaf, params.light_groups.leaf_keys_log2)
    }

    /// Samples a light by power.
    #[inline(always)]
    pub fn light_at(&self, lights: &[Light], u: f32) -> u32 {
        // Compare differences, which keep all their bits; sums would be rounded onto lights without power.
        let at = u * self.power;
        let (mut low, mut high) = (self.first, self.end);
        while low + 1 < high {
            let middle = (low + high) / 2;
            if lights[middle as usize].power_below - self.below <= at {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    /// Probability that `light_at` samples a light.
    #[inline(always)]
    pub fn probability(&self, lights: &[Light], params: &FrameParams, light_id: u32) -> f32 {
        let power = power_below(lights, params, light_id + 1) - power_below(lights, params, light_id);
        if self.first + 1 == self.end {
            1.0
        } else if self.power > 0.0 {
            power / self.power
        } else {
            0.0
        }
    }
}

/// A node of the light pyramids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightNode {
    /// Index of the node among those of all light pyramids.
    pub slot: u32,
    /// Indices of its two children; meaningless for a leaf.
    pub below: [u32; 2],
}

/// The layout of the light pyramids of all maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightPyramid {
    /// Base-2 logarithm of the number of leaves of a light pyramid: the level of the root.
    pub top: u32,
}

impl LightPyramid {
    /// Whether light pyramids sample lights: some lights share their maps.
    #[inline(always)]
    pub fn is_used(params: &FrameParams, features: Features) -> bool {
        features.has(Features::LIGHT_PYRAMIDS) && params.light_groups.share_maps()
    }

    /// Layout in a frame.
    #[inline(always)]
    pub fn new(params: &FrameParams) -> LightPyramid {
        LightPyramid { top: params.light_groups.group_leaves_log2 }
    }

    /// Number of nodes of a light pyramid.
    #[inline(always)]
    pub fn nodes(&self) -> u32 {
        (2 << self.top) - 1
    }

    /// Index of a leaf within the light pyramid that holds it, from its index over those of several maps or groups.
    #[inline(always)]
    pub fn leaf_within(&self, leaf: u32) -> u32 {
        leaf - ((leaf >> self.top) << self.top)
    }

    /// Number of nodes of a level over `maps` maps.
    #[inline(always)]
    pub fn count(&self, level: u32, maps: u32) -> u32 {
        maps << (self.top - level)
    }

    /// Index of the first node of a level within a light pyramid.
    #[inline(always)]
    pub fn first(&self, level: u32) -> u32 {
        (2 << self.top) - (2 << (self.top - level))
    }

    /// A node of a level, counted over all maps.
    #[inline(always)]
    pub fn node(&self, level: u32, index: u32) -> LightNode {
        let map = index >> (self.top - level);
        let node = index - (map << (self.top - level));
        let base = map * self.nodes();
        let mut below = 0;
        if level > 0 {
            below = base + self.first(level - 1) + 2 * node;
        }
        LightNode { slot: base + self.first(level) + node, below: [below, below + 1] }
    }

    /// Index of the first node in the buffer of the guiding pyramids.
    #[inline(always)]
    pub fn offset(params: &FrameParams) -> u32 {
        max_map_count(params) * GuidingPyramid::NODES
    }

    /// Number of nodes for any table of lights; none where no lights share their maps.
    #[inline(always)]
    pub fn max_nodes(params: &FrameParams) -> u32 {
        if params.light_groups.share_maps() {
            max_map_count(params) * LightPyramid::new(params).nodes()
        } else {
            0
        }
    }

    /// Number of leaves for any table of lights; none where no lights share their maps.
    #[inline(always)]
    pub fn max_leaves(params: &FrameParams) -> u32 {
        if params.light_groups.share_maps() {
            max_map_count(params) << LightPyramid::new(params).top
        } else {
            0
        }
    }

    /// Samples a leaf of a map's light pyramid. `values` are those of all nodes, with `offset` of the first.
    #[inline(always)]
    pub fn sample(&self, values: &[f32], offset: u32, map: u32, u: f32) -> u32 {
        let base = offset + map * self.nodes();
        let (mut u, mut leaf, mut level) = (u, 0, self.top);
        while level > 0 {
            level -= 1;
            let child = base + self.first(level) + 2 * leaf;
            let (left, right) = (values[child as usize], values[(child + 1) as usize]);
            let along = u * (left + right);
            let is_right = along >= left;
            // Keep below one: a child without a value must not be sampled.
            u = if is_right { (along - left) / right } else { along / left };
            u = u.min(BELOW_ONE);
            leaf = 2 * leaf + u32::from(is_right);
        }
        leaf
    }
}

/// The start of a light path as guided emission counts it: a map, a texel of it, and a leaf of the map's light pyramid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GuidedStart {
    /// Texel, counted over all maps.
    pub texel: u32,
    /// Leaf, counted over the light pyramids of all maps.
    pub leaf: u32,
}

impl GuidedStart {
    /// Index of the leaf in counts and scores of starts, where leaves lie behind all texels.
    #[inline(always)]
    pub fn leaf_word(&self, params: &FrameParams) -> u32 {
        max_map_count(params) * GuidingPyramid::TEXELS + self.leaf
    }

    /// One number for the start of a path, from the leaf counted over all groups. Where no lights share their maps it is the texel.
    #[inline(always)]
    pub fn encode(params: &FrameParams, leaf: u32, map_of_group: u32, texel: u32) -> u32 {
        (leaf * maps_of_group(params) + map_of_group) * GuidingPyramid::TEXELS + texel
    }

    /// The start with this number.
    #[inline(always)]
    pub fn decode(code: u32, params: &FrameParams, features: Features) -> GuidedStart {
        if !LightPyramid::is_used(params, features) {
            return GuidedStart { texel: code, leaf: 0 };
        }
        let (maps, layout) = (maps_of_group(params), LightPyramid::new(params));
        let (node, texel) = (code / GuidingPyramid::TEXELS, code % GuidingPyramid::TEXELS);
        let leaf = node / maps;
        let map = (leaf >> layout.top) * maps + node % maps;
        GuidedStart {
            texel: map * GuidingPyramid::TEXELS + texel,
            leaf: (map << layout.top) + layout.leaf_within(leaf),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::guide::LightGroups;

    /// Lights with these shares of the power, and frames of one map a group.
    fn lights(powers: impl Iterator<Item = f64>) -> (Vec<Light>, FrameParams) {
        let (mut lights, mut below) = (Vec::new(), 0.0);
        for (key, power) in powers.enumerate() {
            lights.push(Light { power_below: below as f32, key: key as u32, ..Light::default() });
            below += power;
        }
        let count = lights.len() as u32;
        let light_groups = LightGroups::new(count, 0);
        (lights, FrameParams { light_count: count, light_groups, ..FrameParams::default() })
    }

    /// Beside a light of nearly all power: lights at the last bits of its share, and lights without power.
    #[test]
    fn lights_of_a_group_are_sampled_with_their_probability() {
        let power = |id: u32| if id == 0 { 1.0 - 4.0e-5 } else { 1.0e-7 * f64::from(id % 3) };
        let (lights, params) = lights((0..400).map(power));
        let (mut dim, mut without) = (0, 0);
        for index in 0..params.light_groups.count() {
            let group = LightRange::group(&lights, &params, index);
            let samples = 1 << 16;
            let mut sampled = vec![0; lights.len()];
            for sample in 0..samples {
                sampled[group.light_at(&lights, (sample as f32 + 0.5) / samples as f32) as usize] += 1;
            }
            let mut all = 0.0;
            for light_id in group.first..group.end {
                let probability = group.probability(&lights, &params, light_id);
                let found = sampled[light_id as usize] as f32 / samples as f32;
                assert!(
                    (found - probability).abs() <= 2.0 / samples as f32,
                    "{index}, {light_id}: {found}, {probability}"
                );
                assert!(probability > 0.0 || found == 0.0, "{light_id} is sampled");
                all += probability;
                dim += u32::from(probability > 0.0);
                without += u32::from(probability == 0.0);
            }
            assert!((all - 1.0).abs() < 1e-5, "{index}: {all}");
        }
        assert!(dim > 200 && without > 100, "{dim}, {without}");
    }

    /// Every light is in one group and one leaf, for any number of lights, also where some of them are off.
    #[test]
    fn groups_and_leaves_partition_the_lights() {
        for (keys, casters) in [(1, 1), (2, 16), (32, 0), (33, 0), (201, 1), (10_001, 16), (100_000, 1)] {
            let groups = LightGroups::new(keys, casters);
            assert!(groups.count() <= LightGroups::max_count(casters), "{keys}");
            let lights: Vec<Light> = (0..keys)
                .filter(|key| keys == 1 || key % 7 != 3)
                .map(|key| Light { key, ..Light::default() })
                .collect();
            let params = FrameParams {
                light_count: lights.len() as u32,
                light_groups: groups,
                ..FrameParams::default()
            };
            let (mut end, mut leaf_end) = (0, 0);
            for group in 0..groups.count() {
                let range = LightRange::group(&lights, &params, group);
                assert_eq!(range.first, end, "{keys}");
                end = range.end;
                for leaf in 0..1 << groups.group_leaves_log2 {
                    let leaf = LightRange::leaf(&lights, &params, (group << groups.group_leaves_log2) + leaf);
                    assert_eq!(leaf.first, leaf_end, "{keys}");
                    assert!(leaf.end <= leaf.first + (1 << groups.leaf_keys_log2), "{keys}");
                    leaf_end = leaf.end;
                }
                assert_eq!(leaf_end, end, "{keys}");
            }
            assert_eq!(end as usize, lights.len(), "{keys}");
        }
    }

    /// Each leaf is sampled by its value, and none without one, at the last numbers below 1 either.
    #[test]
    fn leaves_are_sampled_by_their_values() {
        let layout = LightPyramid { top: 4 };
        let leaf_value = |leaf: u32| if leaf.is_multiple_of(3) { 0.0 } else { 1.0 + leaf as f32 };
        let (maps, offset) = (3, 5);
        let mut values = vec![0.0; (offset + maps * layout.nodes()) as usize];
        for level in 0..=layout.top {
            for index in 0..layout.count(level, maps) {
                let LightNode { slot, below } = layout.node(level, index);
                values[(offset + slot) as usize] = if level == 0 {
                    leaf_value(index % 16)
                } else {
                    below.iter().map(|child| values[(offset + child) as usize]).sum()
                };
            }
        }
        let total: f32 = (0..16).map(leaf_value).sum();
        let samples = 1 << 16;
        let mut sampled = [0; 16];
        for sample in 0..samples {
            let u = (sample as f32 + 0.5) / samples as f32;
            sampled[layout.sample(&values, offset, 1, u) as usize] += 1;
        }
        sampled[layout.sample(&values, offset, 1, BELOW_ONE) as usize] += 1;
        for leaf in 0..16 {
            let expected = leaf_value(leaf) / total * samples as f32;
            let found = sampled[leaf as usize] as f32;
            assert!(
                (found - expected).abs() <= 3.0 && (expected > 0.0 || found == 0.0),
                "{leaf}: {found}, {expected}"
            );
        }
    }

    /// Codes of starts are those of one texel and one leaf.
    #[test]
    fn codes_of_starts_decode_to_the_texel_and_the_leaf_of_their_map() {
        let mut params = FrameParams { light_groups: LightGroups::new(300, 4), ..FrameParams::default() };
        params.casters.count = 4;
        let layout = LightPyramid::new(&params);
        for (leaf, map_of_group, texel) in [(0, 0, 0), (17, 3, 5), (299, 4, 4095)] {
            let code = GuidedStart::encode(&params, leaf, map_of_group, texel);
            let map = (leaf >> layout.top) * 5 + map_of_group;
            let expected = GuidedStart {
                texel: map * GuidingPyramid::TEXELS + texel,
                leaf: (map << layout.top) + leaf % (1 << layout.top),
            };
            assert_eq!(GuidedStart::decode(code, &params, Features::LIGHT_PYRAMIDS), expected);
        }
    }
}
