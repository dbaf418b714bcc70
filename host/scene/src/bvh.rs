//! Builds the four-wide BVH of `interface::bvh` over triangles. Imports obvhs, interface.

use std::ops::Range;

use caustics_kernels::interface::bvh::{BVH_STACK_SIZE, BvhNode, LEAF, TriangleBlock};
use caustics_kernels::interface::triangle::Triangle;
use glam::{Vec3, Vec3A, Vec4};
use obvhs::aabb::Aabb;
use rayon::prelude::*;

use self::groups::Groups;
use self::plan::{CollapsePlan, WIDTH, min_levels};

pub use self::binary::BvhQuality;
pub use self::cache::BvhCache;
pub use self::cache::{accepts, sealed_file};

mod binary;
mod cache;
mod clustering;
mod groups;
mod plan;
#[cfg(test)]
mod tests;
pub mod top;

/// Levels of nodes that the traversal's stack has room for: each pushes at most three of its four lanes.
pub const LEVELS: u32 = (BVH_STACK_SIZE / (WIDTH - 1)) as u32;

/// Number of triangles below a node from which its lanes are built in parallel.
const MANY: usize = 1 << 14;

/// A four-wide BVH and the order that it puts triangles in.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    /// Nodes; the first is the root.
    pub nodes: Vec<BvhNode>,
    /// Leaves, in the order of their triangles.
    pub blocks: Vec<TriangleBlock>,
    /// Old id of each triangle, by its new id.
    pub order: Vec<u32>,
}

/// Topology of a BVH. Boxes and blocks are computed from it and the triangles, and so always fit the triangles.
#[derive(Clone, Debug, Default, PartialEq)]
struct Shape {
    /// Children of each node, one a lane: a later node, `LEAF | index` of a leaf, or [`NO_CHILD`]. The first node is the root.
    children: Vec<[u32; WIDTH]>,
    /// Number of triangles in each leaf.
    counts: Vec<u8>,
    /// Old id of each triangle, by its new id.
    order: Vec<u32>,
}

/// An empty lane of a [`Shape`].
const NO_CHILD: u32 = u32::MAX;

/// Options of BVH builds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BvhOptions {
    /// Build quality.
    pub quality: BvhQuality,
    /// Cache on disk for BVHs of many triangles; `None`: no cache.
    pub cache: Option<BvhCache>,
}

/// Builds the BVH over at least one finite triangle, at most `levels` levels deep where `fits` allows it. Equal triangles give
/// equal bits, for any number of threads, and from the cache too.
pub fn build(triangles: &[Triangle], levels: u32, options: &BvhOptions) -> Bvh {
    let build = || shape(triangles, levels, options.quality);
    match &options.cache {
        Some(cache) => cache.bvh(triangles, levels, options.quality, build),
        None => build().bvh(triangles),
    }
}

fn shape(triangles: &[Triangle], levels: u32, quality: BvhQuality) -> Shape {
    let boxes: Vec<Aabb> = triangles.par_iter().map(bounds).collect();
    let groups = Groups::from_boxes(&boxes);
    let of_groups: Vec<Aabb> =
        (0..groups.count()).into_par_iter().map(|group| boxes[groups.get(group)[0] as usize]).collect();
    let binary = binary::build(&of_groups, quality);
    let plan = CollapsePlan::new(&binary, &groups);
    let mut builder = Builder { boxes: &boxes, plan: &plan, shape: Shape::default() };
    builder.node(0, levels);
    builder.shape
}

pub fn bounds(triangle: &Triangle) -> Aabb {
    Aabb::from_points(&[triangle.a, triangle.b, triangle.c].map(Vec3A::from))
}

/// Whether a BVH of `levels` levels can hold `count` triangles.
pub fn fits(count: usize, levels: u32) -> bool {
    min_levels(count) <= levels
}

struct Builder<'a> {
    boxes: &'a [Aabb],
    plan: &'a CollapsePlan<'a>,
    shape: Shape,
}

impl Builder<'_> {
    /// Appends a four-wide node for a binary node, at most `levels` levels deep.
    fn node(&mut self, binary: usize, levels: u32) -> u32 {
        let id = self.reserve();
        let lanes = self.plan.lanes(binary);
        // Build large lanes in parallel. Appending them in order gives the same bits as building them one after another.
        let parts: Option<Vec<(u32, Shape)>> = (self.plan.count(binary) >= MANY).then(|| {
            let part = |&child: &usize| {
                let mut part = Builder { shape: Shape::default(), ..*self };
                (part.lane(child, levels - 1), part.shape)
            };
            lanes.par_iter().map(part).collect()
        });
        let mut parts = parts.into_iter().flatten();
        for (lane, child) in lanes.into_iter().enumerate() {
            let reference = match parts.next() {
                Some((reference, part)) => self.shape.append(reference, part),
                None => self.lane(child, levels - 1),
            };
            self.shape.children[id][lane] = reference;
        }
        id as u32
    }

    /// Appends the part below a lane. It is balanced if the planned shape would be too deep.
    fn lane(&mut self, binary: usize, levels: u32) -> u32 {
        if self.plan.count(binary) <= WIDTH {
            let first = self.shape.order.len();
            self.plan.triangles(binary, &mut self.shape.order);
            return self.shape.block(first);
        }
        let fits = |child: usize| min_levels(self.plan.count(child)) < levels;
        let is_leaf = self.plan.is_leaf(binary);
        if !is_leaf && (self.plan.height(binary) <= levels || self.plan.lanes(binary).into_iter().all(fits)) {
            return self.node(binary, levels);
        }
        let mut ids = Vec::with_capacity(self.plan.count(binary));
        self.plan.triangles(binary, &mut ids);
        self.balanced(&mut ids)
    }

    /// Appends a BVH of minimum depth: quarters along the longest axis.
    fn balanced(&mut self, ids: &mut [u32]) -> u32 {
        if ids.len() <= WIDTH {
            let first = self.shape.order.len();
            self.shape.order.extend_from_slice(ids);
            return self.shape.block(first);
        }
        let id = self.reserve();
        let size = self.bounds(ids).diagonal();
        let axis = if size.x >= size.y.max(size.z) { 0 } else { 1 + usize::from(size.z > size.y) };
        ids.sort_by(|&a, &b| {
            let centre = |id: u32| self.boxes[id as usize].center_axis(axis);
            centre(a).total_cmp(&centre(b)).then(a.cmp(&b))
        });
        for (lane, quarter) in ids.chunks_mut(ids.len().div_ceil(WIDTH)).enumerate() {
            self.shape.children[id][lane] = self.balanced(quarter);
        }
        id as u32
    }

    fn bounds(&self, ids: &[u32]) -> Aabb {
        ids.iter().fold(Aabb::empty(), |all, &id| all.union(&self.boxes[id as usize]))
    }

    /// Appends a node of four empty lanes.
    fn reserve(&mut self) -> usize {
        self.shape.children.push([NO_CHILD; WIDTH]);
        self.shape.children.len() - 1
    }
}

impl Shape {
    /// Appends a leaf of all triangles from the id `first` on.
    fn block(&mut self, first: usize) -> u32 {
        self.counts.push((self.order.len() - first) as u8);
        LEAF | (self.counts.len() - 1) as u32
    }

    /// Appends another shape, and returns its reference relative to this one.
    fn append(&mut self, reference: u32, mut part: Shape) -> u32 {
        let (node, block) = (self.children.len() as u32, self.counts.len() as u32);
        for child in part.children.iter_mut().flatten().filter(|child| **child != NO_CHILD) {
            *child += if *child & LEAF != 0 { block } else { node };
        }
        self.children.append(&mut part.children);
        self.counts.append(&mut part.counts);
        self.order.append(&mut part.order);
        reference + if reference & LEAF != 0 { block } else { node }
    }

    /// Whether it is a valid BVH of this number of triangles, at most `levels` nodes deep. Each triangle must be in one leaf.
    /// Each leaf, and each node but the root, must be the child of one earlier node. This suffices for rays to find all their
    /// hits within the traversal's stack.
    fn is_sound(&self, triangles: usize, levels: u32) -> bool {
        let Shape { children, counts, order } = self;
        let mut seen = vec![false; triangles];
        let is_new = |id: &u32| seen.get_mut(*id as usize).is_some_and(|seen| !std::mem::replace(seen, true));
        let each_once = order.len() == triangles && order.iter().all(is_new);
        let fits = |&count: &u8| (1..=WIDTH).contains(&usize::from(count));
        let held: usize = counts.iter().map(|&count| usize::from(count)).sum();
        if !each_once || !counts.iter().all(fits) || held != triangles || children.is_empty() {
            return false;
        }
        let mut leaf_is_used = vec![false; counts.len()];
        // Depth of each node in levels, itself included; 0 where no parent is known.
        let mut depths = vec![0_u32; children.len()];
        depths[0] = 1;
        for (id, lanes) in children.iter().enumerate() {
            let depth = depths[id];
            let mut lanes = lanes.iter().filter(|child| **child != NO_CHILD).peekable();
            if !(1..=levels).contains(&depth) || lanes.peek().is_none() {
                return false;
            }
            for &child in lanes {
                let is_used = if child & LEAF != 0 {
                    let leaf = leaf_is_used.get_mut((child & !LEAF) as usize);
                    leaf.is_none_or(|is_used| std::mem::replace(is_used, true))
                } else {
                    let behind = depths.get_mut(child as usize).filter(|_| child as usize > id);
                    behind.is_none_or(|below| std::mem::replace(below, depth + 1) != 0)
                };
                if is_used {
                    return false;
                }
            }
        }
        leaf_is_used.iter().all(|is_used| *is_used)
    }

    /// Computes the BVH of these triangles. The shape must be sound.
    fn bvh(self, triangles: &[Triangle]) -> Bvh {
        let mut first = 0;
        let empty = self.counts.iter().map(|&count| {
            let block = TriangleBlock { first, count: count.into(), ..TriangleBlock::default() };
            first += block.count;
            block
        });
        let mut blocks: Vec<TriangleBlock> = empty.collect();
        blocks.par_iter_mut().for_each(|block| {
            let own = &self.order[block.first as usize..][..block.count as usize];
            fill(block, |lane| own.get(lane).map(|&id| triangles[id as usize]));
        });
        let of_block = |block: &TriangleBlock| {
            let own = &self.order[block.first as usize..][..block.count as usize];
            own.iter().fold(Aabb::empty(), |all, &id| all.union(&bounds(&triangles[id as usize])))
        };
        let leaves: Vec<Aabb> = blocks.par_iter().map(of_block).collect();

        // Fit the boxes, children first.
        let mut nodes = vec![empty_node(); self.children.len()];
        let mut boxes = vec![Aabb::empty(); nodes.len()];
        for (id, children) in self.children.iter().enumerate().rev() {
            for (lane, &child) in children.iter().enumerate().filter(|(_, child)| **child != NO_CHILD) {
                let is_leaf = child & LEAF != 0;
                let bounds = if is_leaf { leaves[(child & !LEAF) as usize] } else { boxes[child as usize] };
                boxes[id] = boxes[id].union(&bounds);
                set_lane(&mut nodes[id], lane, &bounds, child);
            }
        }
        Bvh { nodes, blocks, order: self.order }
    }
}

impl Bvh {
    /// Expected number of lanes that a ray through the scene enters, by their surface areas [MacDonald and Booth 1990].
    fn expected_boxes(&self) -> f64 {
        let area = |node: &BvhNode, lane: usize| {
            let size = |min: Vec4, max: Vec4| f64::from(max[lane]) - f64::from(min[lane]);
            let BvhNode { min_x, min_y, min_z, max_x, max_y, max_z, .. } = *node;
            let [x, y, z] = [size(min_x, max_x), size(min_y, max_y), size(min_z, max_z)];
            x * y + y * z + z * x
        };
        let lanes = |node| (0..WIDTH).map(move |lane| area(node, lane));
        self.nodes.iter().flat_map(lanes).sum::<f64>() / f64::from(node_bounds(&self.nodes[0]).half_area())
    }

    /// Appends nodes and blocks to those of other BVHs, and shifts the references of children accordingly.
    pub fn append_to(mut self, nodes: &mut Vec<BvhNode>, blocks: &mut Vec<TriangleBlock>) {
        shift(&mut self.nodes, nodes.len() as u32, blocks.len() as u32);
        nodes.append(&mut self.nodes);
        blocks.append(&mut self.blocks);
    }
}

/// Shifts the references of children by `node` nodes and `block` blocks.
fn shift(nodes: &mut [BvhNode], node: u32, block: u32) {
    for BvhNode { children, min_x, .. } in nodes {
        for lane in (0..WIDTH).filter(|&lane| min_x[lane] != f32::MAX) {
            children[lane] += if children[lane] & LEAF != 0 { block } else { node };
        }
    }
}

/// Refits part of a BVH to triangles that moved: updates corners in blocks, then boxes of nodes, children first.
pub fn refit(
    nodes: &mut [BvhNode],
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
                0 => node_bounds(&nodes[child as usize]),
                _ => of_block(&blocks[(child & !LEAF) as usize]),
            };
            set_lane(&mut nodes[id], lane, &bounds, child);
        }
    }
}

/// The box around a node's children.
fn node_bounds(node: &BvhNode) -> Aabb {
    let lanes = (0..WIDTH).filter(|&lane| node.min_x[lane] != f32::MAX);
    lanes.fold(Aabb::empty(), |all, lane| {
        let min = Vec3A::new(node.min_x[lane], node.min_y[lane], node.min_z[lane]);
        let max = Vec3A::new(node.max_x[lane], node.max_y[lane], node.max_z[lane]);
        all.union(&Aabb { min, max })
    })
}

/// Writes the corners of a block's triangles; unused lanes become points.
fn fill(block: &mut TriangleBlock, triangle: impl Fn(usize) -> Option<Triangle>) {
    let unused = triangle(0).unwrap_or_default().a;
    for lane in 0..WIDTH {
        let unused = Triangle { a: unused, b: unused, c: unused };
        let Triangle { a, b, c } = triangle(lane).unwrap_or(unused);
        for axis in 0..3 {
            block.a[axis][lane] = a[axis];
            block.b[axis][lane] = b[axis];
            block.c[axis][lane] = c[axis];
        }
    }
}

/// A node of four empty lanes.
fn empty_node() -> BvhNode {
    // Every ray misses a box of no size far away; it would hit an inverted box.
    let far = Vec4::splat(f32::MAX);
    BvhNode {
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

/// Sets a lane to a box that is enlarged by two units in the last place, so that rounding in the traversal loses no triangle.
fn set_lane(node: &mut BvhNode, lane: usize, bounds: &Aabb, child: u32) {
    let min = Vec3::from(bounds.min).to_array().map(|x| x.next_down().next_down());
    let max = Vec3::from(bounds.max).to_array().map(|x| x.next_up().next_up());
    (node.min_x[lane], node.min_y[lane], node.min_z[lane]) = min.into();
    (node.max_x[lane], node.max_y[lane], node.max_z[lane]) = max.into();
    node.children[lane] = child;
}
