//! The tables of a scene that paths read, as kernels pass them around.

use crate::interface::environment::{Environment, EnvironmentSum, EnvironmentTexel};
use crate::interface::instance::Instance;
use crate::interface::light::Light;
use crate::interface::material::Material;
use crate::interface::texture::{MaterialTextures, Texture, TextureCoordinates};
use crate::interface::triangle::{Triangle, TriangleSurface};

/// The tables of a scene that paths read.
#[derive(Clone, Copy)]
pub struct SceneTables<'a> {
    /// Corners.
    pub triangles: &'a [Triangle],
    /// Normals and ids.
    pub surfaces: &'a [TriangleSurface],
    /// The world, and meshes with rows in spaces of their own.
    pub instances: &'a [Instance],
    /// Materials.
    pub materials: &'a [Material],
    /// Lights.
    pub lights: &'a [Light],
    /// The environment: one row, or none, as in the two tables behind it.
    pub environment: &'a [Environment],
    /// Its image, from the top.
    pub environment_texels: &'a [EnvironmentTexel],
    /// Hierarchical CDF of its brightness over directions.
    pub environment_cdf: &'a [EnvironmentSum],
    /// Textures.
    pub textures: TextureTables<'a>,
}

/// The tables of textures; all are empty where no material is textured or cut out.
#[derive(Clone, Copy)]
pub struct TextureTables<'a> {
    /// Textures.
    pub textures: &'a [Texture],
    /// Which of them a material has, a row a material.
    pub material_textures: &'a [MaterialTextures],
    /// Where triangles lie on them, a row a triangle.
    pub texture_coordinates: &'a [TextureCoordinates],
    /// Texels of the first chunk.
    pub texels_0: &'a [u32],
    /// Of the second.
    pub texels_1: &'a [u32],
    /// Of the third.
    pub texels_2: &'a [u32],
    /// Of the fourth.
    pub texels_3: &'a [u32],
}
