//! Plan of the lanes of a four-wide BVH: the boxes of a binary BVH with the least surface area cost, found bottom up.
//!
//! Dynamic programme of [Ylitie et al. 2017, section 4.1]. A node and a block of triangles each cost their area. Imports obvhs.

use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use rayon::prelude::*;

use super::groups::Groups;

/// Number of lanes of a node, and of triangles of a block.
pub const WIDTH: usize = 4;
/// Minimum number of nodes of a level in a parallel task.
const LEVEL_PART: usize = 1024;

/// Minimum number of levels of nodes for this number of triangles.
pub fn min_levels(count: usize) -> u32 {
    let mut levels = 0;
    let mut capacity = WIDTH;
    while capacity < count {
        capacity *= WIDTH;
        levels += 1;
    }
    levels
}

/// The plan of one binary node. Arrays are indexed by the lanes it may take, minus one.
#[derive(Clone, Copy, Default)]
struct Entry {
    /// Number of triangles below.
    count: u32,
    /// Expected cost in units of half areas (m^2).
    cost: [f32; WIDTH],
    /// Levels of four-wide nodes below, by number of lanes; 255 stands for 255 or more.
    height: [u8; WIDTH],
    /// Number of lanes of the left child; 0: use one lane less.
    split: [u8; WIDTH],
    /// Number of lanes of the left child when this box is a node of its own.
    own_split: u8,
}

/// The plan of every binary node, by index. Levels follow each other from the root at index 0 down.
pub struct CollapsePlan<'a> {
    binary: &'a Bvh2,
    groups: &'a Groups,
    /// Binary node at each index.
    nodes: Vec<u32>,
    /// Index of the left child; the right child follows it. 0 for a leaf.
    children: Vec<u32>,
    entries: Vec<Entry>,
}

impl<'a> CollapsePlan<'a> {
    /// Plans a binary BVH with one group of triangles in each leaf.
    pub fn new(binary: &'a Bvh2, groups: &'a Groups) -> Self {
        let (mut nodes, mut children) =
            (Vec::with_capacity(binary.nodes.len()), Vec::with_capacity(binary.nodes.len()));
        nodes.push(0);
        let mut levels = vec![0];
        while children.len() < nodes.len() {
            levels.push(nodes.len());
            for at in children.len()..nodes.len() {
                let node = &binary.nodes[nodes[at] as usize];
                children.push(if node.is_leaf() { 0 } else { nodes.len() as u32 });
                if !node.is_leaf() {
                    nodes.extend([node.first_index, node.first_index + 1]);
                }
            }
        }
        let mut plan = CollapsePlan { binary, groups, nodes, children, entries: vec![] };

        // Plan level by level, from the lowest up.
        let mut entries = vec![Entry::default(); plan.nodes.len()];
        for level in levels.windows(2).rev() {
            let (done, below) = entries.split_at_mut(level[1]);
            let level_entries = done[level[0]..].par_iter_mut().with_min_len(LEVEL_PART).enumerate();
            level_entries.for_each(|(at, entry)| {
                let at = level[0] + at;
                let children = plan.children(at).map(|ids| ids.map(|id| &below[id - level[1]]));
                *entry = plan.entry(at, children);
            });
        }
        plan.entries = entries;
        plan
    }

    fn entry(&self, at: usize, children: Option<[&Entry; 2]>) -> Entry {
        let area = self.bounds(at).half_area().min(1e30);
        let Some([left, right]) = children else {
            let count = self.group(at).len();
            let cost = area * count.div_ceil(WIDTH) as f32;
            let height = min_levels(count) as u8;
            return Entry {
                count: count as u32,
                height: [height; WIDTH],
                cost: [cost; WIDTH],
                ..Entry::default()
            };
        };
        let mut entry = Entry { count: left.count + right.count, ..Entry::default() };

        // Distribute lanes between both children at the least cost.
        let spread = |lanes: usize| {
            let cost = |to_left: usize| left.cost[to_left - 1] + right.cost[lanes - to_left - 1];
            let best = (1..lanes).fold(1, |best, next| if cost(next) < cost(best) { next } else { best });
            (cost(best), left.height[best - 1].max(right.height[lanes - best - 1]), best as u8)
        };

        // A box of up to four triangles becomes a block, which costs no more than a node. Other boxes become a node of four
        // lanes.
        let (own_cost, own_height, own_split) = spread(WIDTH);
        let is_block = entry.count as usize <= WIDTH;
        entry.own_split = own_split;
        entry.cost[0] = if is_block { area } else { area + own_cost };
        entry.height[0] = if is_block { 0 } else { own_height.saturating_add(1) };
        for lanes in 2..=WIDTH {
            let fewer = (entry.cost[lanes - 2], entry.height[lanes - 2], 0);
            let (cost, height, split) = spread(lanes);
            let best = if cost < fewer.0 { (cost, height, split) } else { fewer };
            (entry.cost[lanes - 1], entry.height[lanes - 1], entry.split[lanes - 1]) = best;
        }
        entry
    }

    fn node(&self, at: usize) -> &Bvh2Node {
        &self.binary.nodes[self.nodes[at] as usize]
    }

    /// The box of a binary node.
    pub fn bounds(&self, at: usize) -> &Aabb {
        self.node(at).aabb()
    }

    /// Triangles of a binary leaf, which share its box.
    fn group(&self, leaf: usize) -> &[u32] {
        self.groups.get(self.binary.primitive_indices[self.node(leaf).first_index as usize] as usize)
    }

    /// Whether the binary node has no children.
    pub fn is_leaf(&self, at: usize) -> bool {
        self.children[at] == 0
    }

    fn children(&self, at: usize) -> Option<[usize; 2]> {
        let left = self.children[at] as usize;
        (left != 0).then_some([left, left + 1])
    }

    /// Number of triangles below a binary node.
    pub fn count(&self, at: usize) -> usize {
        self.entries[at].count as usize
    }

    /// Levels of four-wide nodes below this box as one lane; 255 stands for 255 or more.
    pub fn height(&self, at: usize) -> u32 {
        self.entries[at].height[0].into()
    }

    /// Returns the binary nodes that become the lanes of this box as a node.
    pub fn lanes(&self, at: usize) -> Vec<usize> {
        let mut lanes = Vec::with_capacity(WIDTH);
        match self.children(at) {
            Some([left, right]) if self.count(at) > WIDTH => {
                let to_left = self.entries[at].own_split as usize;
                self.spread(left, to_left, &mut lanes);
                self.spread(right, WIDTH - to_left, &mut lanes);
            }
            _ => self.spread(at, WIDTH, &mut lanes),
        }
        lanes
    }

    fn spread(&self, at: usize, lanes: usize, out: &mut Vec<usize>) {
        let to_left = self.entries[at].split[lanes - 1] as usize;
        match (lanes, to_left, self.children(at)) {
            (2.., 1.., Some([left, right])) => {
                self.spread(left, to_left, out);
                self.spread(right, lanes - to_left, out);
            }
            (2.., 0, Some(_)) => self.spread(at, lanes - 1, out),
            _ => out.push(at),
        }
    }

    /// Appends the ids of the triangles below a binary node, left to right.
    pub fn triangles(&self, at: usize, found: &mut Vec<u32>) {
        let (mut at, mut right) = (at, Vec::new());
        loop {
            match self.children(at) {
                Some([left, other]) => {
                    right.push(other);
                    at = left;
                }
                None => {
                    found.extend(self.group(at));
                    let Some(next) = right.pop() else { break };
                    at = next;
                }
            }
        }
    }
}
