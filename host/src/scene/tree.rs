//! Builds the four-wide tree of `interface::tree` over triangles. Imports obvhs, interface.

use std::collections::HashMap;
use std::ops::Range;

use caustics_kernels::interface::tree::{LEAF, TREE_STACK, TreeNode, TriangleBlock};
use caustics_kernels::interface::triangle::Triangle;
use glam::{Vec3, Vec3A, Vec4};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use self::plan::{Plan, WIDTH, least_levels};

mod plan;
#[cfg(test)]
mod tests;
pub mod top;

/// Levels of nodes that the traversal's stack has room for: each pushes at most three of its four lanes.
pub const LEVELS: u32 = (TREE_STACK / (WIDTH - 1)) as u32;

/// Share of the binary nodes that are tried elsewhere, the largest first, to lower the tree's cost.
const REINSERTED_SHARE: f32 = 0.5;

/// A four-wide tree and the order that it puts triangles in.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// Nodes; the first is the root.
    pub nodes: Vec<TreeNode>,
    /// Leaves, in the order of their triangles.
    pub blocks: Vec<TriangleBlock>,
    /// Where each triangle stood before: new id to old id.
    pub order: Vec<u32>,
}

/// Builds the tree over at least one finite triangle. The same triangles give the same bits.
#[cfg(test)]
pub fn build(triangles: &[Triangle]) -> Tree {
    build_within(triangles, LEVELS)
}

/// Builds the tree over at least one finite triangle, with at most so many levels of nodes where that many hold the
/// triangles. The same triangles give the same bits.
pub fn build_within(triangles: &[Triangle], levels: u32) -> Tree {
    let boxes: Vec<Aabb> = triangles.iter().map(bounds).collect();
    let groups = group(&boxes);
    let binary = build_binary(&boxes, &groups);
    let plan = Plan::new(&binary, &groups);
    let mut builder =
        Builder { triangles, boxes: &boxes, binary: &binary, plan: &plan, tree: Tree::default() };
    builder.node(0, levels);
    builder.tree
}

pub fn bounds(triangle: &Triangle) -> Aabb {
    Aabb::from_points(&[triangle.a, triangle.b, triangle.c].map(Vec3A::from))
}

/// Whether a tree of so many levels of nodes holds this many triangles.
pub fn fits(count: usize, levels: u32) -> bool {
    least_levels(count) <= levels
}

/// Gathers triangles that share a box: clustering them one by one would take quadratic time.
fn group(boxes: &[Aabb]) -> Vec<Vec<u32>> {
    let mut groups: Vec<Vec<u32>> = Vec::with_capacity(boxes.len());
    let mut known = HashMap::with_capacity(boxes.len());
    for (id, bounds) in boxes.iter().enumerate() {
        let key = [bounds.min, bounds.max].map(|corner| corner.to_array().map(f32::to_bits));
        let group = *known.entry(key).or_insert(groups.len());
        if group == groups.len() {
            groups.push(Vec::with_capacity(1));
        }
        groups[group].push(id as u32);
    }
    groups
}

/// Clusters bottom up, then moves nodes to where they cost less [Meister and Bittner 2018]. Sequential, thus repeatable.
fn build_binary(boxes: &[Aabb], groups: &[Vec<u32>]) -> Bvh2 {
    let boxes: Vec<Aabb> = groups.iter().map(|ids| boxes[ids[0] as usize]).collect();
    let ids = (0..boxes.len() as u32).collect();
    let mut binary = PlocBuilder::new().build(PlocSearchDistance::Medium, &boxes, ids, SortPrecision::U64, 0);
    // The optimiser's stack has room for usual depths only; a pathological tree is balanced below instead.
    if binary.max_depth <= obvhs::bvh2::DEFAULT_MAX_STACK_DEPTH {
        ReinsertionOptimizer::default().run(&mut binary, REINSERTED_SHARE, None);
    }
    binary
}

struct Builder<'a> {
    triangles: &'a [Triangle],
    boxes: &'a [Aabb],
    binary: &'a Bvh2,
    plan: &'a Plan<'a>,
    tree: Tree,
}

impl Builder<'_> {
    /// Appends a node for a binary node, at most `levels` levels deep.
    fn node(&mut self, binary: usize, levels: u32) -> u32 {
        let id = self.reserve();
        for (lane, child) in self.plan.lanes(binary).into_iter().enumerate() {
            let reference = self.lane(child, levels - 1);
            set_lane(&mut self.tree.nodes[id], lane, self.binary.nodes[child].aabb(), reference);
        }
        id as u32
    }

    /// Appends what stands below a lane; balances it when the planned shape would be too deep.
    fn lane(&mut self, binary: usize, levels: u32) -> u32 {
        if self.plan.count(binary) <= WIDTH {
            return self.block(&self.plan.triangles(binary));
        }
        let fits = |child: usize| least_levels(self.plan.count(child)) < levels;
        let is_leaf = self.plan.is_leaf(binary);
        if !is_leaf && (self.plan.height(binary) <= levels || self.plan.lanes(binary).into_iter().all(fits)) {
            return self.node(binary, levels);
        }
        let mut ids = self.plan.triangles(binary);
        self.balanced(&mut ids)
    }

    /// Appends a tree of least depth: quarters along the longest axis.
    fn balanced(&mut self, ids: &mut [u32]) -> u32 {
        if ids.len() <= WIDTH {
            return self.block(ids);
        }
        let id = self.reserve();
        let size = self.bounds(ids).diagonal();
        let axis = if size.x >= size.y.max(size.z) { 0 } else { 1 + usize::from(size.z > size.y) };
        ids.sort_by(|&a, &b| {
            let centre = |id: u32| self.boxes[id as usize].center_axis(axis);
            centre(a).total_cmp(&centre(b)).then(a.cmp(&b))
        });
        for (lane, quarter) in ids.chunks_mut(ids.len().div_ceil(WIDTH)).enumerate() {
            let bounds = self.bounds(quarter);
            let reference = self.balanced(quarter);
            set_lane(&mut self.tree.nodes[id], lane, &bounds, reference);
        }
        id as u32
    }

    fn bounds(&self, ids: &[u32]) -> Aabb {
        ids.iter().fold(Aabb::empty(), |all, &id| all.union(&self.boxes[id as usize]))
    }

    /// Appends a node of four empty lanes.
    fn reserve(&mut self) -> usize {
        self.tree.nodes.push(empty_node());
        self.tree.nodes.len() - 1
    }

    /// Appends a leaf of one to four triangles and gives them the next ids.
    fn block(&mut self, ids: &[u32]) -> u32 {
        let first = self.tree.order.len() as u32;
        self.tree.order.extend(ids);
        let mut block = TriangleBlock { first, count: ids.len() as u32, ..TriangleBlock::default() };
        fill(&mut block, |lane| ids.get(lane).map(|&id| self.triangles[id as usize]));
        self.tree.blocks.push(block);
        LEAF | (self.tree.blocks.len() - 1) as u32
    }
}

impl Tree {
    /// Appends nodes and blocks to those of other trees: children refer to where they are then.
    pub fn append_to(mut self, nodes: &mut Vec<TreeNode>, blocks: &mut Vec<TriangleBlock>) {
        let (node, block) = (nodes.len() as u32, blocks.len() as u32);
        for lane in self.nodes.iter_mut().flat_map(|node| &mut node.children) {
            *lane += if *lane & LEAF != 0 { block } else { node };
        }
        nodes.append(&mut self.nodes);
        blocks.append(&mut self.blocks);
    }
}

/// Fits part of a tree to triangles that have moved: blocks take their corners, and nodes the boxes around them, children first.
pub fn refit(
    nodes: &mut [TreeNode],
    range: Range<usize>,
    blocks: &mut [TriangleBlock],
    leaves: Range<usize>,
    triangles: &[Triangle],
) {
    for block in &mut blocks[leaves] {
        let (first, count) = (block.first as usize, block.count as usize);
        fill(block, |lane| (lane < count).then(|| triangles[first + lane]));
    }
    let of_block = |block: &TriangleBlock| {
        let own = &triangles[block.first as usize..(block.first + block.count) as usize];
        own.iter().fold(Aabb::empty(), |all, triangle| all.union(&bounds(triangle)))
    };
    for id in range.rev() {
        for lane in 0..WIDTH {
            let child = nodes[id].children[lane];
            let bounds = match child & LEAF {
                _ if nodes[id].min_x[lane] == f32::MAX => continue,
                0 => of_node(&nodes[child as usize]),
                _ => of_block(&blocks[(child & !LEAF) as usize]),
            };
            set_lane(&mut nodes[id], lane, &bounds, child);
        }
    }
}

/// The box around a node's children.
fn of_node(node: &TreeNode) -> Aabb {
    let lanes = (0..WIDTH).filter(|&lane| node.min_x[lane] != f32::MAX);
    lanes.fold(Aabb::empty(), |all, lane| {
        let min = Vec3A::new(node.min_x[lane], node.min_y[lane], node.min_z[lane]);
        let max = Vec3A::new(node.max_x[lane], node.max_y[lane], node.max_z[lane]);
        all.union(&Aabb { min, max })
    })
}

/// Writes the corners of a block's triangles; unused lanes are points.
fn fill(block: &mut TriangleBlock, triangle: impl Fn(usize) -> Option<Triangle>) {
    let unused = triangle(0).unwrap_or_default().a;
    for lane in 0..WIDTH {
        let unused = Triangle { a: unused, b: unused, c: unused };
        let Triangle { a, b, c } = triangle(lane).unwrap_or(unused);
        (block.a_x[lane], block.a_y[lane], block.a_z[lane]) = a.into();
        (block.b_x[lane], block.b_y[lane], block.b_z[lane]) = b.into();
        (block.c_x[lane], block.c_y[lane], block.c_z[lane]) = c.into();
    }
}

/// A node of four empty lanes.
fn empty_node() -> TreeNode {
    // A box of no size far away is missed by every ray; an inverted one would be hit by all.
    let far = Vec4::splat(f32::MAX);
    TreeNode {
        min_x: far,
        min_y: far,
        min_z: far,
        max_x: far,
        max_y: far,
        max_z: far,
        children: [LEAF; WIDTH],
        padding: [0; 4],
    }
}

/// Sets a lane to a box that is two units in the last place larger: rounding in a traversal loses no triangle.
fn set_lane(node: &mut TreeNode, lane: usize, bounds: &Aabb, child: u32) {
    let min = Vec3::from(bounds.min).to_array().map(|x| x.next_down().next_down());
    let max = Vec3::from(bounds.max).to_array().map(|x| x.next_up().next_up());
    (node.min_x[lane], node.min_y[lane], node.min_z[lane]) = min.into();
    (node.max_x[lane], node.max_y[lane], node.max_z[lane]) = max.into();
    node.children[lane] = child;
}
