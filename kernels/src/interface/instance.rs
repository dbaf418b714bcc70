//! Instances: where meshes stand that move or are stored once for many nodes, and where they stood in the frame before.

use bytemuck::{Pod, Zeroable};
use caustics_kernel_macros::shared;
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

/// An instance of a mesh; its rows of triangles are in its own space, and may serve other instances too. The first instance is the
/// world, where rows are what they say.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Instance {
    /// From the world, now, to the mesh's own space.
    pub to_object: Transform,
    /// Back.
    pub to_world: Transform,
    /// From the world, now, to where the same point of the mesh was in the frame before.
    pub to_previous: Transform,
    /// Root of the mesh's BVH in the nodes.
    pub root: u32,
    /// Id of the mesh's first triangle.
    pub first: u32,
    /// Its own index if it moves; 0, the world's, if it does not.
    pub moving: u32,
    /// 1, or -1 where it is mirrored: corners then run clockwise seen from the front.
    pub orientation: f32,
}

const _: () = assert!(size_of::<Instance>() == 160);

impl Transform {
    /// Leaves all as it is.
    pub const IDENTITY: Transform = Transform { x: Vec3::X, y: Vec3::Y, z: Vec3::Z, offset: Vec3::ZERO };

    /// Where what deforms was in the frame before: no map of all of it says so, and nothing is found that far away.
    pub const NOWHERE: Transform = Transform { offset: Vec3::splat(1.0e9), ..Transform::IDENTITY };

    /// Whether it is [`Transform::NOWHERE`].
    #[inline(always)]
    pub fn is_nowhere(&self) -> bool {
        self.offset.x == Transform::NOWHERE.offset.x
    }

    /// A direction, its length changed too.
    #[shared]
    pub fn vector(self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    /// A normal, its length changed too, of what the inverse of this map places.
    #[shared]
    pub fn normal(self, n: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(n), self.y.dot(n), self.z.dot(n))
    }

    /// A position (m).
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
