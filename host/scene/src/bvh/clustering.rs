//! Parallel locally-ordered clustering (PLOC), which builds a binary BVH bottom up [Meister and Bittner 2018]. Imports obvhs.
//!
//! `PlocBuilder` of obvhs builds the same BVH, but takes quadratic time for boxes in a row or nested boxes.

use std::ops::Range;

use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::ploc::morton::morton_encode_u64_unorm;
use rayon::prelude::*;

/// Number of nodes before and after a node, along a Morton curve, that it may be merged with.
const SEARCH_DISTANCE: usize = 14;
/// A pass that merges less than one node in `SLOW` is slow.
const SLOW: usize = 32;
/// Number of nodes a parallel task.
const CHUNK: usize = 1024;

/// Builds the binary BVH over boxes, one leaf each. Returns it with the number of passes, which is at least its levels minus one.
///
/// A pass merges pairs of mutual nearest nodes. In a row of boxes all nearest nodes may be on the same side. A slow pass
/// therefore also merges every node whose nearest is still unpaired. Each unpaired node is then near a merged one, and at least
/// one node in `2 * SEARCH_DISTANCE + 1` is merged.
pub fn build(boxes: &[Aabb]) -> (Bvh2, usize) {
    let mut nodes = leaves_in_morton_order(boxes);
    let mut free = (2 * boxes.len()).saturating_sub(1);
    let mut binary = Bvh2 { nodes: vec![Bvh2Node::default(); free], ..Bvh2::default() };
    let mut passes = 0;
    while nodes.len() > 1 {
        let partners = partners(&nearest(&nodes));
        let mut merged = Vec::with_capacity(nodes.len());
        for (index, partner) in partners.into_iter().enumerate() {
            match partner {
                // A merged pair takes the position of its later node.
                Some(partner) if partner < index => {
                    free -= 2;
                    binary.nodes[free] = nodes[index];
                    binary.nodes[free + 1] = nodes[partner];
                    let bounds = nodes[index].aabb().union(nodes[partner].aabb());
                    merged.push(Bvh2Node::new(bounds, 0, free as u32));
                }
                Some(_) => {}
                None => merged.push(nodes[index]),
            }
        }
        nodes = merged;
        passes += 1;
    }
    if let Some(&root) = nodes.first() {
        binary.nodes[0] = root;
    }
    binary.primitive_indices = (0..boxes.len() as u32).collect();
    binary.children_are_ordered_after_parents = true;
    (binary, passes)
}

/// One leaf for each box, sorted along a Morton curve through their centres.
fn leaves_in_morton_order(boxes: &[Aabb]) -> Vec<Bvh2Node> {
    let all = boxes.iter().fold(Aabb::empty(), |all, bounds| all.union(bounds));
    let scale = 1.0 / all.diagonal().as_dvec3();
    let offset: DVec3 = -all.min.as_dvec3() * scale;
    let code = |bounds: &Aabb| morton_encode_u64_unorm(bounds.center().as_dvec3() * scale + offset);
    let mut coded: Vec<(u64, usize)> =
        boxes.par_iter().enumerate().map(|(id, bounds)| (code(bounds), id)).collect();
    coded.par_sort_unstable_by_key(|&(code, _)| code);
    coded.into_par_iter().map(|(_, id)| Bvh2Node::new(boxes[id], 1, id as u32)).collect()
}

/// For each node, the node within [`SEARCH_DISTANCE`] whose union with it has the least area. Ties go to the last.
fn nearest(nodes: &[Bvh2Node]) -> Vec<usize> {
    let chunks = (0..nodes.len()).into_par_iter().step_by(CHUNK);
    chunks.flat_map_iter(|first| nearest_of_chunk(nodes, first..(first + CHUNK).min(nodes.len()))).collect()
}

fn nearest_of_chunk(nodes: &[Bvh2Node], chunk: Range<usize>) -> impl Iterator<Item = usize> {
    // Each pair is compared once, so the nodes near the chunk are needed too.
    let start = chunk.start.saturating_sub(SEARCH_DISTANCE);
    let nodes = &nodes[start..nodes.len().min(chunk.end + SEARCH_DISTANCE)];
    // Fallback where areas are NaN: the next node, or the one before the last.
    let mut best: Vec<(f32, usize)> = (1..nodes.len()).map(|next| (f32::INFINITY, next)).collect();
    best.push((f32::INFINITY, nodes.len() - 2));
    for index in 0..chunk.end - start {
        let end = nodes.len().min(index + SEARCH_DISTANCE + 1);
        let (before, after) = best.split_at_mut(index + 1);
        let mut own = before[index];
        for ((other, node), best) in (index + 1..end).zip(&nodes[index + 1..end]).zip(after) {
            let area = nodes[index].aabb().union(node.aabb()).half_area();
            if area <= own.0 {
                own = (area, other);
            }
            if area <= best.0 {
                *best = (area, index);
            }
        }
        before[index] = own;
    }
    best.into_iter().map(move |(_, nearest)| start + nearest).skip(chunk.start - start).take(chunk.len())
}

/// Returns each node's partner of this pass, if any.
fn partners(nearest: &[usize]) -> Vec<Option<usize>> {
    let is_mutual = |index: &usize| nearest[nearest[*index]] == *index;
    let mut partners: Vec<Option<usize>> =
        (0..nearest.len()).map(|index| is_mutual(&index).then_some(nearest[index])).collect();
    if partners.iter().flatten().count() < nearest.len() / SLOW {
        for (index, &nearest) in nearest.iter().enumerate() {
            if partners[index].is_none() && partners[nearest].is_none() {
                partners[index] = Some(nearest);
                partners[nearest] = Some(index);
            }
        }
    }
    partners
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;
    use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

    use super::super::bounds;
    use super::super::tests::soup;
    use super::*;

    fn built_by_obvhs(boxes: &[Aabb]) -> Bvh2 {
        let ids = (0..boxes.len() as u32).collect();
        PlocBuilder::new().build(PlocSearchDistance::Medium, boxes, ids, SortPrecision::U64, 0)
    }

    /// Boxes side by side, each `growth` times as wide as the one before.
    fn row(count: usize, growth: f32) -> Vec<Aabb> {
        let mut start = 0.0;
        let of_width = |width: f32| {
            let min = Vec3A::new(start, 0.0, 0.0);
            start += width;
            Aabb { min, max: Vec3A::new(start, 1.0, 0.0) }
        };
        (0..count).map(|index| growth.powi(index as i32)).map(of_width).collect()
    }

    /// Nested boxes: each contains all later ones.
    fn nested(count: usize) -> Vec<Aabb> {
        let of_size = |size: f32| Aabb { min: Vec3A::ZERO, max: Vec3A::new(size, size, 0.0) };
        (0..count).map(|index| 0.999_f32.powi(index as i32)).map(of_size).collect()
    }

    fn same_nodes(a: &Bvh2, b: &Bvh2) -> bool {
        let parts = |node: &Bvh2Node| (node.prim_count, node.first_index, *node.aabb());
        a.nodes.iter().map(parts).eq(b.nodes.iter().map(parts))
    }

    #[test]
    fn scattered_boxes_give_the_bvh_of_obvhs() {
        for (count, size) in [(1, 1.0), (2, 1.0), (30, 0.5), (1025, 0.1), (30_000, 0.01), (5000, 1.0)] {
            let boxes: Vec<Aabb> = soup(count, size).iter().map(bounds).collect();
            let (ours, passes) = build(&boxes);
            assert!(same_nodes(&ours, &built_by_obvhs(&boxes)), "{count} of {size}");
            assert!(passes <= 64, "{count} of {size}: {passes}");
        }
    }

    #[test]
    fn rows_and_nested_boxes_take_few_passes() {
        for (name, boxes) in [
            ("equal", row(4000, 1.0)),
            ("growing", row(4000, 1.001)),
            ("shrinking", row(4000, 0.999)),
            ("nested", nested(4000)),
        ] {
            let theirs = built_by_obvhs(&boxes);
            assert!(
                theirs.max_depth > 140,
                "{name}: clustering by mutual neighbours alone takes {}",
                theirs.max_depth
            );
            let (ours, passes) = build(&boxes);
            assert!(passes <= 96, "{name}: {passes}");
            ours.validate(&boxes, false, true);
        }
    }

    #[test]
    fn boxes_whose_areas_are_no_numbers_are_merged() {
        let huge = Aabb { min: Vec3A::splat(-3e38), max: Vec3A::new(3e38, 3e38, -3e38) };
        let (binary, _) = build(&[huge; 300]);
        let leaves = binary.nodes.iter().filter(|node| node.is_leaf()).count();
        assert_eq!((binary.nodes.len(), leaves), (599, 300));
    }
}
