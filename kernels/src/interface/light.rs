//! The light table: every emitter with its alias-table row and its chance of being chosen.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// One emitter: an emissive triangle or a point light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Light {
    /// Position of a point light [m]; unused by triangles.
    pub position: Vec3,
    /// Triangle id, or `NONE` for a point light.
    pub triangle: u32,
    /// Radiance of a triangle [W m^-2 sr^-1], intensity of a point light [W sr^-1].
    pub emission: Vec3,
    /// Area of the triangle [m^2]; 0 for a point light.
    pub area: f32,
    /// Chance that this light is chosen (its share of the scene's power).
    pub pdf_light_choice: f32,
    /// Row of the alias table: keep this light if the second random number is below, else take `alias`.
    pub threshold: f32,
    /// The other light of this row of the alias table.
    pub alias: u32,
    /// Sides that emit: 1 (front) or 2; 0 for a point light.
    pub sides: u32,
}

const _: () = assert!(size_of::<Light>() == 48);
