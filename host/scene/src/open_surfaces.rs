//! Open surfaces of media: tests whether they bound an inside, together with the opaque surfaces around them. Imports interface.
//!
//! The water of a pool bounds one: paths reach all points below it through its surface. An open surface in the air does not.
//! Paths pass its border from one side to the other, so the medium that they track would depend on the path.

use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::material::{FLAG_HANGING, FLAG_OPEN_SURFACE};
use caustics_kernels::interface::ray::Ray;
use caustics_kernels::interface::triangle::Triangle;
use caustics_kernels::math::frame::ShadingFrame;
use caustics_kernels::math::offset;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::math::warp;
use caustics_kernels::surface::vertex::vertex;
use caustics_kernels::trace::Tracer;
use glam::Vec3;

use super::{Scene, geometry};

/// Number of random walks from each open surface.
const WALKS: u32 = 2048;
/// Maximum number of faces that a walk meets.
const MAX_FACES: u32 = 16;
/// Maximum number of faces that walks start from: a stored mesh may have thousands of instances.
const MAX_STARTS: usize = 1 << 20;
/// A surface hangs if one walk in `ROUND` passes its border to the wrong side,
const ROUND: u32 = 100;
/// or if one in `OPEN` escapes from its inside. A hull that lacks one of six sides loses one in ten.
const OPEN: u32 = 6;

/// End of a walk.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    /// On the wrong side of the open surface.
    Round,
    /// Out of the scene, from inside.
    Open,
    /// Elsewhere.
    Consistent,
}

impl Scene {
    /// Marks the hanging open surfaces, at the current pose.
    pub(super) fn mark_hanging_surfaces(&mut self) {
        let hangs = |&id: &usize| self.materials[id].flags & FLAG_OPEN_SURFACE != 0 && self.hangs(id);
        let hanging: Vec<usize> = (0..self.materials.len()).filter(hangs).collect();
        for id in hanging {
            self.materials[id].flags |= FLAG_HANGING;
        }
    }

    /// Whether walks from the faces of this material reach the wrong side of its surface.
    fn hangs(&self, material: usize) -> bool {
        let of_material = |id: &usize| self.surfaces[*id].material as usize == material;
        let of_instance = |instance: usize| {
            let triangle_ids = self.instanced.triangle_ids(instance).filter(of_material);
            triangle_ids.map(move |id| self.world_triangle(instance as u32, id as u32))
        };
        let faces: Vec<Triangle> = (0..self.instances.len()).flat_map(of_instance).take(MAX_STARTS).collect();
        let mut area = 0.0;
        let areas = faces.iter().map(|face| {
            area += geometry::area(face);
            area
        });
        let areas: Vec<f64> = areas.collect();
        let ends = (0..WALKS).map(|walk| {
            let mut rng = Rng::new(Stream::Camera, 0, walk, 0);
            let [face, u, v, side] = rng.next4().to_array();
            let at = areas.partition_point(|&up_to| up_to <= f64::from(face) * area);
            let Some(face) = faces.get(at) else { return End::Consistent };
            let triangle_point = triangle_point(face, warp::uniform_triangle(u, v).to_array());
            self.walk(material, triangle_point, side < 0.5, &mut rng)
        });
        let ends: Vec<End> = ends.collect();
        let count = |end| ends.iter().filter(|&&found| found == end).count() as u32;
        count(End::Round) >= WALKS / ROUND || count(End::Open) >= WALKS / OPEN
    }

    /// Walks from a face, from its inside or its outside, through transmitting surfaces and diffusely off others.
    fn walk(
        &self,
        material: usize,
        (position, front, clearance): (Vec3, Vec3, f32),
        mut inside: bool,
        rng: &mut Rng,
    ) -> End {
        let tables = self.tables();
        let mut tracer = self.tracer(Features::ALL);
        let leave = |position, normal: Vec3, clearance, rng: &mut Rng| {
            let u = rng.next4();
            let direction = ShadingFrame::new(normal).to_world(warp::cosine_hemisphere(u.x, u.y));
            Ray::endless(offset::leave(position, normal, direction, clearance), direction)
        };
        let mut ray = leave(position, if inside { -front } else { front }, clearance, rng);
        for _ in 0..MAX_FACES {
            let hit = tracer.closest(&ray);
            if hit.is_miss() {
                return if inside { End::Open } else { End::Consistent };
            }
            let here = vertex(tables, Features::INSTANCES, &ray, &hit, 0.0);
            if here.material as usize == material {
                if here.front == inside {
                    return End::Round;
                }
                inside = here.front;
            }
            ray = if self.materials[here.material as usize].transmits() {
                let origin = offset::leave(here.position, here.face_normal, ray.direction, here.clearance);
                Ray::endless(origin, ray.direction)
            } else {
                leave(here.position, here.face_normal, here.clearance, rng)
            };
        }
        End::Consistent
    }
}

/// A point of a triangle, with its normal and clearance.
fn triangle_point(triangle: &Triangle, [u, v]: [f32; 2]) -> (Vec3, Vec3, f32) {
    let (b, c) = (triangle.b - triangle.a, triangle.c - triangle.a);
    let magnitude = offset::magnitude(triangle.a, triangle.b, triangle.c);
    (triangle.a + b * u + c * v, b.cross(c).normalize(), offset::clearance(magnitude))
}
