//! How a triangle's interpolated normal turns along its face.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::features::Features;
use crate::interface::ray::Hit;
use crate::interface::scene::SceneTables;
use crate::math::face::{Face, Normals};
use spirv_std::glam::Vec3;

/// Change of the unit interpolated normal at `hit`, on the side that the path met, for a small `step` along the face (m);
/// zero on a flat triangle. What a normal map adds is left out.
#[inline(always)]
pub fn normal_change(scene: SceneTables<'_>, features: Features, hit: &Hit, front: bool, step: Vec3) -> Vec3 {
    if !features.has(Features::SMOOTH_NORMALS) {
        return Vec3::ZERO;
    }
    let face = Face::of(scene, features, hit.instance, hit.triangle);
    let normals = Normals::of(scene, features, hit.instance, hit.triangle);
    let smooth = normals.at(hit.u, hit.v);
    let (edge_b, edge_c) = (face.b - face.a, face.c - face.a);
    let outward = edge_b.cross(edge_c);
    let (length_squared, square) = (smooth.length_squared(), outward.length_squared());
    if length_squared <= 1.0e-12 || square == 0.0 {
        return Vec3::ZERO;
    }
    // The step in barycentric coordinates.
    let along_b = step.cross(edge_c).dot(outward) / square;
    let along_c = edge_b.cross(step).dot(outward) / square;
    let change = (normals.b - normals.a) * along_b + (normals.c - normals.a) * along_c;
    let length = length_squared.sqrt();
    let unit = smooth / length;
    let change = (change - unit * unit.dot(change)) / length;
    if front { change } else { -change }
}
