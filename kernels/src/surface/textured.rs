//! Textured materials: factors times texels, at a vertex and at a collection point.

use crate::interface::features::Features;
use crate::interface::material::{
    FLAG_COLOR_TEXTURE, FLAG_EMISSIVE_TEXTURE, FLAG_ROUGHNESS_TEXTURE, FLAGS_TEXTURE, Material,
};
use crate::interface::packed::{from_byte, from_half, to_byte, to_half};
use crate::interface::point::PointShading;
use crate::interface::scene::SceneTables;
use crate::surface::vertex::Vertex;
use crate::texture::sample::sample;
use spirv_std::glam::Vec3;

/// Material at a vertex. Textured values are rounded to what a collection point can store. All paths thus see the same numbers
/// and agree which lobe is specular.
#[inline(always)]
pub fn material_at(scene: SceneTables<'_>, vertex: &Vertex, features: Features) -> Material {
    let mut material = scene.materials[vertex.material as usize];
    if features.has(Features::TEXTURES) && material.flags & FLAGS_TEXTURE != 0 {
        let record = scene.textures.material_textures[vertex.material as usize];
        let (at, footprint) = (vertex.uv, vertex.uv_footprint);
        if material.flags & FLAG_COLOR_TEXTURE != 0 {
            let texel = sample(scene.textures, record.base_color, at, footprint).truncate();
            let color = (material.base_color * texel).min(Vec3::ONE);
            material.base_color = rounded_color(color);
        }
        if material.flags & FLAG_ROUGHNESS_TEXTURE != 0 {
            let texel = sample(scene.textures, record.metallic_roughness, at, footprint);
            material.roughness = from_byte(to_byte((material.roughness * texel.y).min(1.0)));
            material.metallic = from_byte(to_byte((material.metallic * texel.z).min(1.0)));
        }
        if material.flags & FLAG_EMISSIVE_TEXTURE != 0 {
            // Use the finest level for every path: lights are sampled by it too.
            material.emission *= sample(scene.textures, record.emissive, at, 0.0).truncate();
        }
    }
    material
}

#[inline]
fn rounded_color(color: Vec3) -> Vec3 {
    Vec3::new(from_half(to_half(color.x)), from_half(to_half(color.y)), from_half(to_half(color.z)))
}

/// Packs the textured values into two words: (red and green; blue, roughness, metallic).
#[inline]
pub fn packed(material: &Material) -> (u32, u32) {
    let color = material.base_color;
    (
        to_half(color.x) | to_half(color.y) << 16,
        to_half(color.z) | to_byte(material.roughness) << 16 | to_byte(material.metallic) << 24,
    )
}

/// Material at a collection point.
#[inline(always)]
pub fn material_of(point: &PointShading, materials: &[Material], features: Features) -> Material {
    let mut material = materials[point.material as usize];
    if features.has(Features::TEXTURES) {
        let (first, second) = (point.red_green, point.blue_roughness_metallic);
        if material.flags & FLAG_COLOR_TEXTURE != 0 {
            material.base_color =
                Vec3::new(from_half(first & 0xffff), from_half(first >> 16), from_half(second & 0xffff));
        }
        if material.flags & FLAG_ROUGHNESS_TEXTURE != 0 {
            material.roughness = from_byte((second >> 16) & 255);
            material.metallic = from_byte(second >> 24);
        }
    }
    material
}
