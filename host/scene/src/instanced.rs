//! Instances of meshes: moving meshes, and meshes that are stored once for many nodes.

use std::ops::Range;

use caustics_kernels::interface::bvh::INSTANCE;
use caustics_kernels::interface::instance::{Instance, Transform};
use caustics_kernels::interface::triangle::Triangle;
use glam::{DAffine3, DVec3, Vec3A};
use obvhs::aabb::Aabb;

use super::animation::{Nodes, is_singular};
use super::bvh::BvhOptions;
use super::bvh::top::{self, Leaf};
use super::corner::Corner;
use super::mesh::Mesh;
use super::{Scene, bvh, geometry};

/// Number of triangles of all instances above which boxes represent the meshes, to find the centre of the scene.
const MANY: usize = 1 << 22;

/// Transform source of an instance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stand {
    /// Index of a node; it may move.
    Node(usize),
    /// Fixed transform from the space of the mesh's node to the world.
    Still(DAffine3),
}

/// An instance of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshInstance {
    /// Index of the mesh.
    pub mesh: usize,
    /// Index of the node that owns the instance, for a fixed transform too.
    pub owner: usize,
    /// Source of its transform.
    pub stand: Stand,
}

impl MeshInstance {
    /// Transform from the space of the mesh's node to the world, for a pose of the nodes. A node without a transform uses the
    /// identity.
    pub fn world_transform(&self, nodes: &Nodes) -> DAffine3 {
        match self.stand {
            Stand::Node(node) => nodes.to_world.get(node).copied().unwrap_or_default(),
            Stand::Still(to_world) => to_world,
        }
    }

    /// Index of its node; `None` for a fixed transform.
    pub fn node(&self) -> Option<usize> {
        match self.stand {
            Stand::Node(node) => Some(node),
            Stand::Still(_) => None,
        }
    }
}

/// Transform of an instance, for acceleration structures over the mesh's own triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstanceTransform {
    /// Index of the mesh.
    pub mesh: usize,
    /// Transform from the mesh's own space to the world; `None` while a scale of zero hides the instance.
    pub to_world: Option<Transform>,
}

/// Meshes in their own space, and their instances. In a scene's table of instances they follow the world.
#[derive(Clone, Debug, Default)]
pub struct Instanced {
    /// Meshes.
    pub meshes: Vec<Mesh>,
    /// Instances. An emissive mesh has one.
    pub instances: Vec<MeshInstance>,
    /// Number of triangles of the world; they come first.
    pub still: usize,
    /// Number of nodes of the BVH's top level, which come first; 0 without instances.
    pub top: usize,
    /// Box of the triangles of the world (m).
    still_bounds: Option<Aabb>,
    /// Transform from each mesh's own space to the world, at the current pose; `None` before the first pose.
    to_world: Vec<Option<DAffine3>>,
    /// Transforms of all instances, at the current pose.
    instance_transforms: Vec<InstanceTransform>,
}

impl Instanced {
    /// No instances, beside this number of world triangles.
    pub fn for_world(still: usize) -> Instanced {
        Instanced { still, ..Instanced::default() }
    }

    /// Number of triangles of all meshes, each counted once.
    pub fn triangle_count(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.count as usize).sum()
    }

    /// Number of instances of each mesh.
    pub fn uses(&self) -> Vec<usize> {
        let mut uses = vec![0; self.meshes.len()];
        self.instances.iter().for_each(|instance| uses[instance.mesh] += 1);
        uses
    }

    /// Triangles of all visible instances for a pose of the nodes (m), before records are made of the meshes. Above `MANY`
    /// triangles, diagonal triangles of boxes represent them.
    pub fn triangles<'a>(&'a self, nodes: &'a Nodes) -> impl Iterator<Item = [DVec3; 3]> + 'a {
        let all =
            self.instances.iter().map(|instance| self.meshes[instance.mesh].count as usize).sum::<usize>();
        let shown = self.instances.iter().map(|instance| (instance, instance.world_transform(nodes)));
        let shown = shown.filter(|(_, to_world)| !is_singular(to_world));
        shown.flat_map(move |(instance, to_world)| {
            let mesh = &self.meshes[instance.mesh];
            if all > MANY { mesh.across(to_world) } else { mesh.triangles_at(nodes, to_world) }
        })
    }

    /// Vertices of all deforming meshes for a pose of the nodes, by the index of the mesh.
    pub(super) fn deform(&self, nodes: &Nodes) -> Vec<(usize, Vec<Corner>)> {
        let deformed = |(id, mesh): (usize, &Mesh)| Some((id, mesh.deformation.as_ref()?.deform(nodes)));
        self.meshes.iter().enumerate().filter_map(deformed).collect()
    }

    /// Transforms of the instances at the current pose, for acceleration structures.
    pub fn instance_transforms(&self) -> &[InstanceTransform] {
        &self.instance_transforms
    }

    /// Ids of an instance's triangles, by the index in the scene's table of instances; index 0 is the world.
    pub fn triangle_ids(&self, instance: usize) -> Range<usize> {
        match instance.checked_sub(1) {
            None => 0..self.still,
            Some(id) => self.meshes[self.instances[id].mesh].triangle_ids(),
        }
    }

    /// Appends the records of all meshes and instances to the tables of a scene. The scene has those of the world, behind `top`
    /// nodes. BVHs of meshes may have `levels` levels.
    pub(super) fn append(&mut self, scene: &mut Scene, top: usize, levels: u32, options: &BvhOptions) {
        (self.still, self.top) = (scene.triangles.len(), top);
        self.still_bounds = scene.triangles.iter().map(bvh::bounds).reduce(|all, next| all.union(&next));
        for mesh in &mut self.meshes {
            mesh.append(scene, levels, options);
        }
        scene.instances.extend(self.instances.iter().enumerate().map(|(id, instance)| {
            let mesh = &self.meshes[instance.mesh];
            let moves = instance.node().is_some() || mesh.deformation.is_some();
            let moving = if moves { id as u32 + 1 } else { 0 };
            Instance { root: mesh.nodes.start as u32, first: mesh.first, moving, ..Instance::default() }
        }));
        self.to_world = vec![None; self.instances.len()];
    }

    /// Forgets the current pose, so that the next pose has no previous one.
    pub(super) fn forget(&mut self) {
        self.to_world.fill(None);
    }

    /// Updates a scene's instances and the BVH's top level for a pose of the nodes and the vertices of deforming meshes.
    pub(super) fn set_pose(&mut self, scene: &mut Scene, nodes: &Nodes, deformed: &[(usize, Vec<Corner>)]) {
        if self.instances.is_empty() {
            return;
        }
        for (mesh, vertices) in deformed {
            self.meshes[*mesh].deform(scene, vertices);
        }
        let mut leaves = Vec::with_capacity(self.instances.len() + 1);
        if let Some(bounds) = self.still_bounds {
            leaves.push(Leaf { bounds, child: self.top as u32 });
        }
        self.instance_transforms.clear();
        for (id, instance) in self.instances.iter().enumerate() {
            let mesh = &self.meshes[instance.mesh];
            let to_world = DAffine3::from_translation(-scene.origin) * instance.world_transform(nodes);
            let object_to_world = to_world * DAffine3::from_translation(mesh.centre);
            let before = self.to_world[id].replace(object_to_world);
            let is_hidden = is_hidden(&object_to_world);
            let shown = (!is_hidden).then(|| transform(&object_to_world));
            self.instance_transforms.push(InstanceTransform { mesh: instance.mesh, to_world: shown });
            let record = &mut scene.instances[id + 1];
            let Instance { root, first, moving, .. } = *record;
            *record = Instance { root, first, moving, ..Instance::default() };
            if is_hidden {
                continue;
            }
            let to_object = object_to_world.inverse();
            (record.to_object, record.to_world) = (transform(&to_object), transform(&object_to_world));
            record.to_previous =
                before.map_or(Transform::IDENTITY, |before| transform(&(before * to_object)));
            let was_hidden = before.as_ref().is_some_and(crate::instanced::is_hidden);
            if was_hidden || (mesh.deformation.is_some() && before.is_some()) {
                record.to_previous = Transform::NOWHERE;
            }
            record.orientation = if object_to_world.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
            leaves.push(Leaf { bounds: bounds(mesh, to_world), child: INSTANCE | (id as u32 + 1) });
        }
        top::build(&mut scene.nodes[..self.top], leaves);
    }

    /// Transform of an instance at the current pose, by its record; `None` if it is hidden.
    fn object_to_world(&self, instance: u32) -> Option<DAffine3> {
        match (instance as usize).checked_sub(1) {
            None => Some(DAffine3::IDENTITY),
            Some(id) => self.to_world[id].filter(|object_to_world| !is_hidden(object_to_world)),
        }
    }
}

impl Scene {
    /// Returns a triangle of an instance in the world at the current pose (m), counter-clockwise seen from its front. A triangle
    /// of a hidden instance has no area.
    pub fn world_triangle(&self, instance: u32, triangle: u32) -> Triangle {
        let record = self.triangles[triangle as usize];
        if instance == 0 {
            return record;
        }
        let Some(object_to_world) = self.instanced.object_to_world(instance) else {
            return Triangle::default();
        };
        let [a, b, c] =
            geometry::corners(&record).map(|corner| object_to_world.transform_point3(corner).as_vec3());
        if object_to_world.matrix3.determinant() < 0.0 {
            Triangle { a, b: c, c: b }
        } else {
            Triangle { a, b, c }
        }
    }

    /// Points (m) whose hull contains the scene at the current pose: corners of the world's triangles, and corners of boxes
    /// around parts of instances.
    pub(super) fn hull(&self) -> Vec<DVec3> {
        let Instanced { meshes, instances, still, .. } = &self.instanced;
        let world = self.triangles[..*still].iter().flat_map(geometry::corners);
        let shown = (1..).zip(instances).filter_map(|(instance_id, instance)| {
            let mesh = &meshes[instance.mesh];
            let to_world =
                self.instanced.object_to_world(instance_id)? * DAffine3::from_translation(-mesh.centre);
            Some(mesh.hull(to_world))
        });
        world.chain(shown.flatten()).collect()
    }
}

/// Box around a mesh in the world. It is enlarged by a few ulp of the largest coordinate: the mesh's own space rounds
/// differently.
fn bounds(mesh: &Mesh, to_world: DAffine3) -> Aabb {
    let points = mesh.hull(to_world).map(|p| Vec3A::from(p.as_vec3()));
    let bounds = points.fold(Aabb::empty(), |all, p| all.union(&Aabb::from_point(p)));
    let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
    Aabb { min: bounds.min - largest * 2e-6, max: bounds.max + largest * 2e-6 }
}

/// Whether a scale is zero, or so small that f32 cannot represent the inverse.
fn is_hidden(object_to_world: &DAffine3) -> bool {
    let inverse = object_to_world.inverse();
    let columns = [inverse.x_axis, inverse.y_axis, inverse.z_axis];
    is_singular(object_to_world) || columns.into_iter().any(|axis: DVec3| axis.length() > 1e9)
}

fn transform(object_to_world: &DAffine3) -> Transform {
    Transform {
        x: object_to_world.x_axis.as_vec3(),
        y: object_to_world.y_axis.as_vec3(),
        z: object_to_world.z_axis.as_vec3(),
        offset: object_to_world.translation.as_vec3(),
    }
}
