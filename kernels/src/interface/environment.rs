//! The environment: light from all around, from infinitely far away, by an image of all directions.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// Environment of a scene. The image is latitude-longitude as in OpenEXR: its middle is +z, a quarter from the left is +x, the
/// top is +y.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Environment {
    /// Factor on the image's radiance.
    pub scale: Vec3,
    /// Width of the image (texels).
    pub width: u32,
    /// Middle of a sphere around the scene (m).
    pub centre: Vec3,
    /// Height of the image (texels).
    pub height: u32,
    /// Radius of that sphere (m).
    pub radius: f32,
    /// Rotation of the image around +y, from +z towards +x (turns, in [0, 1)).
    pub turn: f32,
    /// Keeps records at 16 bytes.
    pub padding: [u32; 2],
}

const _: () = assert!(size_of::<Environment>() == 48);

/// Radiance of a texel of the image (W m^-2 sr^-1, before the factor).
pub type EnvironmentTexel = Vec3;
/// Sum of the hierarchical CDF that directions are sampled by.
pub type EnvironmentSum = f32;
