//! Layers of a pixel for other tools: denoisers, compositors.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::{Vec2, Vec3};

/// Surface that a pixel shows, at the first vertex of a camera path that is not specular; zeros without one.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Auxiliary {
    /// Position (m).
    pub position: Vec3,
    /// Length of the camera path (m); 0 marks "nothing here".
    pub depth: f32,
    /// Unit shading normal, on the viewer's side.
    pub normal: Vec3,
    /// Index into the materials.
    pub material: u32,
    /// Base colour of the material.
    pub albedo: Vec3,
    /// Number of the cell of the radiance cache around it, below 2^24.
    pub cell: u32,
    /// Motion in the image since the previous frame (px); x to the right, y down.
    pub motion: Vec2,
    /// Keeps records at 16 bytes.
    pub padding_behind: [u32; 2],
}

const _: () = assert!(size_of::<Auxiliary>() == 64);
