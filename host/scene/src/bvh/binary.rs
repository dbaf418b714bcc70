//! The binary BVH over boxes that a four-wide BVH is built from. Imports obvhs.

use clap::ValueEnum;
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::{Reinsertion, find_reinsertion, reinsert_node};
use obvhs::bvh2::{Bvh2, DEFAULT_MAX_STACK_DEPTH};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::clustering;

/// BVH build quality. Changes rounding, not the expected image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BvhQuality {
    /// Clustered bottom up, built soonest; rays take up to a tenth longer
    Fast,
    /// Nodes moved to where they cost less too, in two passes: a third of the build
    #[default]
    Medium,
    /// Moved in sixteen passes: twice as long to build, and rays take a few percent less at most
    Best,
}

impl BvhQuality {
    /// Share of the nodes that each pass tries to reinsert.
    fn passes(self) -> Vec<f32> {
        match self {
            BvhQuality::Fast => vec![],
            BvhQuality::Medium => vec![0.25, 0.1],
            BvhQuality::Best => (1..32).step_by(2).map(|pass| 0.5 / pass as f32).collect(),
        }
    }
}

/// Builds a binary BVH: clusters boxes bottom up, then reinserts nodes where they cost less [Meister and Bittner 2018]. The
/// number of threads changes no bit.
pub fn build(boxes: &[Aabb], quality: BvhQuality) -> Bvh2 {
    let (mut binary, passes) = clustering::build(boxes);
    binary.update_parents();
    for (pass, share) in quality.passes().into_iter().enumerate() {
        // The search's stack is limited; a deeper BVH is balanced later instead.
        let max_levels = passes + 1;
        let is_known = pass == 0 && max_levels <= DEFAULT_MAX_STACK_DEPTH;
        let levels = if is_known { max_levels } else { depth(&binary) };
        if binary.nodes[0].is_leaf() || levels > DEFAULT_MAX_STACK_DEPTH {
            break;
        }
        reinsert(&mut binary, share);
    }
    binary
}

/// Number of levels of nodes.
fn depth(binary: &Bvh2) -> usize {
    let (mut deepest, mut stack) = (0, vec![(0, 1)]);
    while let Some((id, depth)) = stack.pop() {
        deepest = deepest.max(depth);
        let node = &binary.nodes[id as usize];
        if !node.is_leaf() {
            stack.extend([(node.first_index, depth + 1), (node.first_index + 1, depth + 1)]);
        }
    }
    deepest
}

/// Reinserts the largest of the first nodes, a share of all, where they make the BVH cheapest. The largest gains go first; moves
/// that touch a node of an earlier move are skipped. `ReinsertionOptimizer` of obvhs leaves ties between equal nodes open.
fn reinsert(binary: &mut Bvh2, share: f32) {
    let count = ((binary.nodes.len() as f32 * share) as usize).clamp(1, binary.nodes.len() - 1);
    let near = &binary.nodes[..binary.nodes.len().min(2 * count + 2)];
    let mut candidates: Vec<(f32, u32)> =
        (1..).zip(&near[1..]).map(|(id, node)| (node.aabb().half_area(), id)).collect();
    if candidates.len() > count {
        candidates.select_nth_unstable_by(count, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        candidates.truncate(count);
    }
    // Sort by id: neighbours in memory are neighbours in space.
    candidates.par_sort_unstable_by_key(|candidate| candidate.1);
    let best = candidates.par_iter().map(|&(_, id)| find_reinsertion(binary, id as usize));
    let mut moves: Vec<Reinsertion> = best.filter(|best| best.area_diff > 0.0).collect();
    moves.par_sort_unstable_by(|a, b| b.area_diff.total_cmp(&a.area_diff).then(a.from.cmp(&b.from)));

    let mut touched = vec![false; binary.nodes.len()];
    for Reinsertion { from, to, .. } in moves {
        let parent = |id: u32| binary.parents[id as usize] as usize;
        let (from, to, from_parent, to_parent) = (from as usize, to as usize, parent(from), parent(to));
        let ends = [to, from, Bvh2Node::get_sibling_id(from), to_parent, from_parent];
        if ends.iter().all(|&end| !touched[end]) {
            ends.iter().for_each(|&end| touched[end] = true);
            reinsert_node(binary, from, to);
        }
    }
}
