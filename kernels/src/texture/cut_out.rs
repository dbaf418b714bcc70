//! Cut-outs and blending: surfaces that are not there everywhere, or not for every ray. A surface has holes where its alpha is
//! below its material's cut-off. Where it blends, it is there for a share alpha of rays [stochastic transparency, Enderton et al.
//! 2010].
//!
//! A hash of the ray's key, the triangle and its instance decides whether a ray meets a blended surface. Other hits and their
//! order have no influence. So tracers agree, a path that is traced again is the same, and passing a surface is no event. Rays
//! have keys of their own, so that layers and rays are independent: of n layers, each lets its own share of the light pass.

use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::instance::Instance;
use crate::interface::material::{FLAG_BLEND, FLAG_CUT_OUT, Material};
use crate::interface::ray::Hit;
use crate::interface::scene::{SceneTables, TextureTables};
use crate::interface::texture::{MaterialTextures, TextureCoordinates};
use crate::interface::triangle::TriangleSurface;
use crate::math::rng::{pcg4d, units};
use crate::texture::sample::sample;
use spirv_std::glam::{UVec4, Vec2};

/// Features with which some surface is not there somewhere, or not for every ray.
pub const SOME_ARE_NOT_THERE: Features = Features(Features::CUT_OUTS.0 | Features::BLENDS.0);

/// Tables that a tracer reads beside its structure: instances, and the presence of surfaces at hits.
#[derive(Clone, Copy)]
pub struct CutOuts<'a> {
    /// Instances: the world, and meshes with records of their own.
    pub instances: &'a [Instance],
    /// Materials of triangles.
    pub surfaces: &'a [TriangleSurface],
    /// Materials.
    pub materials: &'a [Material],
    /// Textures.
    pub textures: TextureTables<'a>,
    /// Features that the scene needs.
    pub features: Features,
}

impl<'a> CutOuts<'a> {
    /// Tables of a scene.
    #[inline(always)]
    pub fn new(scene: SceneTables<'a>, features: Features) -> Self {
        let SceneTables { instances, surfaces, materials, textures, .. } = scene;
        CutOuts { instances, surfaces, materials, textures, features }
    }

    /// Whether a surface is there at a hit, for rays of a key.
    #[inline(always)]
    pub fn is_there(&self, hit: &Hit, key: u32) -> bool {
        !self.features.has(SOME_ARE_NOT_THERE) || self.is_solid(hit, key)
    }

    /// Whether a surface is there at a hit, in scenes with holes or blending. On a CPU it is not inlined, so that it takes no
    /// registers from tracers.
    #[cfg_attr(target_arch = "spirv", inline(always))]
    #[cfg_attr(not(target_arch = "spirv"), inline(never))]
    fn is_solid(&self, hit: &Hit, key: u32) -> bool {
        let share = self.share(hit.triangle, hit.u, hit.v);
        // A share of 0 or 1 needs no hash.
        share > 0.0 && (share >= 1.0 || share > hash_float(key, hit.triangle, hit.instance))
    }

    /// Share of rays for which a triangle is there; 0 in holes.
    #[inline(always)]
    pub fn share(&self, triangle: u32, u: f32, v: f32) -> f32 {
        let material = self.surfaces[triangle as usize].material;
        let flags = self.materials[material as usize].flags;
        if flags & (FLAG_CUT_OUT | FLAG_BLEND) == 0 {
            return 1.0;
        }
        let record = self.textures.material_textures[material as usize];
        let alpha = self.alpha(&record, triangle, u, v);
        if self.features.has(Features::BLENDS) && flags & FLAG_BLEND != 0 {
            return alpha;
        }
        if self.features.has(Features::CUT_OUTS) && flags & FLAG_CUT_OUT != 0 && alpha < record.alpha_cutoff {
            return 0.0;
        }
        1.0
    }

    #[inline(always)]
    fn alpha(&self, record: &MaterialTextures, triangle: u32, u: f32, v: f32) -> f32 {
        let mut alpha = record.alpha;
        if record.base_color != NONE {
            let at = uv(&self.textures.texture_coordinates[triangle as usize], u, v);
            alpha *= sample(self.textures, record.base_color, at, 0.0).w;
        }
        alpha
    }
}

/// Number uniform in [0, 1), by a ray's key and the triangle of an instance.
#[inline(always)]
pub fn hash_float(key: u32, triangle: u32, instance: u32) -> f32 {
    units(pcg4d(UVec4::new(key, triangle, instance ^ 0x6a09_e667, 0xbb67_ae85))).x
}

/// Texture coordinates at the weights `u` and `v` of corners b and c.
#[inline]
pub fn uv(coordinates: &TextureCoordinates, u: f32, v: f32) -> Vec2 {
    coordinates.uv_a + (coordinates.uv_b - coordinates.uv_a) * u + (coordinates.uv_c - coordinates.uv_a) * v
}
