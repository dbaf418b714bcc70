//! Guided emission: starts light paths where earlier ones contributed to the image (`light::guided`), and learns where that is.
//!
//! Shooting counts the starts of every texel, gathering adds up their scores (`gather::score`). Before the next frame shoots,
//! both are added to the sums of earlier frames. Sums over nodes of each map give texels with few starts the mean of their
//! surroundings. Paths are sampled by the roots of the means.
//!
//! In a frame before which something moved, the sums of earlier frames count half. An eighth of the frame's paths, the *pilot*,
//! is added to the sums before the other paths are sampled. All sums are fixed before the paths that use them are sampled. Frames
//! and their parts are therefore unbiased and may be averaged.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::declare::pass;
#[cfg(not(target_arch = "spirv"))]
use crate::declare::{Emission, FrameStage, Step};
use crate::gather::score::{INVERSE_QUANTUM, WORDS};
use crate::interface::frame::{Dispatch, FrameParams};
use crate::interface::guide::{GuideMap, GuideSum};
use crate::interface::light::Light;
use crate::interface::seen::PixelSum;
use crate::light::density_map::Node;
use crate::light::guided::{
    Group, Guided, GuidingPyramid, group_count, map_count, maps_of_group, max_map_count,
};
use crate::math::is_finite;
use crate::math::quanta::Quanta;
use crate::pass::weigh::kept;
#[cfg(not(target_arch = "spirv"))]
use crate::pass::weigh::{WEIGH, weigh_with_pilot};
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
    cost: "up to 16 cones a path, an addition per pair of photon and point, and passes over at most a million texels",
    limitations: "a frame depends on earlier frames; light that moves by more than about a texel a frame is found only by the first eighth \
            of a frame's paths; casters outside of the cones share a coarse map; after a light is switched, the lights behind it \
            in the table use each other's maps",
    uses_casters: true,
    shoot: &SHOOT,
    starts,
    stage: FrameStage {
        before_light: |params| learn(params, 0),
        after_pilot: Some(|params| {
            let mut steps = weigh_with_pilot(params);
            steps.extend(learn(params, 1));
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
    let mut steps = vec![Step::level(&GUIDE_LEARN, time, nodes(0))];
    steps.extend((1..=GuidingPyramid::TOP).map(|level| Step::level(&GUIDE_SUM, level, nodes(level))));
    steps.push(Step::level(&GUIDE_SUM, GuidingPyramid::TOP + 1, 1));
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

/// Adds scores since the last time to the sums, a texel an invocation. At level 0 the sums fade.
#[pass(name = "guide.learn", over = GuidingPyramid::count(0, map_count(params)), work = Guide)]
pub fn guide_learn(
    index: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    image_rows: &[f32],
    pixel_sums: &[PixelSum],
    guide_maps: &[GuideMap],
    #[len = max_map_count(params) * GuidingPyramid::TEXELS] mut start_counts: AtomicWords<'_>,
    #[len = max_map_count(params) * GuidingPyramid::TEXELS * WORDS] mut start_scores: AtomicWords<'_>,
    #[len = max_map_count(params) * GuidingPyramid::NODES + 1] mut guide_sums: Slots<'_, GuideSum>,
) {
    let (mut keep_score, mut keep_starts) = (1.0, 1.0);
    if dispatch.level == 0 {
        let all = guide_sums.read(max_map_count(params) * GuidingPyramid::NODES).starts;
        keep_starts = kept(all / params.light_path_count as f32, params);
        // Scores are relative to the image: where the image became brighter, reduce earlier scores.
        keep_score = keep_starts * image_rows[params.height as usize + 1].min(1.0);
    }
    // Forget all scores in the second frame: those of the first pilot knew of no caustic.
    let is_second = pixel_sums[0].path_frames == 1.0 + kept(1.0, params);
    if is_second && dispatch.level == 0 {
        (keep_score, keep_starts) = (0.0, 0.0);
    }
    let map = index / GuidingPyramid::TEXELS;
    let unit = guide_maps[map as usize].unit;
    let word = index * WORDS;
    let quanta = Quanta { low: start_scores.get(word), high: start_scores.get(word + 1) };
    let starts = start_counts.get(index) as f32;
    start_scores.set(word, 0);
    start_scores.set(word + 1, 0);
    start_counts.set(index, 0);
    let mut score = quanta.to_f32(1.0 / INVERSE_QUANTUM);
    // Bound the score where the map's mean is known, which is then the unit.
    if !is_second && guide_sums.read(GuidingPyramid::node(GuidingPyramid::TOP, map).slot).score > 0.0 {
        score = score.min(MAX_SCORE * starts);
    }
    let slot = GuidingPyramid::node(0, index).slot;
    let before = guide_sums.read(slot);
    let sum = GuideSum {
        score: before.score * keep_score + score * unit,
        starts: before.starts * keep_starts + starts,
    };
    // Forget a sum that is not finite: it would spoil all nodes above.
    guide_sums.write(slot, if is_finite(sum.score) { sum } else { GuideSum::default() });
}

/// Sums the children of each node of a level; above the maps' levels, the sum of all maps.
#[pass(name = "guide.sum", over = GuidingPyramid::count(1, map_count(params)), work = Guide)]
pub fn guide_sum(
    index: u32,
    params: &FrameParams,
    dispatch: Dispatch,
    #[len = max_map_count(params) * GuidingPyramid::NODES + 1] mut guide_sums: Slots<'_, GuideSum>,
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
    #[len = max_map_count(params) * GuidingPyramid::NODES] mut guide_pyramid: Slots<'_, f32>,
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
        let sum = guide_sums[node as usize];
        mean = (sum.score + SHRINKAGE * mean) / (sum.starts + SHRINKAGE);
    }
    guide_pyramid.write(slot, mean.sqrt());
}

/// Computes the probability of each map.
#[pass(name = "guide.shares", over = 1, work = Guide)]
pub fn guide_shares(
    _index: u32,
    params: &FrameParams,
    lights: &[Light],
    pixel_sums: &[PixelSum],
    guide_sums: &[GuideSum],
    guide_pyramid: &[f32],
    #[len = max_map_count(params)] mut guide_maps: Slots<'_, GuideMap>,
) {
    let (groups, maps) = (group_count(params), maps_of_group(params));
    // Add up the maps that can be sampled. Lights of no power are never sampled.
    let mut total = 0.0;
    let mut map = 0;
    while map < groups * maps {
        if Group::new(lights, params, map / maps).power > 0.0 {
            total += mass(map, guide_sums, guide_pyramid);
        }
        map += 1;
    }
    let is_first = pixel_sums[0].path_frames == 1.0;
    let mut below = 0.0;
    map = 0;
    while map < groups * maps {
        let even = Group::new(lights, params, map / maps).power / maps as f32;
        let is_known = even > 0.0 && total > 0.0 && is_finite(total);
        let share = if is_known { mass(map, guide_sums, guide_pyramid) / total } else { even };
        let root = guide_sums[GuidingPyramid::node(GuidingPyramid::TOP, map).slot as usize];
        let sum = GuidingPyramid::total(guide_pyramid, map);
        guide_maps.write(
            map,
            GuideMap {
                below,
                share,
                // Scores of the first pilot are no measure of later scores.
                unit: if root.score > 0.0 && !is_first {
                    root.score / root.starts
                } else {
                    UNSEEN * even * even
                },
                scale: if sum > 0.0 { GuidingPyramid::TEXELS as f32 / sum } else { 0.0 },
            },
        );
        below += share;
        map += 1;
    }
}

/// Mean sampling value of a map; 0 where no path started, as in a cone that no position sees.
#[inline(always)]
fn mass(map: u32, sums: &[GuideSum], pyramid: &[f32]) -> f32 {
    let root = sums[GuidingPyramid::node(GuidingPyramid::TOP, map).slot as usize];
    if root.starts > 0.0 { GuidingPyramid::total(pyramid, map) / GuidingPyramid::TEXELS as f32 } else { 0.0 }
}
