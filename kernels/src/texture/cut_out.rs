//! Holes: a surface whose alpha is below its material's cut-off is not there.

use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::material::{FLAG_CUT_OUT, Material};
use crate::interface::scene::{SceneTables, TextureTables};
use crate::interface::texture::TextureCoordinates;
use crate::interface::triangle::TriangleSurface;
use crate::texture::sample::sample;
use spirv_std::glam::Vec2;

/// What a tracer reads to know whether a hit is there.
#[derive(Clone, Copy)]
pub struct CutOuts<'a> {
    /// Materials of triangles.
    pub surfaces: &'a [TriangleSurface],
    /// Materials.
    pub materials: &'a [Material],
    /// Textures.
    pub textures: TextureTables<'a>,
    /// What the scene needs.
    pub features: Features,
}

impl<'a> CutOuts<'a> {
    /// Those of a scene.
    #[inline(always)]
    pub fn of(scene: SceneTables<'a>, features: Features) -> Self {
        CutOuts { surfaces: scene.surfaces, materials: scene.materials, textures: scene.textures, features }
    }

    /// Whether a triangle is there at the weights `u` and `v` of its corners b and c.
    #[inline(always)]
    pub fn is_there(&self, triangle: u32, u: f32, v: f32) -> bool {
        !self.features.has(Features::CUT_OUTS) || self.is_solid(triangle, u, v)
    }

    /// The same where there are holes. On a CPU an own function, so that it takes no registers from tracers.
    #[cfg_attr(target_arch = "spirv", inline(always))]
    #[cfg_attr(not(target_arch = "spirv"), inline(never))]
    fn is_solid(&self, triangle: u32, u: f32, v: f32) -> bool {
        let material = self.surfaces[triangle as usize].material;
        if self.materials[material as usize].flags & FLAG_CUT_OUT == 0 {
            return true;
        }
        let row = self.textures.material_textures[material as usize];
        let mut alpha = row.alpha;
        if row.base_color != NONE {
            let at = uv(&self.textures.texture_coordinates[triangle as usize], u, v);
            alpha *= sample(self.textures, row.base_color, at, 0.0).w;
        }
        alpha >= row.alpha_cutoff
    }
}

/// Texture coordinates at the weights `u` and `v` of corners b and c.
#[inline]
pub fn uv(coordinates: &TextureCoordinates, u: f32, v: f32) -> Vec2 {
    coordinates.uv_a + (coordinates.uv_b - coordinates.uv_a) * u + (coordinates.uv_c - coordinates.uv_a) * v
}
