//! Change of a triangle's interpolated normal along its face.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::features::Features;
use crate::interface::ray::Hit;
use crate::interface::scene::SceneTables;
use crate::math::face::{Face, VertexNormals};
use caustics_kernel_macros::shared;
use spirv_std::glam::Vec3;

/// Changes of the unit interpolated normal at `hit`, for two small steps along the face (m). The normal is on the side that the
/// path met; a flat triangle has no change. A normal map is left out.
#[inline(always)]
pub fn normal_changes(
    scene: SceneTables<'_>,
    features: Features,
    hit: &Hit,
    front: bool,
    steps: (Vec3, Vec3),
) -> (Vec3, Vec3) {
    if !features.has(Features::SMOOTH_NORMALS) {
        return (Vec3::ZERO, Vec3::ZERO);
    }
    let face = Face::new(scene, features, hit.instance, hit.triangle);
    let normals = VertexNormals::new(scene, features, hit.instance, hit.triangle);
    let (smooth, side) = (normals.at(hit.u, hit.v), if front { 1.0 } else { -1.0 });
    (change(face, normals, smooth, steps.0) * side, change(face, normals, smooth, steps.1) * side)
}

/// Change of the normal of the triangle's front, which points along `smooth`.
#[shared]
fn change(face: Face, normals: VertexNormals, smooth: Vec3, step: Vec3) -> Vec3 {
    let (edge_b, edge_c) = (face.b - face.a, face.c - face.a);
    let outward = edge_b.cross(edge_c);
    let (length_squared, square) = (smooth.length_squared(), outward.length_squared());
    if length_squared <= 1.0e-12 || square == 0.0 {
        return Vec3::ZERO;
    }
    // Express the step in barycentric coordinates.
    let along_b = step.cross(edge_c).dot(outward) / square;
    let along_c = edge_b.cross(step).dot(outward) / square;
    let change = (normals.b - normals.a) * along_b + (normals.c - normals.a) * along_c;
    let length = length_squared.sqrt();
    let unit = smooth / length;
    (change - unit * unit.dot(change)) / length
}
