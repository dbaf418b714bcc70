//! glTF in, flat tables out. Imports interface.
//!
//! `gltf` reads a file, [`Scene::from_parts`] makes the tables of it: `tree` orders the triangles, `light` chooses
//! among the emitters, `needs` says which code the scene can reach.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::light::Light;
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::tree::{TreeNode, TriangleBlock};
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::{DVec3, Vec3};

pub use self::camera::SceneCamera;
pub use self::error::SceneError;
pub use self::find::{names, resolve};
pub use self::punctual::{LightShape, PunctualLight};

mod camera;
mod error;
mod find;
mod geometry;
mod gltf;
mod light;
mod needs;
mod punctual;
#[cfg(test)]
mod tests;
mod tree;

/// A scene as the kernels see it, recentred.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Stem of the file, or its folder's name where the file is `scene.gltf`.
    pub name: String,
    /// Corners [m], in the order of the tree's leaves.
    pub triangles: Vec<Triangle>,
    /// What triangles have beside their corners, in the same order.
    pub surfaces: Vec<TriangleSurface>,
    /// Materials, in the file's order.
    pub materials: Vec<Material>,
    /// Their names.
    pub material_names: Vec<String>,
    /// Emitters of positive power with their alias table; empty in a dark scene.
    pub lights: Vec<Light>,
    /// Nodes of the software tree; the first is the root.
    pub nodes: Vec<TreeNode>,
    /// Its leaves.
    pub blocks: Vec<TriangleBlock>,
    /// Cameras, in the order of the file's nodes.
    pub cameras: Vec<SceneCamera>,
    /// Centre of the file's bounds [m], subtracted from every position.
    pub origin: DVec3,
    /// Emitted flux of each channel [W].
    pub flux: Vec3,
    /// What the file asks for and is not rendered, each once.
    pub warnings: Vec<String>,
    /// Triangles without an area, left out.
    pub dropped_triangles: usize,
}

impl Scene {
    /// A hash of all that paths can meet: FNV-1a, 64 bits, of the tables' bytes.
    pub fn fingerprint(&self) -> String {
        let bytes = crate::session::tables(self).into_iter().flat_map(|(_, bytes)| bytes);
        let hash = bytes.fold(0xcbf2_9ce4_8422_2325u64, |hash, &byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        format!("{hash:016x}")
    }

    /// Makes the tables of geometry that is centred already. A scene may be dark or have no camera.
    ///
    /// Drops triangles without an area, computes curvatures, clears normals that are the face's, orders triangles by the tree, and builds the light table;
    /// `curvature` and `light` of the given surfaces are overwritten.
    pub fn from_parts(
        name: &str,
        mut triangles: Vec<Triangle>,
        mut surfaces: Vec<TriangleSurface>,
        materials: Vec<Material>,
        material_names: Vec<String>,
        punctual_lights: Vec<PunctualLight>,
        cameras: Vec<SceneCamera>,
    ) -> Result<Scene, SceneError> {
        geometry::check(name, &triangles, &surfaces, &materials, &material_names)?;
        light::check(name, &punctual_lights)?;
        let dropped_triangles = geometry::drop_degenerate(&mut triangles, &mut surfaces);
        if triangles.is_empty() {
            return Err(SceneError::NoGeometry { file: name.into(), dropped: dropped_triangles });
        }

        let tree = tree::build(&triangles);
        let triangles: Vec<_> = tree.order.iter().map(|&id| triangles[id as usize]).collect();
        let mut surfaces: Vec<_> = tree.order.iter().map(|&id| surfaces[id as usize]).collect();
        for (triangle, surface) in triangles.iter().zip(&mut surfaces) {
            surface.curvature = geometry::curvature(triangle, surface);
            geometry::flatten(triangle, surface);
            surface.light = NONE;
        }

        let (lights, flux) = light::table(&triangles, &surfaces, &materials, &punctual_lights);
        for (id, light) in lights.iter().enumerate().filter(|(_, light)| light.triangle != NONE) {
            surfaces[light.triangle as usize].light = id as u32;
        }
        Ok(Scene {
            name: name.into(),
            triangles,
            surfaces,
            materials,
            material_names,
            lights,
            nodes: tree.nodes,
            blocks: tree.blocks,
            cameras,
            flux,
            dropped_triangles,
            ..Scene::default()
        })
    }
}
