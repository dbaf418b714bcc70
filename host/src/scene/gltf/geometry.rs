//! The triangles of a file: those that stand still, in the world, and the meshes that move.

use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::{DAffine3, DVec3};

use super::document::Document;
use super::node::Placed;
use super::texture::Mapping;
use super::{huge, mesh};
use crate::scene::corner::Corner;
use crate::scene::moving::MovingMesh;
use crate::scene::texture::CornerCoordinates;
use crate::scene::{SceneError, geometry};

/// Triangles of a file.
pub struct Geometry {
    /// Corners of the triangles that stand still, in the world in f64 (m).
    corners: Vec<[Corner; 3]>,
    /// Their materials.
    materials: Vec<usize>,
    /// Meshes that move.
    pub moving: Vec<MovingMesh>,
    /// Triangles without an area that those meshes lost.
    pub dropped: usize,
}

impl Geometry {
    /// Reads every mesh that is placed; at most `count` triangles.
    pub fn read(
        document: &mut Document,
        placed: &Placed,
        mappings: &[Option<Mapping>],
        count: usize,
    ) -> Result<Geometry, SceneError> {
        let mut corners: Vec<[Corner; 3]> = Vec::new();
        if !placed.meshes.iter().any(|mesh| mesh.moves) {
            corners.reserve_exact(count);
        }
        let (mut materials, mut moving, mut dropped) = (Vec::new(), Vec::new(), 0);
        for instance in &placed.meshes {
            let (mut own, mut own_materials) = (Vec::new(), Vec::new());
            for mesh::Part { material, triangles } in mesh::read(document, instance, mappings)? {
                if instance.moves {
                    own_materials.resize(own_materials.len() + triangles.len(), material as u32);
                    own.extend(triangles);
                } else {
                    materials.resize(materials.len() + triangles.len(), material);
                    corners.extend(triangles);
                }
            }
            let (mesh, lost) = MovingMesh::new(instance.joint, own, own_materials);
            dropped += lost;
            if !mesh.corners.is_empty() {
                moving.push(mesh);
            }
        }
        Ok(Geometry { corners, materials, moving, dropped })
    }

    /// Whether there is no triangle, not even one without an area.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty() && self.moving.is_empty() && self.dropped == 0
    }

    /// The scene's origin (m), so that f32 is finest where the scene is: the centre of its bounds, or of what is small
    /// beside huge triangles, which are split.
    pub fn centre(&mut self, places: &[DAffine3]) -> DVec3 {
        let still = self.corners.iter().flatten().map(|corner| corner.position);
        let all = still.chain(self.moving.iter().flat_map(|mesh| mesh.world(&places[mesh.joint])));
        let all: Vec<DVec3> = all.collect();
        let details = huge::details(all.as_chunks().0.iter().copied());
        let (lower, upper) =
            all.iter().fold((DVec3::MAX, DVec3::MIN), |(lower, upper), &p| (lower.min(p), upper.max(p)));
        huge::split(&details, &mut self.corners, &mut self.materials);
        match details.first() {
            Some(smallest) => smallest.centre,
            None if all.is_empty() => DVec3::ZERO,
            None => 0.5 * (lower + upper),
        }
    }

    /// Rows of the triangles that stand still, around an origin (m).
    pub fn rows(&self, origin: DVec3) -> (Vec<Triangle>, Vec<TriangleSurface>) {
        let local = |corner: &Corner| (corner.position - origin).as_vec3();
        let row = |([a, b, c], &material): (&[Corner; 3], &usize)| {
            let triangle = Triangle { a: local(a), b: local(b), c: local(c) };
            let face = geometry::face_normal(&triangle);
            let normal = |corner: &Corner| corner.normal.unwrap_or(face);
            let surface = TriangleSurface {
                normal_a: normal(a),
                normal_b: normal(b),
                normal_c: normal(c),
                material: material as u32,
                ..TriangleSurface::default()
            };
            (triangle, surface)
        };
        self.corners.iter().zip(&self.materials).map(row).unzip()
    }

    /// Where the corners of the triangles that stand still lie on textures.
    pub fn coordinates(&self) -> Vec<CornerCoordinates> {
        let row = |corners: &[Corner; 3]| {
            let [a, b, c] = corners.map(|corner| corner.tangent);
            let tangents = a.zip(b).zip(c).map(|((a, b), c)| [a, b, c]);
            CornerCoordinates { uv: corners.map(|corner| corner.uv), tangents }
        };
        self.corners.iter().map(row).collect()
    }
}
