//! Emission of textured triangles, for sampling and evaluation of lights.

use crate::interface::features::Features;
use crate::interface::material::FLAG_EMISSIVE_TEXTURE;
use crate::interface::scene::SceneTables;
use crate::texture::cut_out::{CutOuts, SOME_ARE_NOT_THERE, uv};
use crate::texture::sample::sample;
use spirv_std::glam::Vec3;

/// Share of a light's emission that leaves its triangle at the weights `u` and `v` of corners b and c. Its texture is filtered over a
/// footprint of a width in uv (0: the finest level).
#[inline(always)]
pub fn emission_at(
    scene: SceneTables<'_>,
    features: Features,
    triangle: u32,
    u: f32,
    v: f32,
    footprint: f32,
) -> Vec3 {
    let mut share = Vec3::ONE;
    if features.has(Features::TEXTURES | SOME_ARE_NOT_THERE) {
        let id = scene.surfaces[triangle as usize].material;
        let flags = scene.materials[id as usize].flags;
        if features.has(Features::TEXTURES) && flags & FLAG_EMISSIVE_TEXTURE != 0 {
            let at = uv(&scene.textures.texture_coordinates[triangle as usize], u, v);
            let record = scene.textures.material_textures[id as usize];
            share = sample(scene.textures, record.emissive, at, footprint).truncate();
        }
        if features.has(SOME_ARE_NOT_THERE) {
            share *= CutOuts::new(scene, features).share(triangle, u, v);
        }
    }
    share
}
