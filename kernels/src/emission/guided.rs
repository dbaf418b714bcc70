//! Guided emission: starts light paths where earlier ones contributed to the image (`light::guided`), and learns where that is.
//!
//! Shooting counts the starts of every texel, gathering adds up their scores (`gather::score`). Before the next frame shoots,
//! both are added to the sums of earlier frames. Sums over nodes of each map give texels with few starts the mean of their
//! surroundings. Paths are sampled by the roots of the means. Where several lights share a map, the leaves of its light pyramid learn
//! as its texels do.
//!
//! In a frame before which something moved, the sums of earlier frames count half. An eighth of the frame's paths, the *pilot*,
//! is added to the sums before the other paths are sampled. Before the first frame it learns from *training paths*, whose light
//! is not shown. All sums are fixed before the paths that use them are sampled. Frames and their parts are therefore unbiased and may be
//! averaged.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{Emission, FrameStage, Step};
use crate::gather::score::{INVERSE_QUANTUM, WORDS};
use crate::interface::features::Features;
use crate::interface::frame::{Dispatch, FrameParams};
use crate::interface::guide::{GuideMap, GuideSum};
use crate::interface::light::Light;
use crate::light::density_map::Node;
use crate::light::guided::{Guided, GuidingPyramid, map_count, maps_of_group, max_map_count};
use crate::light::light_pyramid::{GuidedStart, LightNode, LightPyramid, LightRange};
use crate::math::is_finite;
use crate::math::quanta::Quanta;
use crate::pass::weigh::kept;
#[cfg(not(target_arch = "spirv"))]
use crate::pass::weigh::{WEIGH, weigh};
use crate::platform::{AtomicWords, Slots, Words};

crate::shoot_pass!(shared_entry "shoot.guided", |power, guide_maps: &[GuideMap], guide_pyramid: &[f32]| Guided {
    power,
    maps: guide_maps,
    pyramid: guide_pyramid
});

/// Emission guided by the scores of earlier light paths.
#[cfg(not(target_arch = "spirv"))]
pub const GUIDED: Emission = Emission {
    name: "guided",
    description: "lights, and directions in the casters' cones, by their contribution to earlier frames",
    cost: "up to 16 cones a path, an addition per pair of photon and point, passes over at most a million texels; before the \
            first frame, light paths as of 1.1 frames",
    limitations: "a frame depends on earlier frames; light that moves by more than about a texel a frame is found only by the first eighth \
            of a frame's paths; casters outside of the cones share a coarse map; of more than 32 lights, neighbours share their maps \
            of directions",
    uses_casters: true,
    shoot: &SHOOT,
    starts,
    stage: FrameStage {
        before_light: |params| learn(params, 0),
        after_pilot: Some(|params, pilot| {
            let mut steps = weigh(params, pilot.gathered);
            if pilot.has_weights {
                steps.extend(learn(params, 1));
            } else {
                steps.extend(["start_counts", "start_scores"].map(|buffer| Step::Clear { buffer }));
            }
            steps
        }),
        keeps: &["guide_maps", "guide_sums", "start_counts", "start_scores"],
        needs: &[&WEIGH],
        ..FrameStage::new("guided")
    },
};

/// Adds new scores to the sums and makes maps of the sums. At `time` 0, the first in a frame, the sums fade.
#[cfg(not(target_arch = "spirv"))]
fn learn(params: &FrameParams, time: u32) -> Vec<Step> {
    let nodes = |level| GuidingPyramid::count(level, map_count(params));
    let layout = LightPyramid::new(params);
    let share_maps = params.light_groups.share_maps();
    let leaves = |level| if share_maps { layout.count(level, map_count(params)) } else { 0 };
    let mut steps = vec![Step::level(&GUIDE_LEARN, time, nodes(0) + leaves(0))];
    if share_maps {
        steps.extend((1..=layout.top).map(|level| Step::level(&GUIDE_SUM_LIGHTS, level, leaves(level))));
    }
    steps.extend((1..=GuidingPyramid::TOP).map(|level| Step::level(&GUIDE_SUM, level, nodes(level))));
    steps.push(Step::level(&GUIDE_SUM, GuidingPyramid::TOP + 1, 1));
    if share_maps {
        steps.extend((0..=layout.top).map(|level| Step::level(&GUIDE_LIGHTS, level, leaves(level))));
    }
    steps.push(Step::level(&GUIDE_PYRAMID, 0, nodes(0)));
    steps.extend((1..=GuidingPyramid::TOP).map(|level| Step::level(&GUIDE_PYRAMID, level, nodes(level))));
    steps.push(Step::new(&GUIDE_SHARES, params));
    steps
}

/// Maximum mean score of a texel's starts in a frame, relative to their map, so that no single path dominates the map.
const MAX_SCORE: f32 = 64.0;
/// Unit of the scores of an unknown map, relative to the score of a map that all light of the image comes from.
const UNSEEN: f32 = 1.0e-6;
/// Weight of the mean of the node above, in starts of a texel.
const SHRINKAGE: f32 = 4.0;

/// Adds scores since the last time to the sums, a texel or a leaf of the light pyramids an invocation. At level 0 the sums fade.
#[pass(
    name = "guide.learn",
    over = GuidingPyramid::count(0, map_count(params)) + LightPyramid::max_leaves(params),
    work = Guide
)]
pub fn guide_learn(
    index: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    features: Features,
    image_rows: &[f32],
    guide_maps: &[GuideMap],
    #[len = start_words(params)] mut start_counts: AtomicWords<'_>,
    #[len = start_words(params) * WORDS] mut start_scores: AtomicWords<'_>,
    #[len = sums(params)] mut guide_sums: Slots<'_, GuideSum>,
) {
    let (mut keep_score, mut keep_starts) = (1.0, 1.0);
    if dispatch.level == 0 {
        let all = guide_sums.read(max_map_count(params) * GuidingPyramid::NODES).starts;
        keep_starts = kept(all / params.light_path_count as f32, params);
        // Scores are relative to the image: where the image became brighter, reduce earlier scores.
        keep_score = keep_starts * image_rows[params.height as usize + 1].min(1.0);
    }
    let (mut map, mut word) = (index / GuidingPyramid::TEXELS, index);
    let mut slot = GuidingPyramid::node(0, index).slot;
    if LightPyramid::is_used(params, features) {
        let (layout, texels) = (LightPyramid::new(params), GuidingPyramid::count(0, map_count(params)));
        if index >= texels {
            let leaf = index - texels;
            (map, word) = (leaf >> layout.top, GuidedStart { texel: 0, leaf }.leaf_word(params));
            slot = first_light_sum(params) + layout.node(0, leaf).slot;
        }
    }
    let unit = guide_maps[map as usize].unit;
    let quanta = Quanta { low: start_scores.get(word * WORDS), high: start_scores.get(word * WORDS + 1) };
    let starts = start_counts.get(word) as f32;
    start_scores.set(word * WORDS, 0);
    start_scores.set(word * WORDS + 1, 0);
    start_counts.set(word, 0);
    let mut score = quanta.to_f32(1.0 / INVERSE_QUANTUM);
    // Bound the score where the map's mean is known, which is then the unit.
    if guide_sums.read(GuidingPyramid::node(GuidingPyramid::TOP, map).slot).score > 0.0 {
        score = score.min(MAX_SCORE * starts);
    }
    let before = guide_sums.read(slot);
    let sum = GuideSum {
        score: before.score * keep_score + score * unit,
        starts: before.starts * keep_starts + starts,
    };
    // Forget a sum that is not finite: it would spoil all nodes above.
    guide_sums.write(slot, if is_finite(sum.score) { sum } else { GuideSum::default() });
}

/// Number of texels and leaves of all maps.
#[inline(always)]
fn start_words(params: &FrameParams) -> u32 {
    max_map_count(params) * GuidingPyramid::TEXELS + LightPyramid::max_leaves(params)
}

/// Number of sums: of the pyramids, of all maps together, and of the light pyramids.
#[inline(always)]
fn sums(params: &FrameParams) -> u32 {
    first_light_sum(params) + LightPyramid::max_nodes(params)
}

/// Index of the first sum of the light pyramids.
#[inline(always)]
fn first_light_sum(params: &FrameParams) -> u32 {
    max_map_count(params) * GuidingPyramid::NODES + 1
}

/// Sums the children of each node of a level of the light pyramids.
#[pass(name = "guide.sum-lights", over = LightPyramid::max_leaves(params), work = Guide)]
pub fn guide_sum_lights(
    index: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    #[len = sums(params)] mut guide_sums: Slots<'_, GuideSum>,
) {
    let LightNode { slot, below } = LightPyramid::new(params).node(dispatch.level, index);
    let first = first_light_sum(params);
    let sum = plus(guide_sums.read(first + below[0]), guide_sums.read(first + below[1]));
    guide_sums.write(first + slot, sum);
}

/// Computes the values that leaves of the light pyramids are sampled by. A leaf has its share of the group's power times the root of
/// its mean score, shrunk to the means of the nodes above it. Other nodes have the sum of their children.
#[pass(name = "guide.lights", over = LightPyramid::max_leaves(params), work = Guide)]
pub fn guide_lights(
    index: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    lights: &[Light],
    guide_sums: &[GuideSum],
    #[len = pyramid_values(params)] mut guide_pyramid: Slots<'_, f32>,
) {
    let layout = LightPyramid::new(params);
    let LightNode { slot, below } = layout.node(dispatch.level, index);
    let offset = LightPyramid::offset(params);
    if dispatch.level > 0 {
        let sum = guide_pyramid.read(offset + below[0]) + guide_pyramid.read(offset + below[1]);
        guide_pyramid.write(offset + slot, sum);
        return;
    }
    let all = guide_sums[(max_map_count(params) * GuidingPyramid::NODES) as usize];
    let mut mean = all.score / all.starts.max(1.0);
    let map = index >> layout.top;
    let leaf = layout.leaf_within(index);
    let mut above = layout.top + 1;
    while above > 0 {
        above -= 1;
        let node = first_light_sum(params) + map * layout.nodes() + layout.first(above) + (leaf >> above);
        mean = shrunk(guide_sums[node as usize], mean);
    }
    let group = map / maps_of_group(params);
    let power = LightRange::leaf(lights, params, (group << layout.top) + leaf).power;
    let group_power = LightRange::group(lights, params, group).power;
    let share = if group_power > 0.0 { power / group_power } else { 0.0 };
    guide_pyramid.write(offset + slot, share * mean.sqrt());
}

/// Mean score of a node, shrunk to that of the node above it.
#[inline(always)]
fn shrunk(sum: GuideSum, above: f32) -> f32 {
    (sum.score + SHRINKAGE * above) / (sum.starts + SHRINKAGE)
}

/// Number of values of the guiding pyramids and of the light pyramids.
#[inline(always)]
fn pyramid_values(params: &FrameParams) -> u32 {
    LightPyramid::offset(params) + LightPyramid::max_nodes(params)
}

/// Sums the children of each node of a level; above the maps' levels, the sum of all maps.
#[pass(name = "guide.sum", over = GuidingPyramid::count(1, map_count(params)), work = Guide)]
pub fn guide_sum(
    index: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    #[len = sums(params)] mut guide_sums: Slots<'_, GuideSum>,
) {
    let mut sum = GuideSum::default();
    if dispatch.level > GuidingPyramid::TOP {
        let mut map = 0;
        while map < map_count(params) {
            let root = guide_sums.read(GuidingPyramid::node(GuidingPyramid::TOP, map).slot);
            sum = plus(sum, root);
            map += 1;
        }
        guide_sums.write(max_map_count(params) * GuidingPyramid::NODES, sum);
        return;
    }
    let Node { slot, below } = GuidingPyramid::node(dispatch.level, index);
    let upper = plus(guide_sums.read(below[0]), guide_sums.read(below[1]));
    let lower = plus(guide_sums.read(below[2]), guide_sums.read(below[3]));
    guide_sums.write(slot, plus(upper, lower));
}

#[inline(always)]
fn plus(a: GuideSum, b: GuideSum) -> GuideSum {
    GuideSum { score: a.score + b.score, starts: a.starts + b.starts }
}

/// Computes the values that paths are sampled by. A texel has the root of its mean score, shrunk to the means of the nodes above
/// it. Other nodes have the sum of their children.
#[pass(name = "guide.pyramid", over = GuidingPyramid::count(0, map_count(params)), work = Guide)]
pub fn guide_pyramid(
    index: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    guide_sums: &[GuideSum],
    #[len = pyramid_values(params)] mut guide_pyramid: Slots<'_, f32>,
) {
    let Node { slot, below } = GuidingPyramid::node(dispatch.level, index);
    if dispatch.level > 0 {
        let (upper, lower) = (
            guide_pyramid.read(below[0]) + guide_pyramid.read(below[1]),
            guide_pyramid.read(below[2]) + guide_pyramid.read(below[3]),
        );
        guide_pyramid.write(slot, upper + lower);
        return;
    }
    let all = guide_sums[(max_map_count(params) * GuidingPyramid::NODES) as usize];
    let mut mean = all.score / all.starts.max(1.0);
    let (map, texel) = (index / GuidingPyramid::TEXELS, index % GuidingPyramid::TEXELS);
    let (x, y) = (texel % GuidingPyramid::SIDE, texel / GuidingPyramid::SIDE);
    let mut above = GuidingPyramid::TOP + 1;
    while above > 0 {
        above -= 1;
        let node = map * GuidingPyramid::NODES
            + GuidingPyramid::first(above)
            + (y >> above) * (GuidingPyramid::SIDE >> above)
            + (x >> above);
        mean = shrunk(guide_sums[node as usize], mean);
    }
    guide_pyramid.write(slot, mean.sqrt());
}

/// Computes the probability of each map.
#[pass(name = "guide.shares", over = 1, work = Guide)]
pub fn guide_shares(
    _index: u32,
    params: &FrameParams,
    lights: &[Light],
    guide_sums: &[GuideSum],
    guide_pyramid: &[f32],
    #[len = max_map_count(params)] mut guide_maps: Slots<'_, GuideMap>,
) {
    let (groups, maps) = (params.light_groups.count(), maps_of_group(params));
    // Add up the maps that can be sampled. Lights of no power are never sampled.
    let mut total = 0.0;
    let mut map = 0;
    while map < groups * maps {
        if LightRange::group(lights, params, map / maps).power > 0.0 {
            total += mass(map, params, guide_sums, guide_pyramid);
        }
        map += 1;
    }
    let mut below = 0.0;
    map = 0;
    while map < groups * maps {
        let even = LightRange::group(lights, params, map / maps).power / maps as f32;
        let is_known = even > 0.0 && total > 0.0 && is_finite(total);
        let share = if is_known { mass(map, params, guide_sums, guide_pyramid) / total } else { even };
        let root = guide_sums[GuidingPyramid::node(GuidingPyramid::TOP, map).slot as usize];
        let sum = GuidingPyramid::total(guide_pyramid, map);
        guide_maps.write(
            map,
            GuideMap {
                below,
                share,
                unit: if root.score > 0.0 { root.score / root.starts } else { UNSEEN * even * even },
                scale: if sum > 0.0 { GuidingPyramid::TEXELS as f32 / sum } else { 0.0 },
            },
        );
        below += share;
        map += 1;
    }
}

/// Mean sampling value of a map; 0 where no path started, as in a cone that no position sees.
#[inline(always)]
fn mass(map: u32, params: &FrameParams, sums: &[GuideSum], pyramid: &[f32]) -> f32 {
    let root = sums[GuidingPyramid::node(GuidingPyramid::TOP, map).slot as usize];
    let mut mass = 0.0;
    if root.starts > 0.0 {
        mass = GuidingPyramid::total(pyramid, map) / GuidingPyramid::TEXELS as f32;
        // Texels hold the scores of the lights that were sampled so far; the light pyramid knows those of lights as it samples them now.
        if params.light_groups.share_maps() && root.score > 0.0 {
            let layout = LightPyramid::new(params);
            let lights = pyramid[(LightPyramid::offset(params) + layout.node(layout.top, map).slot) as usize];
            mass *= lights / (root.score / root.starts).sqrt();
        }
    }
    mass
}
