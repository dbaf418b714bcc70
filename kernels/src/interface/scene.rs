//! The tables of a scene that paths read, as kernels pass them around.

use crate::interface::environment::{Environment, EnvironmentSum, EnvironmentTexel};
use crate::interface::instance::Instance;
use crate::interface::light::Light;
use crate::interface::light_bvh::LightBvhNode;
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
    /// Instances: the world, and meshes with records in spaces of their own.
    pub instances: &'a [Instance],
    /// Materials.
    pub materials: &'a [Material],
    /// Lights.
    pub lights: &'a [Light],
    /// Nodes of the light BVH; none where there are few lights.
    pub light_bvh: &'a [LightBvhNode],
    /// Environment: one record or none; without one, the next two tables are empty.
    pub environment: &'a [Environment],
    /// Image of the environment, from the top.
    pub environment_texels: &'a [EnvironmentTexel],
    /// Hierarchical CDF of the environment's brightness over directions.
    pub environment_cdf: &'a [EnvironmentSum],
    /// Textures.
    pub textures: TextureTables<'a>,
}

/// The tables of textures; all are empty if no material is textured or cut out.
#[derive(Clone, Copy)]
pub struct TextureTables<'a> {
    /// Textures.
    pub textures: &'a [Texture],
    /// Textures of each material.
    pub material_textures: &'a [MaterialTextures],
    /// Texture coordinates of each triangle.
    pub texture_coordinates: &'a [TextureCoordinates],
    /// Texels of the first chunk.
    pub texels_0: &'a [u32],
    /// Texels of the second chunk.
    pub texels_1: &'a [u32],
    /// Texels of the third chunk.
    pub texels_2: &'a [u32],
    /// Texels of the fourth chunk.
    pub texels_3: &'a [u32],
}
