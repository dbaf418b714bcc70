//! Triangles in the world: the records of a mesh that is an instance are in its own space.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::features::Features;
use crate::interface::scene::SceneTables;
use crate::math::{max_abs, offset};
use caustics_kernel_macros::shared;
use spirv_std::glam::Vec3;

/// A triangle in the world.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    /// First corner (m).
    pub a: Vec3,
    /// Second corner.
    pub b: Vec3,
    /// Third corner.
    pub c: Vec3,
    /// 1, or -1 if corners run clockwise seen from the front, in a mirrored instance.
    pub orientation: f32,
    /// Distance to keep when leaving it (m).
    pub clearance: f32,
}

impl Face {
    /// A triangle of an instance.
    #[inline(always)]
    pub fn new(scene: SceneTables<'_>, features: Features, instance: u32, triangle: u32) -> Face {
        let record = scene.triangles[triangle as usize];
        let (mut a, mut b, mut c) = (record.a, record.b, record.c);
        let (mut orientation, mut largest) = (1.0, 0.0);
        if features.has(Features::INSTANCES) && instance != 0 {
            let to_world = scene.instances[instance as usize].to_world;
            (a, b, c) = (to_world.point(a), to_world.point(b), to_world.point(c));
            orientation = scene.instances[instance as usize].orientation;
            // The sum has the rounding error of its largest part.
            largest = max_abs(to_world.offset);
        }
        let clearance = offset::clearance(offset::magnitude(a, b, c).max(largest));
        Face { a, b, c, orientation, clearance }
    }

    /// Vector along the normal of the front, twice as long as the area (m^2).
    #[inline(always)]
    pub fn outward(&self) -> Vec3 {
        (self.b - self.a).cross(self.c - self.a) * self.orientation
    }
}

/// Vertex normals of a triangle in the world: unit vectors, or zeros where the face's own normal serves.
#[derive(Clone, Copy, Debug)]
pub struct VertexNormals {
    /// Normal at the first corner.
    pub a: Vec3,
    /// Normal at the second corner.
    pub b: Vec3,
    /// Normal at the third corner.
    pub c: Vec3,
}

impl VertexNormals {
    /// Vertex normals of a triangle of an instance.
    #[inline(always)]
    pub fn new(scene: SceneTables<'_>, features: Features, instance: u32, triangle: u32) -> VertexNormals {
        let record = scene.surfaces[triangle as usize];
        let (mut a, mut b, mut c) = (record.normal_a, record.normal_b, record.normal_c);
        if features.has(Features::INSTANCES) && instance != 0 {
            let to_object = scene.instances[instance as usize].to_object;
            (a, b, c) = (unit(to_object.normal(a)), unit(to_object.normal(b)), unit(to_object.normal(c)));
        }
        VertexNormals { a, b, c }
    }

    /// Mean of the normals, by the weights of the corners b and c.
    #[inline(always)]
    pub fn at(&self, u: f32, v: f32) -> Vec3 {
        self.a * (1.0 - u - v) + self.b * u + self.c * v
    }

    /// Mean over the edges of the normal's change along the edge [1/m]; 0 without vertex normals.
    #[inline(always)]
    pub fn curvature(&self, face: &Face) -> f32 {
        let along = |from: Vec3, to: Vec3, edge: Vec3| (to - from).dot(edge) / edge.length_squared();
        let sum = along(self.a, self.b, face.b - face.a)
            + along(self.b, self.c, face.c - face.b)
            + along(self.c, self.a, face.a - face.c);
        // Drop a curvature that overflows f32.
        let mut curvature = 0.0;
        if sum.abs() < 1.0e30 {
            curvature = sum / 3.0;
        }
        curvature
    }
}

/// Scales a vector to unit length; zero stays zero.
#[shared]
pub fn unit(v: Vec3) -> Vec3 {
    let square = v.length_squared();
    let mut inverse = 0.0;
    if square > 0.0 {
        inverse = 1.0 / square.sqrt();
    }
    v * inverse
}
