//! The path vertex that a hit makes: position, normals, material.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::needs::Needs;
use crate::interface::triangle::{Triangle, TriangleSurface};
use crate::math::offset;
use crate::math::ray::{Hit, Ray};
use spirv_std::glam::Vec3;

/// A vertex of a path on a triangle. Normals lie on the side that the path came from.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// Position [m], interpolated from the corners.
    pub position: Vec3,
    /// Unit direction back along the path.
    pub to_origin: Vec3,
    /// Unit normal of the face.
    pub face_normal: Vec3,
    /// Unit interpolated normal.
    pub normal: Vec3,
    /// Signed curvature [1/m], positive where the side met is convex.
    pub curvature: f32,
    /// Whether the path met the triangle's front.
    pub front: bool,
    /// Index into the materials.
    pub material: u32,
    /// Index into the lights, or `NONE`.
    pub light: u32,
    /// Distance to keep when leaving [m].
    pub clearance: f32,
}

/// The vertex at `hit` of `ray`.
#[inline(always)]
pub fn vertex(
    triangles: &[Triangle],
    surfaces: &[TriangleSurface],
    needs: Needs,
    ray: &Ray,
    hit: &Hit,
) -> Vertex {
    let triangle = triangles[hit.triangle as usize];
    let surface = surfaces[hit.triangle as usize];
    let (edge_b, edge_c) = (triangle.b - triangle.a, triangle.c - triangle.a);
    let to_origin = -ray.direction;
    let outward = edge_b.cross(edge_c).normalize();
    let front = outward.dot(to_origin) >= 0.0;
    let side = if front { 1.0 } else { -1.0 };
    let face_normal = outward * side;

    // A smooth normal that faces away from the path cannot scatter it: the face's own stands in.
    let mut normal = face_normal;
    if needs.has(Needs::SMOOTH_NORMALS) {
        let a = 1.0 - hit.u - hit.v;
        let smooth = surface.normal_a * a + surface.normal_b * hit.u + surface.normal_c * hit.v;
        let smooth = smooth * side;
        let length_squared = smooth.length_squared();
        if smooth.dot(to_origin) > 0.0 && length_squared > 1.0e-12 {
            normal = smooth / length_squared.sqrt();
        }
    }
    Vertex {
        position: triangle.a + edge_b * hit.u + edge_c * hit.v,
        to_origin,
        face_normal,
        normal,
        curvature: surface.curvature * side,
        front,
        material: surface.material,
        light: surface.light,
        clearance: offset::clearance(offset::magnitude(triangle.a, triangle.b, triangle.c)),
    }
}
