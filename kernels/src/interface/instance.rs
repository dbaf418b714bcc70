//! Instances: transforms of meshes that move or are stored once for many nodes, now and in the previous frame.

use bytemuck::{Pod, Zeroable};
use caustics_kernel_macros::shared;
use spirv_std::glam::Vec3;

/// An affine map.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Transform {
    /// Transformed x axis.
    pub x: Vec3,
    /// Transformed y axis.
    pub y: Vec3,
    /// Transformed z axis.
    pub z: Vec3,
    /// Transformed origin (m).
    pub offset: Vec3,
}

/// An instance of a mesh. The records of its triangles are in the mesh's own space, and may serve other instances too. The first
/// instance is the world, whose records are in world space.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Instance {
    /// Map from the world, now, to the mesh's own space.
    pub to_object: Transform,
    /// Map from the mesh's own space to the world, now.
    pub to_world: Transform,
    /// Map from a point of the mesh in the world, now, to its position in the previous frame.
    pub to_previous: Transform,
    /// Root of the mesh's BVH in the nodes.
    pub root: u32,
    /// Id of the mesh's first triangle.
    pub first: u32,
    /// Own index if it moves, else 0, the index of the world.
    pub moving: u32,
    /// 1, or -1 if it is mirrored: corners then run clockwise seen from the front.
    pub orientation: f32,
}

const _: () = assert!(size_of::<Instance>() == 160);

impl Transform {
    /// The identity.
    pub const IDENTITY: Transform = Transform { x: Vec3::X, y: Vec3::Y, z: Vec3::Z, offset: Vec3::ZERO };

    /// Marks a mesh without previous positions: it deforms, or was hidden. Nothing is found that far away.
    pub const NOWHERE: Transform = Transform { offset: Vec3::splat(1.0e9), ..Transform::IDENTITY };

    /// Whether it is [`Transform::NOWHERE`].
    #[inline(always)]
    pub fn is_nowhere(&self) -> bool {
        self.offset.x == Transform::NOWHERE.offset.x
    }

    /// Transforms a direction; its length may change.
    #[shared]
    pub fn vector(self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    /// Transforms a normal of a mesh that the inverse of this map places; its length may change.
    #[shared]
    pub fn normal(self, n: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(n), self.y.dot(n), self.z.dot(n))
    }

    /// Transforms a position (m).
    #[shared]
    pub fn point(self, p: Vec3) -> Vec3 {
        self.vector(p) + self.offset
    }
}

impl Default for Transform {
    fn default() -> Self {
        Transform::IDENTITY
    }
}

impl Default for Instance {
    /// The world.
    fn default() -> Self {
        Instance {
            to_object: Transform::IDENTITY,
            to_world: Transform::IDENTITY,
            to_previous: Transform::IDENTITY,
            root: 0,
            first: 0,
            moving: 0,
            orientation: 1.0,
        }
    }
}
