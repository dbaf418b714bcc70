//! Texture coordinates of triangles in the world.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::features::Features;
use crate::interface::scene::SceneTables;
use crate::interface::texture::TextureCoordinates;
use crate::math::face::{Face, unit};

/// Texture coordinates of a triangle of an instance, which stands at `face`: tangents turn with it, and the density follows its
/// size.
#[inline(always)]
pub fn coordinates(
    scene: SceneTables<'_>,
    features: Features,
    instance: u32,
    triangle: u32,
    face: &Face,
) -> TextureCoordinates {
    let mut record = scene.textures.texture_coordinates[triangle as usize];
    if features.has(Features::INSTANCES) && instance != 0 {
        let own = scene.triangles[triangle as usize];
        let (area, in_world) = ((own.b - own.a).cross(own.c - own.a).length(), face.outward().length());
        // A triangle without an area is never hit.
        record.density *= (area / in_world.max(f32::MIN_POSITIVE)).sqrt();
        let to_world = scene.instances[instance as usize].to_world;
        record.tangent_a = unit(to_world.vector(record.tangent_a));
        record.tangent_b = unit(to_world.vector(record.tangent_b));
        record.tangent_c = unit(to_world.vector(record.tangent_c));
        record.handedness *= face.orientation;
    }
    record
}
