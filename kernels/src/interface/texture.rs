//! Textures: their texels, the textures of materials, and the texture coordinates of triangles.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::{Vec2, Vec3};

/// Texels of a chunk, each with a buffer of its own: 2^25 of four bytes are 128 MiB, which every Vulkan device binds.
pub const CHUNK_TEXELS: u32 = 1 << 25;
/// Number of chunks, in buffers `texels_0` to `texels_3`.
pub const CHUNK_COUNT: u32 = 4;

/// A texture with all its levels, one after the other and the finest first. Each level begins at the image's top. Texels are four
/// bytes, red lowest. Their indices count through all chunks, and a texture may continue in the next chunk.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Texture {
    /// Index of the first texel of the finest level.
    pub offset: u32,
    /// Width of the finest level (texels); each further level has half of it, rounded down, at least 1.
    pub width: u32,
    /// Height of the finest level (texels).
    pub height: u32,
    /// Number of levels.
    pub level_count: u32,
    /// `WRAP_*` along u.
    pub wrap_u: u32,
    /// `WRAP_*` along v.
    pub wrap_v: u32,
    /// `ENCODING_*` of the texels.
    pub encoding: u32,
    /// 1: no interpolation between the texels of a level.
    pub nearest: u32,
}

/// The texture repeats.
pub const WRAP_REPEAT: u32 = 0;
/// The texture repeats, every other time mirrored.
pub const WRAP_MIRRORED: u32 = 1;
/// The outermost texels continue without end.
pub const WRAP_CLAMP: u32 = 2;

/// Values as shares of 255.
pub const ENCODING_LINEAR: u32 = 0;
/// Colours by the transfer function of sRGB; alpha is linear.
pub const ENCODING_SRGB: u32 = 1;
/// Components of a vector, (byte - 128) / 127, so that the default (128, 128, 255) is exactly flat.
pub const ENCODING_NORMAL: u32 = 2;

/// Textures of a material; `NONE` without one.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MaterialTextures {
    /// Factor on the base colour, and alpha.
    pub base_color: u32,
    /// Factors on roughness (green) and metallic (blue).
    pub metallic_roughness: u32,
    /// Factor on emission.
    pub emissive: u32,
    /// Normals in tangent space.
    pub normal: u32,
    /// Factor on a normal's x and y.
    pub normal_scale: f32,
    /// Factor on alpha.
    pub alpha: f32,
    /// Alpha below which the surface is absent.
    pub alpha_cutoff: f32,
    /// 1: alpha is the share of rays that meet the surface, and the cut-off is not applicable.
    pub blends: u32,
}

impl Default for MaterialTextures {
    fn default() -> Self {
        let none = crate::interface::NONE;
        MaterialTextures {
            base_color: none,
            metallic_roughness: none,
            emissive: none,
            normal: none,
            normal_scale: 1.0,
            alpha: 1.0,
            alpha_cutoff: 0.0,
            blends: 0,
        }
    }
}

/// Texture coordinates of a triangle.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct TextureCoordinates {
    /// Coordinates of corner a; (0, 0) is the image's upper left corner, (1, 1) its lower right.
    pub uv_a: Vec2,
    /// Coordinates of corner b.
    pub uv_b: Vec2,
    /// Coordinates of corner c.
    pub uv_c: Vec2,
    /// Unit tangent at corner a, towards growing u.
    pub tangent_a: Vec3,
    /// Unit tangent at corner b.
    pub tangent_b: Vec3,
    /// Unit tangent at corner c.
    pub tangent_c: Vec3,
    /// Sign of the bitangent: 1 or -1 times normal x tangent.
    pub handedness: f32,
    /// Length in uv over length on the triangle, mean over its area [1/m].
    pub density: f32,
}

const _: () = assert!(size_of::<Texture>() == 32);
const _: () = assert!(size_of::<MaterialTextures>() == 32);
const _: () = assert!(size_of::<TextureCoordinates>() == 68);
