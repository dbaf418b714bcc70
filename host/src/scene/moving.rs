//! A mesh that moves: its triangles in its own space, and the rows that they make of a pose.

use caustics_kernels::interface::instance::Instance;
use caustics_kernels::interface::texture::TextureCoordinates;
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::{DAffine3, DVec3};

use super::gltf::mesh::{Corner, placed, turned};
use super::texture::{self, CornerCoordinates};
use super::tree::Tree;
use super::{Scene, geometry, tree};

/// A mesh that moves.
#[derive(Clone, Debug)]
pub struct MovingMesh {
    /// Its node.
    pub joint: usize,
    /// Corners of its triangles in the node's space (m), in the order of the mesh's tree.
    pub corners: Vec<[Corner; 3]>,
    /// Their materials.
    pub materials: Vec<u32>,
    /// Centre of their bounds (m): the origin of the mesh's own space.
    pub centre: DVec3,
    /// Id of its first triangle.
    pub first: u32,
    /// Bounds in the node's space (m).
    bounds: [DVec3; 2],
    /// Which triangles are flat: their normals are the face's.
    flat: Vec<bool>,
    /// Its blocks in the scene's tree.
    pub blocks: std::ops::Range<usize>,
    /// Whether corners b and c are exchanged in them.
    is_mirrored: bool,
}

impl MovingMesh {
    /// A mesh on a node, and how many triangles without an area it lost.
    pub fn new(joint: usize, corners: Vec<[Corner; 3]>, materials: Vec<u32>) -> (MovingMesh, usize) {
        let all = || corners.iter().flatten().map(|corner| corner.position);
        let bounds = all().fold((DVec3::MAX, DVec3::MIN), |(lower, upper), p| (lower.min(p), upper.max(p)));
        let centre = if corners.is_empty() { DVec3::ZERO } else { 0.5 * (bounds.0 + bounds.1) };
        let mut mesh = MovingMesh {
            joint,
            corners,
            materials,
            centre,
            first: 0,
            bounds: bounds.into(),
            flat: Vec::new(),
            blocks: 0..0,
            is_mirrored: false,
        };
        let keep: Vec<bool> = mesh.own_triangles().iter().map(geometry::has_area).collect();
        let dropped = keep.iter().filter(|keep| !**keep).count();
        geometry::retain(&mut mesh.corners, &keep);
        geometry::retain(&mut mesh.materials, &keep);
        (mesh, dropped)
    }

    /// Its triangles in its own space.
    pub fn own_triangles(&self) -> Vec<Triangle> {
        let own = |corner: Corner| (corner.position - self.centre).as_vec3();
        self.corners.iter().map(|&[a, b, c]| Triangle { a: own(a), b: own(b), c: own(c) }).collect()
    }

    /// Appends its tree, and rows that a pose will fill; `levels` is how deep the tree may be.
    pub fn append(&mut self, scene: &mut Scene, instance: u32, levels: u32) {
        let own = self.own_triangles();
        let Tree { nodes, mut blocks, order } = tree::build_within(&own, levels);
        self.first = scene.triangles.len() as u32;
        self.corners = order.iter().map(|&id| self.corners[id as usize]).collect();
        self.materials = order.iter().map(|&id| self.materials[id as usize]).collect();
        let own: Vec<_> = order.iter().map(|&id| own[id as usize]).collect();
        self.flat = own
            .iter()
            .zip(&self.corners)
            .map(|(triangle, corners)| {
                let face = geometry::face_normal(triangle);
                corners.iter().all(|c| c.normal.is_none_or(|normal| (normal - face).length() <= 1e-6))
            })
            .collect();

        for block in &mut blocks {
            block.first += self.first;
        }
        let (root, first_block) = (scene.nodes.len() as u32, scene.blocks.len());
        tree::append(scene, nodes, blocks);
        self.blocks = first_block..scene.blocks.len();
        scene.triangles.extend(&own);
        scene.surfaces.extend(self.materials.iter().map(|&material| TriangleSurface {
            material,
            instance,
            light: caustics_kernels::interface::NONE,
            ..TriangleSurface::default()
        }));
        scene.object_triangles.extend(&own);
        scene.instances.push(Instance { root, ..Instance::default() });
    }

    /// Whether no coordinate of a pose is too large.
    pub fn fits(&self, to_world: &DAffine3, origin: DVec3) -> bool {
        let [lower, upper] = self.bounds;
        (0..8).all(|corner| {
            let pick = |bit: u32, low: f64, high: f64| if corner & bit == 0 { low } else { high };
            let p =
                DVec3::new(pick(1, lower.x, upper.x), pick(2, lower.y, upper.y), pick(4, lower.z, upper.z));
            let p = to_world.transform_point3(p) - origin;
            p.is_finite() && p.abs().max_element() <= geometry::MAX_COORDINATE
        })
    }

    /// Its bounds in the world at a place (m): of its corners.
    pub fn world(&self, to_world: &DAffine3) -> impl Iterator<Item = DVec3> + '_ {
        let to_world = *to_world;
        self.corners.iter().flatten().map(move |corner| to_world.transform_point3(corner.position))
    }

    /// Exchanges corners b and c of its own triangles where the world's are: a mirror turns the front over.
    pub fn mirror(&mut self, scene: &mut Scene, still: usize, mirrored: bool) {
        if std::mem::replace(&mut self.is_mirrored, mirrored) == mirrored {
            return;
        }
        for block in &mut scene.blocks[self.blocks.clone()] {
            std::mem::swap(&mut block.b_x, &mut block.c_x);
            std::mem::swap(&mut block.b_y, &mut block.c_y);
            std::mem::swap(&mut block.b_z, &mut block.c_z);
        }
        let first = self.first as usize - still;
        for triangle in &mut scene.object_triangles[first..first + self.corners.len()] {
            std::mem::swap(&mut triangle.b, &mut triangle.c);
        }
    }

    /// Writes the rows of its triangles. A hidden mesh is a point in the middle of where it would be.
    pub fn pose(&self, scene: &mut Scene, to_world: &DAffine3, is_hidden: bool) {
        let origin = scene.origin;
        let turn = to_world.matrix3.inverse().transpose();
        let middle = (to_world.transform_point3(self.centre) - origin).as_vec3();
        for (index, corners) in self.corners.iter().enumerate() {
            let id = self.first as usize + index;
            let surface = &mut scene.surfaces[id];
            if is_hidden {
                scene.triangles[id] = Triangle { a: middle, b: middle, c: middle };
                (surface.normal_a, surface.normal_b, surface.normal_c) = Default::default();
                surface.curvature = 0.0;
                if let Some(row) = scene.textures.coordinates.get_mut(id) {
                    let [uv_a, uv_b, uv_c] = corners.map(|corner| corner.uv);
                    *row = TextureCoordinates { uv_a, uv_b, uv_c, ..TextureCoordinates::default() };
                }
                continue;
            }
            let [a, mut b, mut c] = *corners;
            if self.is_mirrored {
                std::mem::swap(&mut b, &mut c);
            }
            let place = |corner: Corner| (to_world.transform_point3(corner.position) - origin).as_vec3();
            let triangle = Triangle { a: place(a), b: place(b), c: place(c) };
            if !self.flat[index] {
                let face = geometry::face_normal(&triangle);
                let normal = |corner: Corner| {
                    let turned = corner.normal.map(|normal| turned(&turn, normal.to_array()));
                    turned.and_then(Result::ok).flatten().unwrap_or(face)
                };
                (surface.normal_a, surface.normal_b, surface.normal_c) = (normal(a), normal(b), normal(c));
                let curvature = geometry::curvature(&triangle, surface);
                surface.curvature = if curvature.is_finite() { curvature } else { 0.0 };
            }
            scene.triangles[id] = triangle;
            if let Some(row) = scene.textures.coordinates.get_mut(id) {
                let tangent =
                    |corner: Corner| corner.tangent.and_then(|tangent| placed(to_world, tangent.to_array()));
                let tangents = tangent(a).zip(tangent(b)).zip(tangent(c)).map(|((a, b), c)| [a, b, c]);
                *row = texture::row(&triangle, &CornerCoordinates { uv: [a.uv, b.uv, c.uv], tangents });
                row.density = if row.density.is_finite() { row.density } else { 0.0 };
            }
        }
    }

    /// Texture coordinates in its own space, for checks.
    pub fn coordinates(&self) -> impl Iterator<Item = CornerCoordinates> + '_ {
        let row = |corners: &[Corner; 3]| CornerCoordinates { uv: corners.map(|c| c.uv), tangents: None };
        self.corners.iter().map(row)
    }
}
