//! A BVH over the points, in software: points in Morton order, eight points to a leaf and eight boxes to a node. The number of
//! points implies its whole layout. Each photon descends into the boxes that hold it.
//!
//! Source: the index of [Moreau and Doggett 2022], built as a linear bounding volume hierarchy [Lauterbach et al. 2009, Fast BVH
//! construction on GPUs].
//!
//! Cost: a sort of the points and a pass over the nodes of each level, once a frame. A photon tests eight boxes a level, and
//! about eight points of each leaf that it is in.
//!
//! Limitations: slow where points of very different radii are close together: a large disc enlarges the boxes of its small
//! neighbours. The result is exact for every radius.

use crate::gather::contribution::disc_half_extent;
use crate::gather::morton_sort::{self, TOTAL};
use crate::gather::tables::{Build, Tables};
use crate::gather::variant::{Over, Side, Stage, Variant, WordCount};
use crate::gather::{Gather, Index, Near, Visit};
use crate::platform::Words as _;
use spirv_std::glam::Vec3;

/// Gather with a software BVH over the points.
pub struct PointsBvh;

/// Number of children of a node, and of points of a leaf.
const WIDTH: u32 = 8;

impl Index for PointsBvh {
    const VARIANT: Variant = Variant {
        name: "points-bvh",
        description: "the paper's index in software: a BVH over the points, searched from each photon",
        cost: "a sort of the points and a pass over each level, once a frame; eight boxes a level a photon",
        limitations: "slow where radii differ much at one position",
        side: Side::Points,
        frame: &[
            Stage::Clear(0),
            Stage::Run(morton_sort::BOUNDS, "bounds", Over::Pixels),
            Stage::Run(morton_sort::COUNT, "count", Over::Pixels),
            Stage::Run(morton_sort::SUM, "sum", Over::PixelSort(1)),
            Stage::Run(morton_sort::SUM_OF_SUMS, "sum", Over::PixelSort(2)),
            Stage::Run(morton_sort::SCAN, "sum", Over::Count(1)),
            Stage::Run(morton_sort::SPREAD, "sum", Over::PixelSort(2)),
            Stage::Run(morton_sort::SPREAD_AGAIN, "sum", Over::PixelSort(1)),
            Stage::Run(morton_sort::FILL, "fill", Over::Pixels),
            Stage::Run(0, "leaves", Over::PixelsIn(8)),
            Stage::Run(1, "nodes", Over::PixelsIn(64)),
            Stage::Run(2, "nodes", Over::PixelsIn(512)),
            Stage::Run(3, "nodes", Over::PixelsIn(4096)),
            Stage::Run(4, "nodes", Over::PixelsIn(1 << 15)),
            Stage::Run(5, "nodes", Over::PixelsIn(1 << 18)),
            Stage::Run(6, "nodes", Over::PixelsIn(1 << 21)),
            Stage::Run(7, "nodes", Over::PixelsIn(1 << 24)),
            Stage::Run(8, "nodes", Over::PixelsIn(1 << 27)),
        ],
        words: [
            WordCount(1, Over::PixelSort(3)),
            WordCount(1, Over::Pixels),
            // A seventh of the pixels, and what each level rounds up.
            WordCount(6, Over::PixelsIn(4)),
            WordCount::NONE,
        ],
        ..Variant::NEW
    };

    #[inline(always)]
    fn build(stage: u32, index: u32, build: &mut Build<'_>) {
        let capacity = build.params.pixel_count();
        if stage == morton_sort::BOUNDS || stage == morton_sort::COUNT || stage == morton_sort::FILL {
            let point = build.point(index);
            if point.exists() {
                let slot = morton_sort::element(stage, point.position, capacity, &mut build.index_0);
                if stage == morton_sort::FILL {
                    build.index_1.set(slot, index);
                }
            }
        } else if stage > morton_sort::BOUNDS {
            morton_sort::counts(stage, index, capacity, &mut build.index_0);
        } else {
            node(stage, index, build);
        }
    }
}

/// Number of nodes of a level; level 0 holds the leaves.
#[inline(always)]
fn nodes_in(level: u32, capacity: u32) -> u32 {
    let shift = 3 * (level + 1);
    ((capacity - 1) >> shift) + 1
}

/// Index of the first node of a level.
#[inline(always)]
fn first_node(level: u32, capacity: u32) -> u32 {
    let mut first = 0;
    let mut below = 0;
    while below < level {
        first += nodes_in(below, capacity);
        below += 1;
    }
    first
}

/// Level of the root, the only node of its level.
#[inline(always)]
fn top_level(capacity: u32) -> u32 {
    let mut level = 0;
    while nodes_in(level, capacity) > 1 {
        level += 1;
    }
    level
}

/// Writes the box of a node: around its points, or around the boxes of the level below.
#[inline(always)]
fn node(level: u32, index: u32, build: &mut Build<'_>) {
    let capacity = build.params.pixel_count();
    if level > top_level(capacity) || index >= nodes_in(level, capacity) {
        return;
    }
    let mut low = Vec3::splat(f32::MAX);
    let mut high = Vec3::splat(-f32::MAX);
    let first = index * WIDTH;
    let mut child = first;
    if level == 0 {
        let end = (first + WIDTH).min(build.index_0.get(TOTAL));
        while child < end {
            let point = build.point(build.index_1.get(child));
            let half = disc_half_extent(&point);
            low = low.min(point.position - half);
            high = high.max(point.position + half);
            child += 1;
        }
    } else {
        let below = first_node(level - 1, capacity);
        let end = (first + WIDTH).min(nodes_in(level - 1, capacity));
        while child < end {
            let word = 6 * (below + child);
            low = low.min(corner(&build.index_2, word));
            high = high.max(corner(&build.index_2, word + 3));
            child += 1;
        }
    }
    let word = 6 * (first_node(level, capacity) + index);
    build.index_2.set(word, low.x.to_bits());
    build.index_2.set(word + 1, low.y.to_bits());
    build.index_2.set(word + 2, low.z.to_bits());
    build.index_2.set(word + 3, high.x.to_bits());
    build.index_2.set(word + 4, high.y.to_bits());
    build.index_2.set(word + 5, high.z.to_bits());
}

#[inline(always)]
fn corner<W: crate::platform::Words>(words: &W, word: u32) -> Vec3 {
    let number = |word| f32::from_bits(words.get(word));
    Vec3::new(number(word), number(word + 1), number(word + 2))
}

impl Gather for PointsBvh {
    #[inline(always)]
    fn for_each_near<V: Visit>(tables: &mut Tables<'_>, near: Near, visit: &mut V) {
        let capacity = tables.params.pixel_count();
        let (low, high) = (near.position - near.half_extent, near.position + near.half_extent);
        let total = tables.index_0[TOTAL as usize];
        let top = top_level(capacity);
        let (mut level, mut index) = (top, 0);
        let mut start = first_node(top, capacity);
        loop {
            let word = (6 * (start + index)) as usize;
            let number = |offset: usize| f32::from_bits(tables.index_2[word + offset]);
            let outside = number(0) > high.x
                || number(1) > high.y
                || number(2) > high.z
                || number(3) < low.x
                || number(4) < low.y
                || number(5) < low.z;
            // Descend into the first child of a node that the box meets
            if !outside && level > 0 {
                level -= 1;
                start -= nodes_in(level, capacity);
                index *= WIDTH;
                continue;
            }
            // Visit the points of a leaf
            if !outside {
                let mut id = index * WIDTH;
                let end = (id + WIDTH).min(total);
                while id < end {
                    visit.visit(tables, tables.index_1[id as usize]);
                    id += 1;
                }
            }
            index += 1;
            // Go on to the next node; behind the last child, climb to the parent's neighbour.
            while level < top && (index % WIDTH == 0 || index >= nodes_in(level, capacity)) {
                index = (index - 1) / WIDTH + 1;
                start += nodes_in(level, capacity);
                level += 1;
            }
            if level == top {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_fit_their_words() {
        for capacity in (1..5000).chain([2_073_600, 1917 * 1079, 1 << 24, (1 << 24) + 1, 1 << 27]) {
            let top = top_level(capacity);
            let last = PointsBvh::VARIANT.frame.last();
            assert!(matches!(last, Some(Stage::Run(last_level, ..)) if top <= *last_level));
            assert!(first_node(top + 1, capacity) <= capacity.div_ceil(4), "{capacity}");
        }
    }
}
