//! Triangles of a file: those of the world, and meshes in their own space, which move or are stored once.

use std::collections::HashMap;

use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use super::deformation::{self, DeformedMesh};
use super::node::{WorldMesh, WorldNodes};
use super::sharing::Sharing;
use super::texture::Mapping;
use super::{huge, mesh};
use crate::animation::Nodes;
use crate::corner::Corner;
use crate::gltf::context::ImportContext;
use crate::gltf::decoding::model::Model;
use crate::instanced::{Instanced, MeshInstance, Stand};
use crate::mesh::{Mesh, coordinates};
use crate::texture::CornerCoordinates;
use crate::{SceneError, geometry};

/// Properties of a world triangle besides its corners.
#[derive(Clone, Copy)]
struct Detail {
    material: u32,
    /// Index of its node.
    owner: u32,
}

/// Triangles of a file.
#[derive(Default)]
pub struct Geometry {
    /// Corners of the triangles of the world, in f64 (m).
    corners: Vec<[Corner; 3]>,
    /// Other properties of these triangles.
    details: Vec<Detail>,
    /// Meshes in their own space, and their instances.
    pub instanced: Instanced,
    /// Number of triangles without an area that these meshes lost.
    pub dropped: usize,
}

impl Geometry {
    /// Reads the meshes of all instances. A mesh that is stored once is read once.
    pub fn read(
        model: &Model,
        context: &mut ImportContext<'_>,
        world: &WorldNodes,
        mappings: &[Option<Mapping>],
        sharing: &Sharing,
    ) -> Result<Geometry, SceneError> {
        let mut geometry = Geometry::default();
        geometry.corners.reserve_exact(sharing.in_world);
        // Stored meshes by their index in the file; `None` for a mesh without triangles.
        let mut stored: HashMap<usize, Option<usize>> = HashMap::new();
        for instance in &world.meshes {
            if let Some(deformed) = deformation::read(model, context, world, instance, mappings)? {
                geometry.add_deformed(deformed, world, instance);
                continue;
            }
            let shares = sharing.is_stored_once(instance);
            if !shares && !instance.moves {
                geometry.bake(mesh::read(model, context, instance, mappings)?, instance.joint);
                continue;
            }
            let id = instance.mesh.value();
            let known = stored.get(&id).copied().filter(|_| shares);
            let mesh = match known {
                Some(mesh) => mesh,
                None => {
                    let own = WorldMesh { to_world: DAffine3::IDENTITY, ..instance.clone() };
                    let parts = mesh::read(model, context, &own, mappings)?;
                    let mesh = geometry.store(parts.into_iter().filter(|part| !(shares && part.emits)));
                    if shares {
                        stored.insert(id, mesh);
                    }
                    mesh
                }
            };
            if shares && sharing.emits(instance) {
                let parts = mesh::read(model, context, instance, mappings)?;
                geometry.bake(parts.into_iter().filter(|part| part.emits), instance.joint);
            }
            let stand =
                if instance.moves { Stand::Node(instance.joint) } else { Stand::Still(instance.to_world) };
            let owner = instance.joint;
            geometry.instanced.instances.extend(mesh.map(|mesh| MeshInstance { mesh, owner, stand }));
        }
        Ok(geometry)
    }

    /// Adds triangles of a node to the world.
    fn bake(&mut self, parts: impl IntoIterator<Item = mesh::MeshPrimitive>, owner: usize) {
        for mesh::MeshPrimitive { material, triangles, .. } in parts {
            let detail = Detail { material: material as u32, owner: owner as u32 };
            self.details.resize(self.details.len() + triangles.len(), detail);
            self.corners.extend(triangles);
        }
    }

    /// Adds a deformed mesh. It is deformed at every pose, becomes triangles of the world, or a mesh on its node.
    fn add_deformed(&mut self, deformed: DeformedMesh, world: &WorldNodes, instance: &WorldMesh) {
        let DeformedMesh { deformation, materials, moves } = deformed;
        let is_skinned = deformation.is_skinned();
        let stand = match (is_skinned, instance.moves) {
            (true, _) => Stand::Still(DAffine3::IDENTITY),
            (false, true) => Stand::Node(instance.joint),
            (false, false) => Stand::Still(instance.to_world),
        };
        let mesh = if moves {
            Mesh::deforming(deformation, materials, &world.nodes)
        } else {
            let vertices = deformation.deform(&world.nodes);
            let corners = deformation.corners(&vertices);
            if let Stand::Still(to_world) = stand {
                self.bake_placed(corners, &materials, &to_world, instance.joint);
                return;
            }
            let (mesh, lost) = Mesh::new(corners.collect(), materials);
            self.dropped += lost;
            mesh
        };
        if mesh.count > 0 {
            let (id, owner) = (self.instanced.meshes.len(), instance.joint);
            self.instanced.instances.push(MeshInstance { mesh: id, owner, stand });
            self.instanced.meshes.push(mesh);
        }
    }

    /// Transforms triangles of a node's space to the world.
    fn bake_placed(
        &mut self,
        corners: impl Iterator<Item = [Corner; 3]>,
        materials: &[u32],
        to_world: &DAffine3,
        owner: usize,
    ) {
        let is_mirrored = to_world.matrix3.determinant() < 0.0;
        let turn = to_world.matrix3.inverse().transpose();
        let placed = |corners: [Corner; 3]| {
            mesh::turned_over(corners.map(|corner| corner.placed(to_world, &turn)), is_mirrored)
        };
        self.corners.extend(corners.map(placed));
        let owner = owner as u32;
        self.details.extend(materials.iter().map(|&material| Detail { material, owner }));
    }

    /// Stores a mesh of triangles in its node's space and returns its index; `None` without triangles.
    fn store(&mut self, parts: impl Iterator<Item = mesh::MeshPrimitive>) -> Option<usize> {
        let (mut own, mut materials) = (Vec::new(), Vec::new());
        for mesh::MeshPrimitive { material, triangles, .. } in parts {
            materials.resize(materials.len() + triangles.len(), material as u32);
            own.extend(triangles);
        }
        let (mesh, lost) = Mesh::new(own, materials);
        self.dropped += lost;
        (mesh.count > 0).then(|| {
            self.instanced.meshes.push(mesh);
            self.instanced.meshes.len() - 1
        })
    }

    /// Whether the file has no triangle, with or without an area.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty() && self.instanced.meshes.is_empty() && self.dropped == 0
    }

    /// Returns the origin of the scene (m), chosen so that f32 is finest at the scene. It is the centre of the bounds, or of the
    /// small objects beside huge triangles. Splits huge triangles.
    pub fn centre(&mut self, nodes: &Nodes) -> DVec3 {
        let world = self.corners.iter().map(|corners| corners.map(|corner| corner.position));
        let all = || world.clone().chain(self.instanced.triangles(nodes));
        let details = huge::details(all());
        let [lower, upper] = geometry::box_around(all().flatten());
        huge::split(&details, &mut self.corners, &mut self.details);
        match details.first() {
            Some(smallest) => smallest.centre,
            None if lower == DVec3::MAX => DVec3::ZERO,
            None => 0.5 * (lower + upper),
        }
    }

    /// Records of the world's triangles, relative to an origin (m).
    pub fn triangle_records(&self, origin: DVec3) -> (Vec<Triangle>, Vec<TriangleSurface>) {
        let local = |corner: &Corner| (corner.position - origin).as_vec3();
        let record = |([a, b, c], &Detail { material, .. }): (&[Corner; 3], &Detail)| {
            let triangle = Triangle { a: local(a), b: local(b), c: local(c) };
            let face = geometry::face_normal(&triangle);
            let normal = |corner: &Corner| corner.normal.unwrap_or(face);
            let surface = TriangleSurface {
                normal_a: normal(a),
                normal_b: normal(b),
                normal_c: normal(c),
                material,
                ..TriangleSurface::default()
            };
            (triangle, surface)
        };
        self.corners.par_iter().zip(&self.details).map(record).unzip()
    }

    /// Returns the meshes in their own space.
    pub fn into_instanced(self) -> Instanced {
        self.instanced
    }

    /// Nodes of the triangles of the world.
    pub fn owners(&self) -> impl Iterator<Item = u32> + '_ {
        self.details.iter().map(|detail| detail.owner)
    }

    /// Texture coordinates of the corners of the triangles of the world.
    pub fn coordinates(&self) -> Vec<CornerCoordinates> {
        self.corners.iter().map(coordinates).collect()
    }
}
