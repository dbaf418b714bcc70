//! The top level of the BVH where there are instances: the world's triangles are one leaf, every instance another. Rebuilt for
//! every pose, of least depth.

use caustics_kernels::interface::bvh::BvhNode;
use obvhs::aabb::Aabb;

use super::plan::WIDTH;
use super::{LEVELS, empty_node, set_lane};

/// Instances at most: the levels that are left then hold BVHs of millions of triangles.
pub const MAX_INSTANCES: usize = (1 << 20) - 1;

/// A leaf: its box (m), and the child that a node refers to.
#[derive(Clone, Copy, Debug)]
pub struct Leaf {
    /// Box in the world (m).
    pub bounds: Aabb,
    /// Index of a node or an instance, with its flag.
    pub child: u32,
}

/// Nodes that this many leaves take at most.
pub fn node_count(leaves: usize) -> usize {
    leaves.max(1)
}

/// Levels that are left for the BVHs below this many leaves.
pub fn levels_below(leaves: usize) -> u32 {
    let (mut levels, mut capacity) = (1, WIDTH);
    while capacity < leaves {
        (levels, capacity) = (levels + 1, capacity * WIDTH);
    }
    LEVELS - levels
}

/// Fills the nodes at the head of a BVH; the first is the root, those that are not needed are empty.
pub fn build(nodes: &mut [BvhNode], mut leaves: Vec<Leaf>) {
    nodes.fill(empty_node());
    let mut used = 0;
    node(nodes, &mut used, &mut leaves);
}

/// Appends a node: halves along the longest axis, and halves of each along its own.
fn node(nodes: &mut [BvhNode], used: &mut usize, leaves: &mut [Leaf]) -> u32 {
    let id = *used;
    *used += 1;
    let mut lane = 0;
    for half in halves(leaves) {
        for part in halves(half) {
            let bounds = bounds(part);
            let child = if let [leaf] = part { leaf.child } else { node(nodes, used, part) };
            set_lane(&mut nodes[id], lane, &bounds, child);
            lane += 1;
        }
    }
    id as u32
}

/// Halves along the longest axis of the box around all; one of a leaf.
fn halves(leaves: &mut [Leaf]) -> impl Iterator<Item = &mut [Leaf]> {
    let size = bounds(leaves).diagonal();
    let axis = if size.x >= size.y.max(size.z) { 0 } else { 1 + usize::from(size.z > size.y) };
    leaves.sort_by(|a, b| {
        let centre = |leaf: &Leaf| leaf.bounds.center_axis(axis);
        centre(a).total_cmp(&centre(b)).then(a.child.cmp(&b.child))
    });
    leaves.chunks_mut(leaves.len().div_ceil(2).max(1))
}

fn bounds(leaves: &[Leaf]) -> Aabb {
    leaves.iter().fold(Aabb::empty(), |all, leaf| all.union(&leaf.bounds))
}
