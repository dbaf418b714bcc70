//! The rows of a scene's tables that a moving mesh has.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::instance::Instance;
use caustics_kernels::interface::texture::TextureCoordinates;
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::DAffine3;

use crate::scene::corner::{Corner, placed, turned};
use crate::scene::moving::MovingMesh;
use crate::scene::texture::{self, CornerCoordinates};
use crate::scene::{Scene, geometry, tree};

impl MovingMesh {
    /// Appends its tree, and rows that a pose will fill; `levels` is how deep the tree may be.
    pub fn append(&mut self, scene: &mut Scene, instance: u32, levels: u32) {
        let own = self.own_triangles();
        let mut tree = tree::build_within(&own, levels);
        let order = std::mem::take(&mut tree.order);
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

        for block in &mut tree.blocks {
            block.first += self.first;
        }
        let (root, first_block) = (scene.nodes.len() as u32, scene.blocks.len());
        tree.append_to(&mut scene.nodes, &mut scene.blocks);
        self.blocks = first_block..scene.blocks.len();
        scene.triangles.extend(&own);
        scene.surfaces.extend(self.materials.iter().map(|&material| TriangleSurface {
            material,
            instance,
            light: NONE,
            ..TriangleSurface::default()
        }));
        scene.object_triangles.extend(&own);
        scene.instances.push(Instance { root, ..Instance::default() });
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
}
