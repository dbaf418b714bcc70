//! The path vertex that a hit makes: position, normals, material.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::features::Features;
use crate::interface::material::{FLAG_NORMAL_MAP, FLAGS_TEXTURE};
use crate::interface::ray::{Hit, Ray};
use crate::interface::scene::SceneTables;
use crate::math::face::{Face, VertexNormals};
use crate::surface::normal_map;
use crate::texture::coordinates::coordinates;
use crate::texture::cut_out::uv;
use spirv_std::glam::{Vec2, Vec3};

/// Vertex of a path on a triangle. The face normal lies on the side that the path came from. The shading normal lies on the same
/// side of its own surface, which may face away from the path (`surface/hemisphere.rs`).
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// Position (m), interpolated from the corners.
    pub position: Vec3,
    /// Unit direction back along the path.
    pub to_previous: Vec3,
    /// Unit normal of the face.
    pub face_normal: Vec3,
    /// Unit normal of the lobes: that of the face or the interpolated one, turned by the normal map.
    pub shading_normal: Vec3,
    /// Signed curvature [1/m], positive where the side met is convex.
    pub curvature: f32,
    /// Whether the path met the triangle's front.
    pub front: bool,
    /// Index into the materials.
    pub material: u32,
    /// Index into the lights, or `NONE`.
    pub light: u32,
    /// Index into the instances if it moves, else 0.
    pub instance: u32,
    /// Distance to keep when leaving (m).
    pub clearance: f32,
    /// Texture coordinates; unused without a texture.
    pub uv: Vec2,
    /// Width of the path's footprint in texture coordinates; 0 for the finest level.
    pub uv_footprint: f32,
}

/// Smallest cosine that footprints are projected with.
const MIN_COS: f32 = 0.05;

/// Vertex at `hit` of `ray`, whose cone is `width` (m) wide there. A camera prefix gives the width of its cone. Every other path
/// gives 0, so that paths of both kinds see the same material behind the collection point.
#[inline(always)]
pub fn vertex(scene: SceneTables<'_>, features: Features, ray: &Ray, hit: &Hit, width: f32) -> Vertex {
    let face = Face::new(scene, features, hit.instance, hit.triangle);
    let surface = scene.surfaces[hit.triangle as usize];
    let to_previous = -ray.direction;
    let outward = face.outward();
    let front = outward.dot(to_previous) >= 0.0;
    let side = if front { 1.0 } else { -1.0 };
    let face_normal = outward.normalize() * side;

    let (mut shading_normal, mut curvature, mut moving) = (face_normal, surface.curvature, 0);
    if features.has(Features::INSTANCES) {
        moving = scene.instances[hit.instance as usize].moving;
    }
    // Interpolate the normal
    if features.has(Features::SMOOTH_NORMALS) {
        let normals = VertexNormals::new(scene, features, hit.instance, hit.triangle);
        if features.has(Features::INSTANCES) && hit.instance != 0 && curvature != 0.0 {
            curvature = normals.curvature(&face);
        }
        let smooth = normals.at(hit.u, hit.v) * side;
        let length_squared = smooth.length_squared();
        // Keep the face's normal where the interpolated one is zero.
        if length_squared > 1.0e-12 {
            shading_normal = smooth / length_squared.sqrt();
        }
    }

    // Find the texture coordinates and their footprint, and turn the normal by its map
    let (mut at, mut uv_footprint) = (Vec2::ZERO, 0.0);
    if features.has(Features::TEXTURES | Features::NORMAL_MAPS) {
        let flags = scene.materials[surface.material as usize].flags;
        if flags & FLAGS_TEXTURE != 0 {
            let coordinates = coordinates(scene, features, hit.instance, hit.triangle, &face);
            at = uv(&coordinates, hit.u, hit.v);
            // Longer axis of the footprint [ray cones, section 3].
            uv_footprint = width.abs() * coordinates.density / to_previous.dot(face_normal).max(MIN_COS);
            if features.has(Features::NORMAL_MAPS) && flags & FLAG_NORMAL_MAP != 0 {
                let record = scene.textures.material_textures[surface.material as usize];
                let mapped = normal_map::normal(
                    scene.textures,
                    &record,
                    &coordinates,
                    hit,
                    shading_normal * side,
                    at,
                    uv_footprint,
                );
                shading_normal = mapped * side;
            }
        }
    }
    Vertex {
        position: face.a + (face.b - face.a) * hit.u + (face.c - face.a) * hit.v,
        to_previous,
        face_normal,
        shading_normal,
        curvature: curvature * side,
        front,
        material: surface.material,
        light: surface.light,
        instance: moving,
        clearance: face.clearance,
        uv: at,
        uv_footprint,
    }
}
