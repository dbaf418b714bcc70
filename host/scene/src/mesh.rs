//! A mesh in its own space, for instances.

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

/// Number of parts of a mesh along each axis with their own boxes.
const PARTS: i32 = 4;

/// A mesh with its own BVH.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Corners in the space of the mesh's node (m); moved out when records are made.
    pub corners: Vec<[Corner; 3]>,
    /// Materials of the triangles; moved out too.
    pub materials: Vec<u32>,
    /// Centre of the bounds (m): the origin of the mesh's own space, which its records use.
    pub centre: DVec3,
    /// Boxes around parts of the mesh, in the space of its node (m).
    pub boxes: Vec<[DVec3; 2]>,
    /// Id of the first triangle.
    pub first: u32,
    /// Number of triangles.
    pub count: u32,
    /// Range of its BVH nodes; the first is the root.
    pub nodes: Range<usize>,
    /// Its deformation, if it has one.
    pub deformation: Option<Deformation>,
    /// Range of its BVH blocks.
    blocks: Range<usize>,
}

impl Mesh {
    /// Creates a mesh. Returns it with the number of triangles that were dropped because they have no area.
    pub fn new(mut corners: Vec<[Corner; 3]>, mut materials: Vec<u32>) -> (Mesh, usize) {
        let centre = middle(&corners);
        let keep: Vec<bool> = own_triangles(&corners, centre).map(|own| geometry::has_area(&own)).collect();
        let dropped = keep.iter().filter(|keep| !**keep).count();
        geometry::retain(&mut corners, &keep);
        geometry::retain(&mut materials, &keep);
        let (boxes, count) = (boxes(&corners), corners.len() as u32);
        (Mesh { corners, materials, centre, boxes, count, ..Mesh::default() }, dropped)
    }

    /// Creates a deforming mesh, in its shape at time 0. Triangles without an area stay, since they may gain one.
    pub fn deforming(deformation: Deformation, materials: Vec<u32>, nodes: &Nodes) -> Mesh {
        let vertices = deformation.deform(nodes);
        let corners: Vec<[Corner; 3]> = deformation.corners(&vertices).collect();
        let centre = middle(&corners);
        let (boxes, count) = (boxes(&corners), corners.len() as u32);
        Mesh { corners, materials, centre, boxes, count, deformation: Some(deformation), ..Mesh::default() }
    }

    /// Triangles in the mesh's own space with their materials, before records are made.
    pub fn own(&self) -> impl Iterator<Item = (Triangle, u32)> + '_ {
        own_triangles(&self.corners, self.centre).zip(self.materials.iter().copied())
    }

    /// Corners of the boxes around its parts, transformed (m): eight a box.
    pub fn hull(&self, to_world: DAffine3) -> impl Iterator<Item = DVec3> + '_ {
        self.corners_of_boxes().map(move |corner| to_world.transform_point3(corner))
    }

    /// Triangles for a pose of the nodes, transformed (m), before records are made.
    pub fn triangles_at(&self, nodes: &Nodes, to_world: DAffine3) -> Vec<[DVec3; 3]> {
        let deformed = self.deformation.as_ref().map(|deformation| (deformation, deformation.deform(nodes)));
        let transformed =
            |corners: [Corner; 3]| corners.map(|corner| to_world.transform_point3(corner.position));
        match &deformed {
            None => self.corners.iter().copied().map(transformed).collect(),
            Some((deformation, vertices)) => deformation.corners(vertices).map(transformed).collect(),
        }
    }

    /// Triangles across the boxes around its parts, transformed (m). They touch all corners of each box.
    pub fn across(&self, to_world: DAffine3) -> Vec<[DVec3; 3]> {
        let corners: Vec<DVec3> = self.hull(to_world).collect();
        let of_box = |corners: &[DVec3; 8]| {
            [[0, 7, 1], [0, 7, 2], [4, 3, 5], [4, 3, 6]].map(|ids| ids.map(|id: usize| corners[id]))
        };
        corners.as_chunks().0.iter().flat_map(of_box).collect()
    }

    /// Whether all coordinates in the world are within `MAX_COORDINATE`.
    pub fn fits(&self, to_world: &DAffine3, origin: DVec3) -> bool {
        fit(self.corners_of_boxes(), to_world, origin)
    }

    fn corners_of_boxes(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.boxes.iter().flat_map(|&parts| geometry::corners_of_box(parts))
    }

    /// Appends its records and its BVH, at most `levels` deep, to those of a scene.
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

    /// Writes the records for deformed vertices, and refits the BVH.
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

/// Surface record of a triangle.
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

/// Texture coordinate record of a triangle.
fn coordinate_record(triangle: &Triangle, corners: &[Corner; 3]) -> TextureCoordinates {
    let mut record = texture::record(triangle, &coordinates(corners));
    if !record.density.is_finite() {
        record.density = 0.0;
    }
    record
}

/// Whether all transformed points, relative to an origin (m), are within `MAX_COORDINATE`.
pub fn fit(mut points: impl Iterator<Item = DVec3>, to_world: &DAffine3, origin: DVec3) -> bool {
    let fits = |p: DVec3| p.is_finite() && p.abs().max_element() <= geometry::MAX_COORDINATE;
    points.all(|p| fits(to_world.transform_point3(p) - origin))
}

/// Texture coordinates of a triangle's corners.
pub fn coordinates(corners: &[Corner; 3]) -> CornerCoordinates {
    let [a, b, c] = corners.map(|corner| corner.tangent);
    let tangents = a.zip(b).zip(c).map(|((a, b), c)| [a, b, c]);
    CornerCoordinates { uv: corners.map(|corner| corner.uv), tangents }
}

/// Triangles relative to a centre.
fn own_triangles(corners: &[[Corner; 3]], centre: DVec3) -> impl Iterator<Item = Triangle> + '_ {
    let own = move |corner: Corner| (corner.position - centre).as_vec3();
    corners.iter().map(move |&[a, b, c]| Triangle { a: own(a), b: own(b), c: own(c) })
}

fn bounds(corners: &[[Corner; 3]]) -> [DVec3; 2] {
    geometry::box_around(corners.as_flattened().iter().map(|corner| corner.position))
}

/// Centre of the bounds.
fn middle(corners: &[[Corner; 3]]) -> DVec3 {
    let [lower, upper] = bounds(corners);
    if corners.is_empty() { DVec3::ZERO } else { 0.5 * (lower + upper) }
}

/// Boxes around the triangles of each grid cell, by their centres: tighter than a single box when the mesh is rotated.
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
