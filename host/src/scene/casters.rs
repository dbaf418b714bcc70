//! Spheres around what casts caustics: a cut of the scene, made once for a threshold of what is specular, whose parts move with
//! the meshes that they are of.

use std::sync::{Arc, Mutex, PoisonError};

use caustics_kernels::interface::caster::{Caster, Casters, MAX_CASTERS};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::instance::Transform;
use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;

use super::Scene;

/// A split must make the surface of the boxes smaller by this share: then there is a gap, or a thing beside another. Halves of
/// a pane or of a ball have no less.
const WORTH: f32 = 0.1;
/// Slices of a box in which planes are looked for.
const BINS: usize = 32;

/// The cuts that a scene was asked for, by their thresholds.
#[derive(Debug, Default)]
pub struct Cuts(Mutex<Vec<(u32, Arc<Cut>)>>);

impl Clone for Cuts {
    fn clone(&self) -> Cuts {
        Cuts(Mutex::new(self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()))
    }
}

/// Spheres in the spaces of the instances that they are of.
#[derive(Debug, Default)]
pub struct Cut(Vec<(usize, Caster)>);

/// Triangles that one sphere holds, of one instance.
struct Part {
    instance: usize,
    corners: Vec<[Vec3; 3]>,
    bounds: Aabb,
    /// The plane that splits it best, if one is worth it.
    split: Option<Split>,
}

#[derive(Clone, Copy)]
struct Split {
    /// By how much it makes the surface of the boxes smaller (m^2).
    gain: f32,
    axis: usize,
    bin: usize,
}

impl Scene {
    /// Spheres around what casts caustics where reflections up to `specular_roughness` are specular, at the pose at hand; those
    /// of a mesh that is hidden have no radius.
    pub fn casters(&self, specular_roughness: f32) -> Casters {
        let cut = {
            let mut cuts = self.casters.0.lock().unwrap_or_else(PoisonError::into_inner);
            let known = cuts.iter().find(|(bits, _)| *bits == specular_roughness.to_bits());
            match known {
                Some((_, cut)) => cut.clone(),
                None => {
                    let cut = Arc::new(Cut::of(self, specular_roughness));
                    cuts.push((specular_roughness.to_bits(), cut.clone()));
                    cut
                }
            }
        };
        let mut casters = Casters { count: cut.0.len() as u32, ..Casters::default() };
        for (place, &(instance, sphere)) in casters.spheres.iter_mut().zip(&cut.0) {
            *place = self.posed(instance, sphere);
        }
        casters
    }

    /// A sphere of an instance in the world.
    fn posed(&self, instance: usize, sphere: Caster) -> Caster {
        let Some(id) = instance.checked_sub(1) else { return sphere };
        let placement = self.motion.as_ref().and_then(|motion| motion.placements[id].to_world);
        let Some(to_world) = placement else { return Caster::default() };
        let radius = sphere.radius * stretch(&to_world) * (1.0 + 1e-6);
        Caster { centre: to_world.point(sphere.centre), radius }
    }
}

impl Cut {
    fn of(scene: &Scene, specular_roughness: f32) -> Cut {
        let casts: Vec<bool> = (0..scene.materials.len())
            .map(|id| scene.features_of(id, specular_roughness).has(Features::CASTERS))
            .collect();
        let still = scene.motion.as_ref().map_or(scene.triangles.len(), |motion| motion.still);
        let is_caster = |surface: usize| casts[scene.surfaces[surface].material as usize];
        let corners = |triangle: usize| {
            let triangle = match triangle.checked_sub(still) {
                Some(row) => &scene.object_triangles[row],
                None => &scene.triangles[triangle],
            };
            [triangle.a, triangle.b, triangle.c]
        };
        let part = |instance, triangles: std::ops::Range<usize>| {
            Part::new(instance, triangles.filter(|&id| is_caster(id)).map(corners).collect())
        };
        let meshes = scene.motion.iter().flat_map(|motion| &motion.placements).enumerate();
        let moving = meshes
            .map(|(id, place)| part(id + 1, place.first as usize..(place.first + place.count) as usize));
        let mut parts: Vec<Part> = std::iter::once(part(0, 0..still)).chain(moving).flatten().collect();
        // Of more moving meshes than there are spheres, the largest are aimed at.
        parts.sort_by(|a, b| cost(&b.bounds).total_cmp(&cost(&a.bounds)).then(a.instance.cmp(&b.instance)));
        parts.truncate(MAX_CASTERS);
        while parts.len() < MAX_CASTERS {
            let splits = parts.iter().enumerate().filter_map(|(id, part)| Some((id, part.split?)));
            let best = splits.max_by(|a, b| a.1.gain.total_cmp(&b.1.gain).then(b.0.cmp(&a.0)));
            let Some((id, split)) = best else { break };
            let halves = parts.swap_remove(id).halves(split);
            parts.extend(halves);
        }
        Cut(parts.iter().map(|part| (part.instance, part.sphere())).collect())
    }
}

/// Half of the surface of a box (m^2).
fn cost(bounds: &Aabb) -> f32 {
    let size = bounds.diagonal();
    size.x * size.y + size.y * size.z + size.z * size.x
}

fn middle(corners: &[Vec3; 3]) -> Vec3 {
    (corners[0] + corners[1] + corners[2]) / 3.0
}

fn union(bounds: Aabb, points: impl IntoIterator<Item = Vec3>) -> Aabb {
    points.into_iter().fold(bounds, |all, point| all.union(&Aabb::from_point(Vec3A::from(point))))
}

impl Part {
    /// None of no triangles.
    fn new(instance: usize, corners: Vec<[Vec3; 3]>) -> Option<Part> {
        let bounds = union(Aabb::empty(), corners.iter().flatten().copied());
        let mut part = Part { instance, corners, bounds, split: None };
        part.split = (0..3).filter_map(|axis| part.best(axis)).max_by(|a, b| a.gain.total_cmp(&b.gain));
        (!part.corners.is_empty()).then_some(part)
    }

    /// The sphere in the middle of its box.
    fn sphere(&self) -> Caster {
        let centre = Vec3::from(self.bounds.center());
        let points = self.corners.iter().flatten();
        let square = points.fold(0.0f32, |most, point| most.max(point.distance_squared(centre)));
        // Some ulp of the largest coordinate more, for what rounding takes.
        let most = self.bounds.min.abs().max(self.bounds.max.abs()).max_element();
        Caster { centre, radius: square.sqrt() * (1.0 + 1e-6) + 4.0 * f32::EPSILON * most }
    }

    /// Which bin along an axis the middle of a triangle is in.
    fn bin(&self, axis: usize, corners: &[Vec3; 3]) -> usize {
        let share = (middle(corners)[axis] - self.bounds.min[axis]) / self.bounds.diagonal()[axis];
        ((share * BINS as f32) as usize).min(BINS - 1)
    }

    /// The best plane between bins of an axis.
    fn best(&self, axis: usize) -> Option<Split> {
        let mut bins = [Aabb::empty(); BINS];
        for corners in &self.corners {
            let bin = self.bin(axis, corners);
            bins[bin] = union(bins[bin], *corners);
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

    fn halves(self, split: Split) -> impl Iterator<Item = Part> {
        let (below, above): (Vec<_>, Vec<_>) =
            self.corners.iter().partition(|corners| self.bin(split.axis, corners) < split.bin);
        [below, above].into_iter().filter_map(move |corners| Part::new(self.instance, corners))
    }
}

/// By how much a transform makes lengths longer, at most: the root of the largest sum of a row of its square, which is exact for
/// axes that stay orthogonal.
fn stretch(transform: &Transform) -> f32 {
    let axes = [transform.x, transform.y, transform.z];
    let row = |axis: Vec3| axes.iter().map(|other| axis.dot(*other).abs()).sum::<f32>();
    axes.into_iter().map(row).fold(0.0, f32::max).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;

    fn committed(name: &str) -> Scene {
        Scene::load(&scene::resolve(name).unwrap()).unwrap()
    }

    /// Every corner of what casts lies in a sphere, at every pose, and there is not one sphere round everything.
    #[test]
    fn spheres_hold_what_casts_wherever_it_moves() {
        for name in ["ring", "mirror-room", "textured-room", "moving-receiver", "moving-caster"] {
            let mut scene = committed(name);
            for time in [0.0, 0.7] {
                scene.pose(time).unwrap();
                let Casters { spheres, count } = scene.casters(0.25);
                let casters = &spheres[..count as usize];
                let mut seen = 0;
                for (triangle, surface) in scene.triangles.iter().zip(&scene.surfaces) {
                    if scene.features_of(surface.material as usize, 0.25).has(Features::CASTERS) {
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
    fn what_is_specular_decides_what_casts() {
        let scene = committed("glossy-room");
        assert_ne!(scene.casters(0.05), scene.casters(0.6));
        assert_eq!(scene.casters(0.25), scene.clone().casters(0.25));
    }

    #[test]
    fn lengths_are_never_longer_than_the_stretch() {
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
