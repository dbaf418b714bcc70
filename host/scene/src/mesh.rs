//! A mesh in a space of its own, for instances to place.

use std::ops::Range;

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::texture::TextureCoordinates;
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::{DAffine3, DVec3, IVec3};

use super::Scene;
use super::animation::Nodes;
use super::bvh::{self, BvhOptions};
use super::corner::Corner;
use super::deformation::Deformation;
use super::geometry;
use super::texture::{self, CornerCoordinates};

/// Parts of a mesh along an axis that have boxes of their own.
const PARTS: i32 = 4;

/// A mesh with a BVH of its own.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Corners of its triangles in its node's space (m); taken when rows are made of them.
    pub corners: Vec<[Corner; 3]>,
    /// Their materials; taken too.
    pub materials: Vec<u32>,
    /// Centre of their bounds (m): the origin of its own space, in which its rows are.
    pub centre: DVec3,
    /// Boxes around its parts in its node's space (m).
    pub boxes: Vec<[DVec3; 2]>,
    /// Id of its first triangle.
    pub first: u32,
    /// Its triangles.
    pub count: u32,
    /// Its nodes of the BVH; the first is the root.
    pub nodes: Range<usize>,
    /// Its deformation, if it has one.
    pub deformation: Option<Deformation>,
    /// Its blocks of the BVH.
    blocks: Range<usize>,
}

impl Mesh {
    /// A mesh of these triangles, and how many without an area it lost.
    pub fn new(mut corners: Vec<[Corner; 3]>, mut materials: Vec<u32>) -> (Mesh, usize) {
        let centre = middle(&corners);
        let keep: Vec<bool> = own_triangles(&corners, centre).map(|own| geometry::has_area(&own)).collect();
        let dropped = keep.iter().filter(|keep| !**keep).count();
        geometry::retain(&mut corners, &keep);
        geometry::retain(&mut materials, &keep);
        let (boxes, count) = (boxes(&corners), corners.len() as u32);
        (Mesh { corners, materials, centre, boxes, count, ..Mesh::default() }, dropped)
    }

    /// A mesh that is deformed; it stands as it does at time 0. Triangles without an area stay: they may get one.
    pub fn deforming(deformation: Deformation, materials: Vec<u32>, nodes: &Nodes) -> Mesh {
        let vertices = deformation.deform(nodes);
        let corners: Vec<[Corner; 3]> = deformation.corners(&vertices).collect();
        let centre = middle(&corners);
        let (boxes, count) = (boxes(&corners), corners.len() as u32);
        Mesh { corners, materials, centre, boxes, count, deformation: Some(deformation), ..Mesh::default() }
    }

    /// Its triangles in its own space, and their materials, before rows are made of them.
    pub fn own(&self) -> impl Iterator<Item = (Triangle, u32)> + '_ {
        own_triangles(&self.corners, self.centre).zip(self.materials.iter().copied())
    }

    /// Corners of boxes around it, placed (m): eight after eight.
    pub fn hull(&self, to_world: DAffine3) -> impl Iterator<Item = DVec3> + '_ {
        self.corners_of_boxes().map(move |corner| to_world.transform_point3(corner))
    }

    /// Its triangles where nodes are like this, placed (m), before rows are made of it.
    pub fn triangles_at(&self, nodes: &Nodes, to_world: DAffine3) -> Vec<[DVec3; 3]> {
        let deformed = self.deformation.as_ref().map(|deformation| (deformation, deformation.deform(nodes)));
        let transformed =
            |corners: [Corner; 3]| corners.map(|corner| to_world.transform_point3(corner.position));
        match &deformed {
            None => self.corners.iter().copied().map(transformed).collect(),
            Some((deformation, vertices)) => deformation.corners(vertices).map(transformed).collect(),
        }
    }

    /// Triangles across boxes around it, placed (m): all corners of each.
    pub fn across(&self, to_world: DAffine3) -> Vec<[DVec3; 3]> {
        let corners: Vec<DVec3> = self.hull(to_world).collect();
        let of_box = |corners: &[DVec3; 8]| {
            [[0, 7, 1], [0, 7, 2], [4, 3, 5], [4, 3, 6]].map(|ids| ids.map(|id: usize| corners[id]))
        };
        corners.as_chunks().0.iter().flat_map(of_box).collect()
    }

    /// Whether no coordinate is too large where it stands.
    pub fn fits(&self, to_world: &DAffine3, origin: DVec3) -> bool {
        fit(self.corners_of_boxes(), to_world, origin)
    }

    fn corners_of_boxes(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.boxes.iter().flat_map(|&parts| geometry::corners_of_box(parts))
    }

    /// Appends its rows and its BVH, at most `levels` deep, to those of a scene.
    pub fn append(&mut self, scene: &mut Scene, levels: u32, options: &BvhOptions) {
        let (corners, materials) = (std::mem::take(&mut self.corners), std::mem::take(&mut self.materials));
        let own: Vec<Triangle> = own_triangles(&corners, self.centre).collect();
        let mut bvh = bvh::build(&own, levels, options);
        self.first = scene.triangles.len() as u32;
        for block in &mut bvh.blocks {
            block.first += self.first;
        }
        let has_textures = !scene.textures.textures.is_empty();
        let order = std::mem::take(&mut bvh.order);
        for &id in &order {
            let (triangle, corners) = (own[id as usize], &corners[id as usize]);
            scene.surfaces.push(surface(&triangle, corners, materials[id as usize]));
            scene.triangles.push(triangle);
            if has_textures {
                scene.textures.coordinates.push(coordinate_record(&triangle, corners));
            }
        }
        if let Some(deformation) = &mut self.deformation {
            deformation.faces = order.iter().map(|&id| deformation.faces[id as usize]).collect();
        }
        let (node, block) = (scene.nodes.len(), scene.blocks.len());
        bvh.append_to(&mut scene.nodes, &mut scene.blocks);
        (self.nodes, self.blocks) = (node..scene.nodes.len(), block..scene.blocks.len());
    }

    /// Ids of its triangles.
    pub fn triangle_ids(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// Its blocks of the BVH.
    pub fn blocks(&self) -> Range<usize> {
        self.blocks.clone()
    }

    /// Writes its rows for vertices that are deformed, and fits the boxes of its BVH to them.
    pub fn deform(&mut self, scene: &mut Scene, vertices: &[Corner]) {
        let Some(deformation) = &self.deformation else { return };
        let corners: Vec<[Corner; 3]> = deformation.corners(vertices).collect();
        let own = own_triangles(&corners, self.centre);
        for ((id, triangle), corners) in self.triangle_ids().zip(own).zip(&corners) {
            let before = scene.surfaces[id];
            let light = before.light;
            scene.surfaces[id] = TriangleSurface { light, ..surface(&triangle, corners, before.material) };
            scene.triangles[id] = triangle;
            if let Some(record) = scene.textures.coordinates.get_mut(id) {
                *record = coordinate_record(&triangle, corners);
            }
        }
        self.boxes = boxes(&corners);
        bvh::refit(
            &mut scene.nodes,
            self.nodes.clone(),
            &mut scene.blocks,
            self.blocks.clone(),
            &scene.triangles,
        );
    }
}

/// What a triangle has beside its corners.
fn surface(triangle: &Triangle, corners: &[Corner; 3], material: u32) -> TriangleSurface {
    let face = geometry::face_normal(triangle);
    let [normal_a, normal_b, normal_c] = corners.map(|corner| corner.normal.unwrap_or(face));
    let mut surface =
        TriangleSurface { normal_a, normal_b, normal_c, material, light: NONE, ..TriangleSurface::default() };
    geometry::complete(triangle, &mut surface);
    // A triangle without an area is never hit.
    if !surface.curvature.is_finite() {
        surface.curvature = 0.0;
    }
    surface
}

/// Where it lies on textures.
fn coordinate_record(triangle: &Triangle, corners: &[Corner; 3]) -> TextureCoordinates {
    let mut record = texture::record(triangle, &coordinates(corners));
    if !record.density.is_finite() {
        record.density = 0.0;
    }
    record
}

/// Whether no coordinate is too large of points that are placed, around an origin (m).
pub fn fit(mut points: impl Iterator<Item = DVec3>, to_world: &DAffine3, origin: DVec3) -> bool {
    let fits = |p: DVec3| p.is_finite() && p.abs().max_element() <= geometry::MAX_COORDINATE;
    points.all(|p| fits(to_world.transform_point3(p) - origin))
}

/// Where the corners of a triangle lie on textures.
pub fn coordinates(corners: &[Corner; 3]) -> CornerCoordinates {
    let [a, b, c] = corners.map(|corner| corner.tangent);
    let tangents = a.zip(b).zip(c).map(|((a, b), c)| [a, b, c]);
    CornerCoordinates { uv: corners.map(|corner| corner.uv), tangents }
}

/// Triangles around a centre.
fn own_triangles(corners: &[[Corner; 3]], centre: DVec3) -> impl Iterator<Item = Triangle> + '_ {
    let own = move |corner: Corner| (corner.position - centre).as_vec3();
    corners.iter().map(move |&[a, b, c]| Triangle { a: own(a), b: own(b), c: own(c) })
}

fn bounds(corners: &[[Corner; 3]]) -> [DVec3; 2] {
    geometry::box_around(corners.as_flattened().iter().map(|corner| corner.position))
}

/// Middle of the bounds.
fn middle(corners: &[[Corner; 3]]) -> DVec3 {
    let [lower, upper] = bounds(corners);
    if corners.is_empty() { DVec3::ZERO } else { 0.5 * (lower + upper) }
}

/// Boxes around the triangles whose middles lie in each cell of a grid: tighter than one when they are turned.
fn boxes(corners: &[[Corner; 3]]) -> Vec<[DVec3; 2]> {
    let [lower, upper] = bounds(corners);
    let size = (upper - lower).max(DVec3::splat(f64::MIN_POSITIVE));
    let cell = |triangle: &[Corner; 3]| {
        let middle = triangle.iter().map(|corner| corner.position).sum::<DVec3>() / 3.0;
        let cell = ((middle - lower) / size * f64::from(PARTS)).as_ivec3();
        let IVec3 { x, y, z } = cell.clamp(IVec3::ZERO, IVec3::splat(PARTS - 1));
        ((x * PARTS + y) * PARTS + z) as usize
    };
    let mut boxes = vec![[DVec3::MAX, DVec3::MIN]; (PARTS * PARTS * PARTS) as usize];
    for triangle in corners {
        let [lower, upper] = &mut boxes[cell(triangle)];
        for corner in triangle {
            (*lower, *upper) = (lower.min(corner.position), upper.max(corner.position));
        }
    }
    boxes.retain(|[lower, upper]| lower.x <= upper.x);
    boxes
}
