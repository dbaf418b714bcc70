//! glTF in, flat tables out. Imports interface.
//!
//! `gltf` reads a file, [`Scene::from_parts`] makes the tables of it: `tree` orders the triangles, `light` chooses
//! among the emitters, `features` says which code the scene can reach.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::instance::Instance;
use caustics_kernels::interface::light::Light;
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::scene::{SceneTables, TextureTables};
use caustics_kernels::interface::texture::TextureCoordinates;
use caustics_kernels::interface::tree::{TreeNode, TriangleBlock};
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use caustics_kernels::texture::cut_out::CutOuts;
use caustics_kernels::trace::bvh::BvhTracer;
use glam::{DVec3, Vec3};

use crate::hash::fnv1a;

pub use self::camera::SceneCamera;
pub use self::error::SceneError;
pub use self::find::{MADE, names, resolve};
pub use self::gltf::files::files;
pub(crate) use self::gltf::read_alone as read;
use self::media::Media;
use self::motion::Motion;
use self::moving::MovingMesh;
pub use self::punctual::{LightShape, PunctualLight};
pub use self::texture::TextureParts;
use self::tree::top;

pub mod animation;
mod buffers;
mod camera;
mod error;
mod features;
mod find;
mod geometry;
mod gltf;
mod light;
mod media;
pub mod motion;
pub mod moving;
mod punctual;
mod sheets;
mod solids;
#[cfg(test)]
mod tests;
pub mod texture;
mod tree;

/// A scene as kernels see it: flat tables, with positions relative to [`Scene::origin`]. [`Scene::load`] reads one from glTF.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Stem of the file, or its folder's name where the file is `scene.gltf`.
    pub name: String,
    /// Corners (m), in the order of the tree's leaves.
    pub triangles: Vec<Triangle>,
    /// What triangles have beside their corners, in the same order.
    pub surfaces: Vec<TriangleSurface>,
    /// Materials, in the file's order.
    pub materials: Vec<Material>,
    /// Names of the materials.
    pub material_names: Vec<String>,
    /// Emitters of positive power with their alias table; empty in a dark scene.
    pub lights: Vec<Light>,
    /// Textures, in the order of the triangles and the materials.
    pub textures: texture::TextureData,
    /// Instances: the world, then the meshes that move.
    pub instances: Vec<Instance>,
    /// Nodes of the software tree; the first is the root.
    pub nodes: Vec<TreeNode>,
    /// Leaves of the software tree: up to four triangles each.
    pub blocks: Vec<TriangleBlock>,
    /// Triangles of the meshes that move, each in its mesh's own space; rows as behind those that stand still.
    pub object_triangles: Vec<Triangle>,
    /// What moves, and how; `None` in a scene that stands still.
    pub motion: Option<Motion>,
    /// Radiance behind everything that the file asks for (W m^-2 sr^-1); it lights nothing.
    pub background: Vec3,
    /// Cameras, in the order of the file's nodes.
    pub cameras: Vec<SceneCamera>,
    /// Centre of the file's bounds (m), or of what is small beside huge triangles; subtracted from every position.
    pub origin: DVec3,
    /// Emitted flux of each channel (W).
    pub flux: Vec3,
    /// Whether a path can be inside of two solids at once, or of an open sheet.
    pub has_nested_media: bool,
    /// What the file asks for and is not rendered, each once; what in it should be repaired.
    pub warnings: Vec<String>,
    /// Triangles without an area, left out.
    pub dropped_triangles: usize,
}

impl Scene {
    /// A hash of all that paths can meet: FNV-1a, 64 bits, of the tables' bytes.
    pub fn fingerprint(&self) -> String {
        let tables = self.buffers();
        let bytes = tables.iter().flat_map(|(_, bytes)| *bytes).copied();
        let channels = self.motion.iter().flat_map(|motion| motion.rig.bytes());
        fnv1a(bytes.chain(channels))
    }

    /// Makes the tables of geometry that is centred already. A scene may be dark or have no camera.
    ///
    /// Drops triangles without an area, computes curvatures, clears normals that are the face's, orders triangles by the tree, and builds the light table;
    /// `curvature` and `light` of the given surfaces are overwritten, and the materials' priorities by a strict order.
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
        triangles: Vec<Triangle>,
        surfaces: Vec<TriangleSurface>,
        materials: Vec<Material>,
        material_names: Vec<String>,
        punctual_lights: Vec<PunctualLight>,
        cameras: Vec<SceneCamera>,
        parts: TextureParts,
    ) -> Result<Scene, SceneError> {
        let origin = DVec3::ZERO;
        Self::assemble(
            name,
            triangles,
            surfaces,
            materials,
            material_names,
            punctual_lights,
            cameras,
            parts,
            origin,
            None,
        )
    }

    /// The same with what moves: triangles, surfaces and coordinates are those that stand still.
    #[expect(clippy::too_many_arguments, reason = "a scene has as many parts")]
    fn assemble(
        name: &str,
        mut triangles: Vec<Triangle>,
        mut surfaces: Vec<TriangleSurface>,
        mut materials: Vec<Material>,
        material_names: Vec<String>,
        punctual_lights: Vec<PunctualLight>,
        cameras: Vec<SceneCamera>,
        mut parts: TextureParts,
        origin: DVec3,
        mut motion: Option<Motion>,
    ) -> Result<Scene, SceneError> {
        geometry::check(name, &triangles, &surfaces, &materials, &material_names)?;
        light::check(name, &punctual_lights)?;
        let meshes = motion.as_ref().map_or(&[][..], |motion| &motion.meshes);
        if !parts.textures.is_empty() {
            parts.coordinates.extend(meshes.iter().flat_map(MovingMesh::coordinates));
        }
        let moving: usize = meshes.iter().map(|mesh| mesh.corners.len()).sum();
        texture::check(name, &parts, triangles.len() + moving, &material_names)?;
        texture::set_flags(&mut materials, &parts);
        let media = Media::of(&materials, &triangles, &surfaces, motion.as_ref());
        media.rank(&mut materials);
        let has_coordinates = !parts.coordinates.is_empty();
        parts.coordinates.truncate(triangles.len());
        let dropped_triangles =
            geometry::drop_degenerate(&mut triangles, &mut surfaces, &mut parts.coordinates);
        if triangles.len() + moving == 0 {
            return Err(SceneError::NoGeometry { file: name.into(), dropped: dropped_triangles });
        }
        if meshes.len() > top::MAX_MESHES {
            let what = format!("{} meshes move, but at most {} may", meshes.len(), top::MAX_MESHES);
            return Err(SceneError::Tables { file: name.into(), what });
        }

        // An instance carries the id of its first triangle in 24 bits.
        if moving > 0 && triangles.len() + moving > 1 << 24 {
            let what = "a scene with meshes that move has more than 2^24 triangles".into();
            return Err(SceneError::Tables { file: name.into(), what });
        }

        // The tree over what stands still; below a top level where meshes move.
        let leaves = meshes.len() + usize::from(!triangles.is_empty());
        let (top, levels) =
            if moving > 0 { (top::node_count(leaves), top::levels_below(leaves)) } else { (0, tree::LEVELS) };
        let tree = match triangles.is_empty() {
            true => tree::Tree::default(),
            false => tree::build_within(&triangles, levels),
        };
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
            nodes: vec![TreeNode::default(); top],
            cameras,
            origin,
            has_nested_media: media.are_nested(),
            dropped_triangles,
            ..Scene::default()
        };
        tree::append(&mut scene, tree.nodes, tree.blocks);
        let Some(motion) = &mut motion else {
            let emitters = light::emitters(&scene);
            light::apply(&mut scene, &emitters, &punctual_lights);
            scene.mark_hanging_sheets();
            scene.warnings = media.warnings(&scene);
            return Ok(scene);
        };

        (motion.top, motion.still) = (top, scene.triangles.len());
        motion.still_bounds = scene.triangles.iter().map(tree::bounds).reduce(|all, next| all.union(&next));
        for (id, mesh) in motion.meshes.iter_mut().enumerate() {
            mesh.append(&mut scene, id as u32 + 1, levels);
            if has_coordinates {
                scene.textures.coordinates.resize(scene.triangles.len(), TextureCoordinates::default());
            }
        }
        motion.prepare();
        motion.pose(&mut scene, 0.0)?;
        // Emission is sampled where the texture coordinates are known: after the first pose.
        motion.emitters = light::emitters(&scene);
        motion.prepare();
        motion.pose(&mut scene, 0.0)?;
        scene.mark_hanging_sheets();
        scene.warnings = media.warnings(&scene);
        Ok(Scene { motion: Some(std::mem::take(motion)), ..scene })
    }

    /// Whether anything in the scene moves.
    pub fn is_animated(&self) -> bool {
        self.motion.is_some()
    }

    /// Time of the last key of its animations (s); 0 where nothing moves.
    pub fn duration(&self) -> f64 {
        self.motion.as_ref().map_or(0.0, |motion| motion.rig.duration())
    }

    /// Brings cameras, lights and meshes to where they stand at a time (s). The pose before becomes the previous one.
    /// A time that cannot be shown is an error and changes nothing.
    pub fn pose(&mut self, time: f64) -> Result<(), SceneError> {
        let Some(mut motion) = self.motion.take() else { return Ok(()) };
        let posed = motion.pose(self, time);
        self.motion = Some(motion);
        posed
    }

    /// Its software tracer; `CUT_OUTS` and `INSTANCES` decide whether it looks for holes and for what moves.
    pub fn tracer(&self, features: Features) -> BvhTracer<'_> {
        let cut_outs = CutOuts::of(self.tables(), features);
        BvhTracer { nodes: &self.nodes, blocks: &self.blocks, instances: &self.instances, cut_outs }
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
