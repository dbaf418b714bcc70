//! Geometry tables, one record a triangle, in the order of the software BVH's leaves. The triangles of the world come first, then
//! those of every mesh that is an instance, in its own space.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// Corners of a triangle (m); counter-clockwise seen from its front. Also the vertex buffer of the hardware build.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Triangle {
    /// First corner.
    pub a: Vec3,
    /// Second corner: barycentric u = 1.
    pub b: Vec3,
    /// Third corner: barycentric v = 1.
    pub c: Vec3,
}

/// Surface of a triangle: vertex normals, material and light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct TriangleSurface {
    /// Unit vertex normal at `a`. All three are zero where the face's own normal serves.
    pub normal_a: Vec3,
    /// Unit vertex normal at `b`.
    pub normal_b: Vec3,
    /// Unit vertex normal at `c`.
    pub normal_c: Vec3,
    /// Mean signed curvature of the interpolated normals [1/m], positive where the front is convex.
    pub curvature: f32,
    /// Index into the materials.
    pub material: u32,
    /// Index into the light table, or `NONE`. A mesh that emits has one instance.
    pub light: u32,
}

const _: () = assert!(size_of::<Triangle>() == 36);
const _: () = assert!(size_of::<TriangleSurface>() == 48);
