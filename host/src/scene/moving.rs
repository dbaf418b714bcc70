//! A mesh that moves: its triangles in its own space.

use caustics_kernels::interface::triangle::Triangle;
use glam::{DAffine3, DVec3};

use super::corner::Corner;
use super::geometry;
use super::texture::CornerCoordinates;

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
    pub(super) flat: Vec<bool>,
    /// Its blocks in the scene's tree.
    pub blocks: std::ops::Range<usize>,
    /// Whether corners b and c are exchanged in them.
    pub(super) is_mirrored: bool,
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

    /// Its corners in the world at a place (m).
    pub fn world(&self, to_world: &DAffine3) -> impl Iterator<Item = DVec3> + use<'_> {
        let to_world = *to_world;
        self.corners.iter().flatten().map(move |corner| to_world.transform_point3(corner.position))
    }

    /// Texture coordinates in its own space, for checks.
    pub fn coordinates(&self) -> impl Iterator<Item = CornerCoordinates> + '_ {
        let row = |corners: &[Corner; 3]| CornerCoordinates { uv: corners.map(|c| c.uv), tangents: None };
        self.corners.iter().map(row)
    }
}
