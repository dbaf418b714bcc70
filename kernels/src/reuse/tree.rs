//! A tree over the collection points of the frame before. Points stand in Morton order of their pixels, so that the tree's
//! shape is given: sixteen points a leaf, four children a node, and only boxes are computed, level by level.
//!
//! Cost: 24 bytes of box for 16 points and a third more above them; a search that starts at a pixel's own leaf mostly ends
//! there. Exact for any radii.

use crate::gather::Visit;
use crate::interface::history::HistoryPoint;
use crate::interface::point::PointBox;
use spirv_std::glam::Vec3;

/// Points of a leaf.
pub const LEAF_POINTS: u32 = 16;
/// Children of a node.
const CHILDREN: u32 = 4;
/// Levels at most: 2^26 points.
const MOST_LEVELS: usize = 12;
/// Entries of the traversal stack: each level leaves at most three nodes behind.
const STACK: usize = 3 * MOST_LEVELS + 1;

/// Nodes of a level; level 0 holds the leaves.
#[inline]
pub fn level_nodes(points: u32, level: u32) -> u32 {
    let mut nodes = points.div_ceil(LEAF_POINTS);
    let mut at = 0;
    while at < level {
        nodes = nodes.div_ceil(CHILDREN);
        at += 1;
    }
    nodes
}

/// First node of a level; the nodes of all levels lie one after the other.
#[inline]
pub fn level_start(points: u32, level: u32) -> u32 {
    let (mut start, mut at) = (0, 0);
    while at < level {
        start += level_nodes(points, at);
        at += 1;
    }
    start
}

/// Levels of the tree; the last one is the root alone.
#[inline]
pub fn levels(points: u32) -> u32 {
    let mut levels = 1;
    while level_nodes(points, levels - 1) > 1 {
        levels += 1;
    }
    levels
}

/// A box that nothing is inside of.
const EMPTY: PointBox = PointBox { min: Vec3::splat(f32::MAX), max: Vec3::splat(f32::MIN) };

/// The box of a node of level `level`: all places within reach of its points. `below` holds the boxes of lower levels.
#[inline(always)]
pub fn node_box(
    node: u32,
    level: u32,
    points: u32,
    reach: f32,
    history: &[HistoryPoint],
    below: &[PointBox],
) -> PointBox {
    let mut all = EMPTY;
    if level == 0 {
        let mut rank = node * LEAF_POINTS;
        let end = (rank + LEAF_POINTS).min(points);
        while rank < end {
            let point = history[rank as usize];
            if point.samples > 0.0 {
                let half = Vec3::splat(point.radius * reach);
                all.min = all.min.min(point.position - half);
                all.max = all.max.max(point.position + half);
            }
            rank += 1;
        }
        return all;
    }
    let start = level_start(points, level - 1);
    let mut child = node * CHILDREN;
    let end = (child + CHILDREN).min(level_nodes(points, level - 1));
    while child < end {
        let one = below[(start + child) as usize];
        all.min = all.min.min(one.min);
        all.max = all.max.max(one.max);
        child += 1;
    }
    all
}

/// The tree, for searching.
#[derive(Clone, Copy)]
pub struct PointTree<'a> {
    boxes: &'a [PointBox],
    points: u32,
    levels: u32,
    /// First node of each level.
    starts: [u32; MOST_LEVELS + 1],
}

impl<'a> PointTree<'a> {
    /// The tree over this many points with the boxes of all levels.
    #[inline(always)]
    pub fn new(boxes: &'a [PointBox], points: u32) -> Self {
        let mut starts = [0; MOST_LEVELS + 1];
        let mut nodes = level_nodes(points, 0);
        let mut levels = 1;
        starts[1] = nodes;
        while nodes > 1 {
            nodes = nodes.div_ceil(CHILDREN);
            starts[levels + 1] = starts[levels] + nodes;
            levels += 1;
        }
        PointTree { boxes, points, levels: levels as u32, starts }
    }

    /// One past the last node of a level.
    #[inline(always)]
    fn nodes(&self, level: u32) -> u32 {
        self.starts[level as usize + 1] - self.starts[level as usize]
    }

    /// Visits every point whose reach may hold a position.
    #[inline(always)]
    pub fn for_each<V: Visit>(&self, position: Vec3, visit: &mut V) {
        let root = self.levels - 1;
        if self.holds(root, 0, position) {
            self.descend(root, 0, position, visit);
        }
    }

    /// Visits the points of the leaf of `rank`, then outwards from it, subtree by subtree, until `done` is content.
    #[inline(always)]
    pub fn outwards<V: Visit>(&self, rank: u32, position: Vec3, visit: &mut V, done: impl Fn(&V) -> bool) {
        let mut node = rank / LEAF_POINTS;
        self.leaf(node, visit);
        let mut level = 0;
        while level + 1 < self.levels && !done(visit) {
            let first = node / CHILDREN * CHILDREN;
            let end = (first + CHILDREN).min(self.nodes(level));
            let mut sibling = first;
            while sibling < end {
                if sibling != node && self.holds(level, sibling, position) {
                    self.descend(level, sibling, position, visit);
                }
                sibling += 1;
            }
            node /= CHILDREN;
            level += 1;
        }
    }

    /// Whether the box of a node holds a position.
    #[inline(always)]
    fn holds(&self, level: u32, node: u32, position: Vec3) -> bool {
        let bounds = self.boxes[(self.starts[level as usize] + node) as usize];
        let outside = (bounds.min - position).max(position - bounds.max);
        outside.max_element() <= 0.0
    }

    #[inline(always)]
    fn leaf<V: Visit>(&self, node: u32, visit: &mut V) {
        let mut rank = node * LEAF_POINTS;
        let end = (rank + LEAF_POINTS).min(self.points);
        while rank < end {
            visit.visit(rank);
            rank += 1;
        }
    }

    /// Visits the points below a node whose box holds the position.
    #[inline(always)]
    fn descend<V: Visit>(&self, level: u32, node: u32, position: Vec3, visit: &mut V) {
        let mut stack_level = [0u32; STACK];
        let mut stack_node = [0u32; STACK];
        stack_level[0] = level;
        stack_node[0] = node;
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (level, node) = (stack_level[height], stack_node[height]);
            if level == 0 {
                self.leaf(node, visit);
                continue;
            }
            let mut child = node * CHILDREN;
            let end = (child + CHILDREN).min(self.nodes(level - 1));
            while child < end {
                if height < STACK && self.holds(level - 1, child, position) {
                    stack_level[height] = level - 1;
                    stack_node[height] = child;
                    height += 1;
                }
                child += 1;
            }
        }
    }
}
