//! Top level of the BVH of a scene with instances: one leaf for the world's triangles, and one for each instance. It is rebuilt
//! for every pose, with minimum depth.

use caustics_kernels::interface::bvh::BvhNode;
use obvhs::aabb::Aabb;

use super::plan::WIDTH;
use super::{LEVELS, empty_node, set_lane};

/// Maximum number of instances: the levels below then hold BVHs of millions of triangles.
pub const MAX_INSTANCES: usize = (1 << 20) - 1;

/// A leaf: its box, and the child that a node refers to.
#[derive(Clone, Copy, Debug)]
pub struct Leaf {
    /// Box in the world (m).
    pub bounds: Aabb,
    /// Index of a node or of an instance, with its flag.
    pub child: u32,
}

/// Maximum number of nodes for this number of leaves.
pub fn node_count(leaves: usize) -> usize {
    leaves.max(1)
}

/// Number of levels that are left for the BVHs below this number of leaves.
pub fn levels_below(leaves: usize) -> u32 {
    let (mut levels, mut capacity) = (1, WIDTH);
    while capacity < leaves {
        (levels, capacity) = (levels + 1, capacity * WIDTH);
    }
    LEVELS - levels
}

/// Fills the first nodes of a BVH; the first is the root, and unused nodes are empty.
pub fn build(nodes: &mut [BvhNode], mut leaves: Vec<Leaf>) {
    nodes.fill(empty_node());
    let mut used = 0;
    node(nodes, &mut used, &mut leaves);
}

/// Appends a node of up to four lanes: splits along the longest axis, then each half along its own.
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

/// Splits leaves in half along the longest axis of their box; a single leaf stays whole.
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
