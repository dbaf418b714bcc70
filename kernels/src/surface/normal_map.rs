//! Normal maps: the interpolated normal, turned by a texture in the frame of its tangents.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::ray::Hit;
use crate::interface::scene::TextureTables;
use crate::interface::texture::{MaterialTextures, TextureCoordinates};
use crate::texture::sample::sample;
use spirv_std::glam::{Vec2, Vec3};

/// Mapped normal of the triangle's front, from its unit interpolated normal `normal`. Returns `normal` where the map is flat or
/// there is no tangent.
#[inline(always)]
pub fn normal(
    tables: TextureTables<'_>,
    record: &MaterialTextures,
    coordinates: &TextureCoordinates,
    hit: &Hit,
    normal: Vec3,
    uv: Vec2,
    uv_footprint: f32,
) -> Vec3 {
    let mapped = sample(tables, record.normal, uv, uv_footprint);
    let (x, y) = (mapped.x * record.normal_scale, mapped.y * record.normal_scale);
    let weight_a = 1.0 - hit.u - hit.v;
    let along =
        coordinates.tangent_a * weight_a + coordinates.tangent_b * hit.u + coordinates.tangent_c * hit.v;
    let tangent = along - normal * along.dot(normal);
    let square = tangent.length_squared();
    if square < 1.0e-8 || (x == 0.0 && y == 0.0) {
        return normal;
    }
    let tangent = tangent / square.sqrt();
    let bitangent = normal.cross(tangent) * coordinates.handedness;
    // Clamp mapped normals to the plane of the surface.
    (tangent * x + bitangent * y + normal * mapped.z.max(0.0)).normalize()
}
