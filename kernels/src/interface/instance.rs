//! Instances: where meshes that move stand now, and where they stood in the frame before.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// An affine map.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Transform {
    /// What becomes of the x axis.
    pub x: Vec3,
    /// Of the y axis.
    pub y: Vec3,
    /// Of the z axis.
    pub z: Vec3,
    /// Of the origin (m).
    pub offset: Vec3,
}

/// A mesh that moves. The first instance is the world: it does not move, and all that stands still belongs to it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Instance {
    /// From the world, now, to the mesh's own space.
    pub to_object: Transform,
    /// From the world, now, to where the same place of the mesh was in the frame before.
    pub to_previous: Transform,
    /// Root of the mesh's tree in the nodes.
    pub root: u32,
    /// Keeps rows at 16 bytes.
    pub padding: [u32; 3],
}

const _: () = assert!(size_of::<Instance>() == 112);

impl Transform {
    /// Leaves all as it is.
    pub const IDENTITY: Transform = Transform { x: Vec3::X, y: Vec3::Y, z: Vec3::Z, offset: Vec3::ZERO };

    /// A direction, its length changed too.
    #[inline(always)]
    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    /// A position (m).
    #[inline(always)]
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.vector(p) + self.offset
    }
}

impl Default for Transform {
    fn default() -> Self {
        Transform::IDENTITY
    }
}
