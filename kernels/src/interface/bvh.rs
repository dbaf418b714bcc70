//! The software bounding volume hierarchy: four children a node, up to four triangles a leaf.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec4;

/// Boxes of four children (m), one lane a child. An empty lane has all its planes at f32::MAX, so that every ray misses it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct BvhNode {
    /// Minima of the four boxes on x.
    pub min_x: Vec4,
    /// Minima on y.
    pub min_y: Vec4,
    /// Minima on z.
    pub min_z: Vec4,
    /// Maxima on x.
    pub max_x: Vec4,
    /// Maxima on y.
    pub max_y: Vec4,
    /// Maxima on z.
    pub max_z: Vec4,
    /// Node index, or `LEAF | index` of a `TriangleBlock`.
    pub children: [u32; 4],
    /// Keeps nodes at two cache lines.
    pub padding: [u32; 4],
}

/// Marks a leaf in `BvhNode::children`.
pub const LEAF: u32 = 0x8000_0000;

/// Marks an instance in `BvhNode::children`, without `LEAF`; the other bits are its index.
pub const INSTANCE: u32 = 0x4000_0000;

/// Number of entries of the traversal stack; the builder keeps the BVH shallow enough (three pushes a level).
pub const BVH_STACK_SIZE: usize = 64;

/// Up to four triangles of a leaf, one lane each. An unused lane has three equal corners, which no ray hits.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct TriangleBlock {
    /// First corners (m): x, y and z, each of four lanes.
    pub a: [[f32; 4]; 3],
    /// Second corners.
    pub b: [[f32; 4]; 3],
    /// Third corners.
    pub c: [[f32; 4]; 3],
    /// Id of the triangle in lane 0; the others follow.
    pub first: u32,
    /// Number of lanes in use.
    pub count: u32,
    /// Keeps blocks at 16 bytes.
    pub padding: [u32; 2],
}

const _: () = assert!(size_of::<BvhNode>() == 128);
const _: () = assert!(size_of::<TriangleBlock>() == 160);
