//! Which boxes of a binary tree become lanes of a four-wide one: the cheapest choice by surface area, found bottom up.
//!
//! Dynamic programme of [Ylitie et al. 2017, section 4.1] with a cost of one area for a node as for a block of triangles.
//! Imports obvhs.

use obvhs::bvh2::Bvh2;

/// Lanes of a node, and triangles of a block.
pub const WIDTH: usize = 4;

/// Levels of nodes that this many triangles need at least.
pub fn least_levels(count: usize) -> u32 {
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
pub struct Entry {
    /// Triangles below.
    pub count: u32,
    /// Levels of four-wide nodes below, for each number of lanes.
    height: [u32; WIDTH],
    /// Expected cost in units of half areas (m^2).
    cost: [f32; WIDTH],
    /// Lanes that go to the left child; 0: take one lane less.
    split: [u8; WIDTH],
    /// Lanes that go to the left child when this box is a node of its own.
    own_split: u8,
}

/// The plan of every binary node.
pub struct Plan<'a> {
    tree: &'a Bvh2,
    groups: &'a [Vec<u32>],
    entries: Vec<Entry>,
}

impl<'a> Plan<'a> {
    /// Plans a binary tree with one group of triangles a leaf.
    pub fn new(tree: &'a Bvh2, groups: &'a [Vec<u32>]) -> Self {
        let mut plan = Plan { tree, groups, entries: vec![Entry::default(); tree.nodes.len()] };

        // Visit children before their parents, without recursion: a binary tree may be as deep as it has leaves.
        let mut order = vec![0];
        let mut visited = 0;
        while visited < order.len() {
            let node = &tree.nodes[order[visited]];
            visited += 1;
            if !node.is_leaf() {
                order.extend([node.first_index as usize, node.first_index as usize + 1]);
            }
        }
        for &node in order.iter().rev() {
            plan.entries[node] = plan.entry(node);
        }
        plan
    }

    fn entry(&self, node: usize) -> Entry {
        let area = self.tree.nodes[node].aabb().half_area().min(1e30);
        let Some([left, right]) = self.children(node) else {
            let count = self.group(node).len();
            let cost = area * count.div_ceil(WIDTH) as f32;
            let height = least_levels(count);
            return Entry {
                count: count as u32,
                height: [height; WIDTH],
                cost: [cost; WIDTH],
                ..Entry::default()
            };
        };
        let (left, right) = (&self.entries[left], &self.entries[right]);
        let mut entry = Entry { count: left.count + right.count, ..Entry::default() };

        // Spread lanes over both children as cheaply as possible.
        let spread = |lanes: usize| {
            let cost = |to_left: usize| left.cost[to_left - 1] + right.cost[lanes - to_left - 1];
            let best = (1..lanes).fold(1, |best, next| if cost(next) < cost(best) { next } else { best });
            (cost(best), left.height[best - 1].max(right.height[lanes - best - 1]), best as u8)
        };

        // A box of up to four triangles is a block, which costs no more than a node; else it is a node of four lanes.
        let (own_cost, own_height, own_split) = spread(WIDTH);
        let is_block = entry.count as usize <= WIDTH;
        entry.own_split = own_split;
        entry.cost[0] = if is_block { area } else { area + own_cost };
        entry.height[0] = if is_block { 0 } else { 1 + own_height };
        for lanes in 2..=WIDTH {
            let fewer = (entry.cost[lanes - 2], entry.height[lanes - 2], 0);
            let (cost, height, split) = spread(lanes);
            let best = if cost < fewer.0 { (cost, height, split) } else { fewer };
            (entry.cost[lanes - 1], entry.height[lanes - 1], entry.split[lanes - 1]) = best;
        }
        entry
    }

    /// Triangles of a binary leaf: all that share its box.
    fn group(&self, leaf: usize) -> &[u32] {
        &self.groups[self.tree.primitive_indices[self.tree.nodes[leaf].first_index as usize] as usize]
    }

    /// Whether the binary node has no children.
    pub fn is_leaf(&self, node: usize) -> bool {
        self.tree.nodes[node].is_leaf()
    }

    fn children(&self, node: usize) -> Option<[usize; 2]> {
        let node = &self.tree.nodes[node];
        (!node.is_leaf()).then(|| [node.first_index as usize, node.first_index as usize + 1])
    }

    /// Triangles below a binary node.
    pub fn count(&self, node: usize) -> usize {
        self.entries[node].count as usize
    }

    /// Levels of four-wide nodes from this box down, when it is one lane.
    pub fn height(&self, node: usize) -> u32 {
        self.entries[node].height[0]
    }

    /// The binary nodes that are the lanes of this box, when it is a node.
    pub fn lanes(&self, node: usize) -> Vec<usize> {
        let mut lanes = Vec::with_capacity(WIDTH);
        match self.children(node) {
            Some([left, right]) if self.count(node) > WIDTH => {
                let to_left = self.entries[node].own_split as usize;
                self.spread(left, to_left, &mut lanes);
                self.spread(right, WIDTH - to_left, &mut lanes);
            }
            _ => self.spread(node, WIDTH, &mut lanes),
        }
        lanes
    }

    fn spread(&self, node: usize, lanes: usize, out: &mut Vec<usize>) {
        let to_left = self.entries[node].split[lanes - 1] as usize;
        match (lanes, to_left, self.children(node)) {
            (2.., 1.., Some([left, right])) => {
                self.spread(left, to_left, out);
                self.spread(right, lanes - to_left, out);
            }
            (2.., 0, Some(_)) => self.spread(node, lanes - 1, out),
            _ => out.push(node),
        }
    }

    /// Ids of the triangles below a binary node, left to right.
    pub fn triangles(&self, node: usize) -> Vec<u32> {
        let mut found = Vec::with_capacity(self.count(node));
        let mut stack = vec![node];
        while let Some(node) = stack.pop() {
            match self.children(node) {
                Some([left, right]) => stack.extend([right, left]),
                None => found.extend(self.group(node)),
            }
        }
        found
    }
}
