//! glTF in, flat tables out. Imports interface.
//!
//! `gltf` reads a file, [`Scene::from_parts`] makes the tables of it: `tree` orders the triangles, `light` chooses
//! among the emitters, `needs` says which code the scene can reach.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::instance::Instance;
use caustics_kernels::interface::light::Light;
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::scene::{SceneTables, TextureTables};
use caustics_kernels::interface::tree::{TreeNode, TriangleBlock};
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use glam::{DVec3, Vec3};

pub use self::camera::SceneCamera;
pub use self::error::SceneError;
pub use self::find::{names, resolve};
pub use self::punctual::{LightShape, PunctualLight};
pub use self::texture::TextureParts;

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
pub mod texture;
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
    /// Textures, in the order of the triangles and the materials.
    pub textures: texture::TextureData,
    /// Instances: the world, then the meshes that move.
    pub instances: Vec<Instance>,
    /// Nodes of the software tree; the first is the root.
    pub nodes: Vec<TreeNode>,
    /// Its leaves.
    pub blocks: Vec<TriangleBlock>,
    /// Radiance behind everything that the file asks for [W m^-2 sr^-1]; it lights nothing.
    pub background: Vec3,
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
        triangles: Vec<Triangle>,
        surfaces: Vec<TriangleSurface>,
        materials: Vec<Material>,
        material_names: Vec<String>,
        punctual_lights: Vec<PunctualLight>,
        cameras: Vec<SceneCamera>,
    ) -> Result<Scene, SceneError> {
        let parts = TextureParts::default();
        Self::from_textured_parts(
            name,
            triangles,
            surfaces,
            materials,
            material_names,
            punctual_lights,
            cameras,
            parts,
        )
    }

    /// The same with textures; sets the materials' flags by them.
    #[expect(clippy::too_many_arguments, reason = "a scene has as many parts")]
    pub fn from_textured_parts(
        name: &str,
        mut triangles: Vec<Triangle>,
        mut surfaces: Vec<TriangleSurface>,
        mut materials: Vec<Material>,
        material_names: Vec<String>,
        punctual_lights: Vec<PunctualLight>,
        cameras: Vec<SceneCamera>,
        mut parts: TextureParts,
    ) -> Result<Scene, SceneError> {
        geometry::check(name, &triangles, &surfaces, &materials, &material_names)?;
        light::check(name, &punctual_lights)?;
        texture::check(name, &parts, triangles.len(), materials.len())?;
        texture::set_flags(&mut materials, &parts);
        let dropped_triangles =
            geometry::drop_degenerate(&mut triangles, &mut surfaces, &mut parts.coordinates);
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

        if !parts.coordinates.is_empty() {
            parts.coordinates = tree.order.iter().map(|&id| parts.coordinates[id as usize]).collect();
        }
        let textures = texture::build(name, parts, &triangles)?;

        let mut scene = Scene {
            name: name.into(),
            triangles,
            surfaces,
            materials,
            material_names,
            textures,
            instances: vec![Instance::default()],
            nodes: tree.nodes,
            blocks: tree.blocks,
            cameras,
            dropped_triangles,
            ..Scene::default()
        };
        let (lights, flux) = light::table(&scene, &punctual_lights);
        let surfaces = &mut scene.surfaces;
        for (id, light) in lights.iter().enumerate().filter(|(_, light)| light.triangle != NONE) {
            surfaces[light.triangle as usize].light = id as u32;
        }
        (scene.lights, scene.flux) = (lights, flux);
        Ok(scene)
    }

    /// Whether anything moves.
    pub fn is_animated(&self) -> bool {
        false
    }

    /// Time of the last key of its animations [s]; 0 where nothing moves.
    pub fn duration(&self) -> f64 {
        0.0
    }

    /// Brings cameras, lights and meshes to where they stand at a time [s]. The pose before becomes the previous one.
    pub fn pose(&mut self, time: f64) -> Result<(), SceneError> {
        let _ = time;
        Ok(())
    }

    /// The tables as kernels take them.
    pub fn tables(&self) -> SceneTables<'_> {
        let textures = TextureTables {
            textures: &self.textures.textures,
            material_textures: &self.textures.materials,
            texture_coordinates: &self.textures.coordinates,
            texels_0: self.textures.chunk(0),
            texels_1: self.textures.chunk(1),
            texels_2: self.textures.chunk(2),
            texels_3: self.textures.chunk(3),
        };
        let Scene { triangles, surfaces, materials, lights, .. } = self;
        SceneTables { triangles, surfaces, materials, lights, textures }
    }
}
