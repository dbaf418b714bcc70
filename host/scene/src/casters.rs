//! Spheres around the casters of a scene. A cut of the scene is made once for each threshold of specular roughness; its parts
//! move with their meshes.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use caustics_kernels::interface::caster::{Caster, Casters, MAX_CASTERS};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::instance::Transform;
use caustics_kernels::interface::triangle::Triangle;
use caustics_kernels::surface::thin_wall::is_thin_wall;
use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use rayon::prelude::*;

use super::{Scene, bvh, geometry};

/// Minimum gain of a split: the share by which it reduces the surface of the boxes. A gap, or a part beside another, exceeds it.
/// Halves of a pane or of a ball do not.
const WORTH: f32 = 0.1;
/// Weight of walls that light passes: root of the share 2 r / (1 + r) that glass reflects at normal incidence, 0.077.
const WALL_WEIGHT: f32 = 0.277;
/// Number of bins along an axis in which splits are tried.
const BINS: usize = 32;
/// Maximum number of triangles of a resting mesh in all its instances. Above it, each instance is one box.
const MAX_PIECES: usize = 1 << 20;

/// Cuts of a scene, by the bits of their thresholds.
#[derive(Debug, Default)]
pub struct Cuts(Mutex<Vec<(u32, Arc<Cut>)>>);

impl Clone for Cuts {
    fn clone(&self) -> Cuts {
        Cuts(Mutex::new(self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()))
    }
}

/// Spheres, each in the space of its instance (0: the world).
#[derive(Debug, Default)]
pub struct Cut(Vec<CutSphere>);

#[derive(Clone, Copy, Debug)]
struct CutSphere {
    instance: usize,
    /// Whether all its surfaces are thin walls.
    is_wall: bool,
    centre: Vec3,
    radius: f32,
}

/// Smallest unit of a part: a triangle, or the box around a mesh that is stored once for many instances.
#[derive(Clone, Copy)]
enum Piece {
    Triangle([Vec3; 3]),
    Box(Aabb),
}

/// Content of one sphere, from one moving instance or from the world.
struct Part {
    instance: usize,
    /// Whether it consists of thin walls; else it has none.
    is_wall: bool,
    pieces: Vec<Piece>,
    bounds: Aabb,
    /// The best plane to split it, if the gain is worth it.
    split: Option<Split>,
}

#[derive(Clone, Copy)]
struct Split {
    /// Reduction of the surface of the boxes (m^2).
    gain: f32,
    axis: usize,
    bin: usize,
}

impl Scene {
    /// Returns spheres around the casters at the current pose. Reflections up to `specular_roughness` are specular. If light
    /// passes thin walls, these cast by what they reflect alone, and have a smaller weight. Spheres of hidden meshes have no
    /// radius.
    pub fn casters(&self, specular_roughness: f32, passes_thin_walls: bool) -> Casters {
        let cut = {
            let mut cuts = self.casters.0.lock().unwrap_or_else(PoisonError::into_inner);
            let known = cuts.iter().find(|(bits, _)| *bits == specular_roughness.to_bits());
            match known {
                Some((_, cut)) => cut.clone(),
                None => {
                    let cut = Arc::new(Cut::for_scene(self, specular_roughness));
                    cuts.push((specular_roughness.to_bits(), cut.clone()));
                    cut
                }
            }
        };
        let mut casters = Casters { count: cut.0.len() as u32, ..Casters::default() };
        for (slot, sphere) in casters.spheres.iter_mut().zip(&cut.0) {
            *slot = self.posed(sphere, if passes_thin_walls && sphere.is_wall { WALL_WEIGHT } else { 1.0 });
        }
        casters
    }

    /// Transforms a sphere of an instance to the world.
    fn posed(&self, sphere: &CutSphere, weight: f32) -> Caster {
        let &CutSphere { instance, centre, radius, .. } = sphere;
        let Some(id) = instance.checked_sub(1) else { return Caster { centre, radius, weight } };
        let Some(to_world) = self.instanced.instance_transforms()[id].to_world else {
            return Caster::default();
        };
        let radius = radius * stretch(&to_world) * (1.0 + 1e-6);
        Caster { centre: to_world.point(centre), radius, weight }
    }
}

impl Cut {
    fn for_scene(scene: &Scene, specular_roughness: f32) -> Cut {
        let casts = |is_wall: bool| -> Vec<bool> {
            let casts = |id| {
                scene.features_of(id, specular_roughness).has(Features::CASTERS)
                    && is_thin_wall(&scene.materials[id]) == is_wall
            };
            (0..scene.materials.len()).map(casts).collect()
        };
        let mut parts: Vec<Part> =
            [false, true].iter().flat_map(|&is_wall| Part::all(scene, &casts(is_wall), is_wall)).collect();
        // Keep the largest parts if more meshes move than there are spheres.
        parts.sort_by(|a, b| cost(&b.bounds).total_cmp(&cost(&a.bounds)).then(a.instance.cmp(&b.instance)));
        parts.truncate(MAX_CASTERS);
        while parts.len() < MAX_CASTERS {
            let splits = parts.iter().enumerate().filter_map(|(id, part)| Some((id, part.split?)));
            let best = splits.max_by(|a, b| a.1.gain.total_cmp(&b.1.gain).then(b.0.cmp(&a.0)));
            let Some((id, split)) = best else { break };
            let halves = parts.swap_remove(id).halves(split);
            parts.extend(halves);
        }
        Cut(parts.iter().map(Part::sphere).collect())
    }
}

/// Half of a box's surface (m^2).
fn cost(bounds: &Aabb) -> f32 {
    let size = bounds.diagonal();
    size.x * size.y + size.y * size.z + size.z * size.x
}

/// The box around a transformed box.
fn around(bounds: &Aabb, to_world: &Transform) -> Aabb {
    union(Aabb::empty(), Piece::Box(*bounds).points().map(|p| to_world.point(p)))
}

impl Piece {
    fn from_triangle(triangle: &Triangle) -> Piece {
        Piece::Triangle([triangle.a, triangle.b, triangle.c])
    }

    fn middle(&self) -> Vec3 {
        match self {
            Piece::Triangle([a, b, c]) => (a + b + c) / 3.0,
            Piece::Box(bounds) => bounds.center().into(),
        }
    }

    /// Its corners.
    fn points(&self) -> impl Iterator<Item = Vec3> + use<> {
        let piece = *self;
        let count = if matches!(piece, Piece::Triangle(_)) { 3 } else { 8 };
        (0..count).map(move |id| match piece {
            Piece::Triangle(corners) => corners[id],
            Piece::Box(Aabb { min, max }) => {
                geometry::corners_of_box([min, max].map(|p| p.as_dvec3()))[id].as_vec3()
            }
        })
    }
}

fn union(bounds: Aabb, points: impl IntoIterator<Item = Vec3>) -> Aabb {
    points.into_iter().fold(bounds, |all, point| all.union(&Aabb::from_point(Vec3A::from(point))))
}

impl Part {
    /// Parts of the surfaces of some materials: one of all that rests, and one for each moving instance.
    fn all(scene: &Scene, materials: &[bool], is_wall: bool) -> Vec<Part> {
        let is_of_part = |id: &usize| materials[scene.surfaces[*id].material as usize];
        // Put everything that rests into one part with the world's triangles.
        let (mut still, mut parts) = (Vec::new(), Vec::new());
        let mut boxes: HashMap<usize, Option<Aabb>> = HashMap::new();
        let uses = scene.instanced.uses();
        for (instance, record) in scene.instances.iter().enumerate() {
            let triangle_ids = || scene.instanced.triangle_ids(instance).filter(is_of_part);
            if record.moving != 0 {
                let pieces = triangle_ids().map(|id| Piece::from_triangle(&scene.triangles[id])).collect();
                parts.extend(Part::new(instance, is_wall, pieces));
                continue;
            }
            let mesh = instance.checked_sub(1).map(|id| scene.instanced.instances[id].mesh);
            match mesh.filter(|&mesh| uses[mesh] * scene.instanced.meshes[mesh].count as usize > MAX_PIECES) {
                None => still.extend(
                    triangle_ids()
                        .map(|id| Piece::from_triangle(&scene.world_triangle(instance as u32, id as u32))),
                ),
                Some(mesh) => {
                    let bounds = || triangle_ids().map(|id| bvh::bounds(&scene.triangles[id]));
                    let own =
                        boxes.entry(mesh).or_insert_with(|| bounds().reduce(|all, next| all.union(&next)));
                    let to_world = scene.instanced.instance_transforms()[instance - 1].to_world;
                    still
                        .extend(own.zip(to_world).map(|(own, to_world)| Piece::Box(around(&own, &to_world))));
                }
            }
        }
        parts.extend(Part::new(0, is_wall, still));
        parts
    }

    /// Creates a part; `None` without pieces.
    fn new(instance: usize, is_wall: bool, pieces: Vec<Piece>) -> Option<Part> {
        let bounds = union(Aabb::empty(), pieces.iter().flat_map(Piece::points));
        let mut part = Part { instance, is_wall, pieces, bounds, split: None };
        let splits: Vec<Split> = (0..3).into_par_iter().filter_map(|axis| part.best(axis)).collect();
        part.split = splits.into_iter().max_by(|a, b| a.gain.total_cmp(&b.gain));
        (!part.pieces.is_empty()).then_some(part)
    }

    /// The sphere around the centre of its box.
    fn sphere(&self) -> CutSphere {
        let centre = Vec3::from(self.bounds.center());
        let points = self.pieces.iter().flat_map(Piece::points);
        let square = points.fold(0.0f32, |largest, point| largest.max(point.distance_squared(centre)));
        // Enlarge by some ulp of the largest coordinate, against rounding.
        let largest = self.bounds.min.abs().max(self.bounds.max.abs()).max_element();
        let radius = square.sqrt() * (1.0 + 1e-6) + 4.0 * f32::EPSILON * largest;
        CutSphere { instance: self.instance, is_wall: self.is_wall, centre, radius }
    }

    /// Bin of a piece's centre along an axis.
    fn bin(&self, axis: usize, piece: &Piece) -> usize {
        let share = (piece.middle()[axis] - self.bounds.min[axis]) / self.bounds.diagonal()[axis];
        ((share * BINS as f32) as usize).min(BINS - 1)
    }

    /// Finds the best plane between bins of an axis.
    fn best(&self, axis: usize) -> Option<Split> {
        let mut bins = [Aabb::empty(); BINS];
        for piece in &self.pieces {
            let bin = self.bin(axis, piece);
            bins[bin] = union(bins[bin], piece.points());
        }
        let join = |bins: &[Aabb]| bins.iter().fold(Aabb::empty(), |all, bin| all.union(bin));
        let split = |bin| {
            let (below, above) = (join(&bins[..bin]), join(&bins[bin..]));
            (below.valid() && above.valid()).then(|| {
                let gain = cost(&self.bounds) - cost(&below) - cost(&above);
                Split { gain, axis, bin }
            })
        };
        let splits = (1..BINS).filter_map(split).filter(|split| split.gain > WORTH * cost(&self.bounds));
        splits.max_by(|a, b| a.gain.total_cmp(&b.gain))
    }

    fn halves(self, split: Split) -> Vec<Part> {
        let (below, above): (Vec<_>, Vec<_>) =
            self.pieces.iter().partition(|piece| self.bin(split.axis, piece) < split.bin);
        [below, above]
            .into_par_iter()
            .filter_map(|pieces| Part::new(self.instance, self.is_wall, pieces))
            .collect()
    }
}

/// Upper bound of the factor by which a transform lengthens vectors: root of the largest row sum of the Gram matrix of its axes.
/// The bound is exact for axes that stay orthogonal.
fn stretch(transform: &Transform) -> f32 {
    let axes = [transform.x, transform.y, transform.z];
    let row = |axis: Vec3| axes.iter().map(|other| axis.dot(*other).abs()).sum::<f32>();
    axes.into_iter().map(row).fold(0.0, f32::max).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resolve;

    fn committed(name: &str) -> Scene {
        Scene::load(&resolve(name).unwrap()).unwrap()
    }

    /// Every corner of a caster lies in a sphere, at every pose, and no single sphere covers everything.
    #[test]
    fn caster_spheres_hold_every_caster_at_every_pose() {
        for name in ["ring", "mirror-room", "textured-room", "moving-receiver", "moving-caster"] {
            let mut scene = committed(name);
            for time in [0.0, 0.7] {
                scene.pose(time).unwrap();
                let Casters { spheres, count } = scene.casters(0.25, true);
                let casters = &spheres[..count as usize];
                let mut seen = 0;
                let instance_triangles =
                    |instance| scene.instanced.triangle_ids(instance).map(move |id| (instance, id));
                for (instance, id) in (0..scene.instances.len()).flat_map(instance_triangles) {
                    let material = scene.surfaces[id].material as usize;
                    if scene.features_of(material, 0.25).has(Features::CASTERS) {
                        let triangle = scene.world_triangle(instance as u32, id as u32);
                        let corners = [triangle.a, triangle.b, triangle.c];
                        let holds = |c: &Caster| corners.iter().all(|p| p.distance(c.centre) <= c.radius);
                        assert!(casters.iter().any(holds), "{name} at {time}");
                        seen += 1;
                    }
                }
                println!("{name} at {time}: {seen} triangles in {casters:?}");
                assert!(seen > 0);
            }
        }
    }

    #[test]
    fn specular_roughness_decides_the_caster_spheres() {
        let scene = committed("glossy-room");
        assert_ne!(scene.casters(0.05, true), scene.casters(0.6, true));
        assert_eq!(scene.casters(0.25, true), scene.clone().casters(0.25, true));
    }

    #[test]
    fn transforms_never_lengthen_vectors_beyond_the_stretch() {
        let turned = Transform {
            x: Vec3::new(0.0, 2.0, 0.0),
            y: Vec3::new(-3.0, 0.0, 0.0),
            z: Vec3::Z,
            offset: Vec3::ONE,
        };
        assert_eq!(stretch(&turned), 3.0);
        let sheared = Transform { y: Vec3::new(0.9, 1.0, 0.0), ..Transform::IDENTITY };
        for step in 0..100 {
            let (sin, cos) = (step as f32 * 0.0628).sin_cos();
            assert!(sheared.vector(Vec3::new(cos, sin, 0.0)).length() <= stretch(&sheared));
        }
    }
}
