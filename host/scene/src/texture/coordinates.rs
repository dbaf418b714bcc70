//! Tangents and texel density of a triangle.

use caustics_kernels::interface::texture::TextureCoordinates;
use caustics_kernels::interface::triangle::Triangle;
use glam::{Vec3, Vec4Swizzles};

use super::parts::CornerCoordinates;
use crate::geometry;

/// Texture coordinate record of a triangle. If the file has no tangents, they run along increasing u, the same at all corners. A
/// triangle without an area on the texture has no tangents, and ignores its normal map.
pub fn record(triangle: &Triangle, corners: &CornerCoordinates) -> TextureCoordinates {
    let [a, b, c] = geometry::corners(triangle);
    let [uv_a, uv_b, uv_c] = corners.uv;
    let (along_b, along_c) = ((uv_b - uv_a).as_dvec2(), (uv_c - uv_a).as_dvec2());
    let twice_area = along_b.perp_dot(along_c);
    let density = (0.5 * twice_area.abs() / geometry::area(triangle)).sqrt() as f32;

    let (tangents, handedness) = match corners.tangents {
        Some(tangents) => {
            let sum: f32 = tangents.iter().map(|tangent| tangent.w).sum();
            (tangents.map(|tangent| tangent.xyz()), if sum < 0.0 { -1.0 } else { 1.0 })
        }
        None => {
            let towards_u = ((b - a) * along_c.y - (c - a) * along_b.y) * twice_area;
            let tangent = towards_u.try_normalize().map_or(Vec3::ZERO, |tangent| tangent.as_vec3());
            // The map's y axis points up the image, against increasing v.
            ([tangent; 3], if twice_area > 0.0 { -1.0 } else { 1.0 })
        }
    };
    let [tangent_a, tangent_b, tangent_c] = tangents;
    TextureCoordinates { uv_a, uv_b, uv_c, tangent_a, tangent_b, tangent_c, handedness, density }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn tangents_run_along_u_and_bitangents_up_the_image() {
        let triangle = Triangle { a: Vec3::ZERO, b: 2.0 * Vec3::X, c: 2.0 * Vec3::Y };
        // An upright image on the plane: v decreases along y. Then a mirrored one: u decreases along x.
        for (sign, handedness) in [(1.0, 1.0), (-1.0, -1.0)] {
            let uv = [Vec2::new(0.0, 1.0), Vec2::new(sign, 1.0), Vec2::new(0.0, 0.0)];
            let record = record(&triangle, &CornerCoordinates { uv, tangents: None });
            assert_eq!((record.tangent_a, record.handedness), (sign * Vec3::X, handedness));
            let up = Vec3::Z.cross(record.tangent_a) * record.handedness;
            assert_eq!(up, Vec3::Y);
            assert_eq!(record.density, 0.5);
        }
    }
}
