//! glTF in, flat tables out. Imports interface.
//!
//! `gltf` reads a file into [`SceneParts`], which make the tables: `bvh` orders the triangles, `light` chooses among the
//! emitters, `features` says which code the scene can reach, and `pose` brings what moves to a time. All of them know
//! [`Scene`], which knows none of them.

#![cfg_attr(not(test), deny(clippy::print_stderr, clippy::print_stdout))]
#![forbid(unsafe_code)]

use std::collections::BTreeMap;

use caustics_kernels::interface::bvh::{BvhNode, TriangleBlock};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::instance::Instance;
use caustics_kernels::interface::light::Light;
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::scene::{SceneTables, TextureTables};
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use caustics_kernels::texture::cut_out::CutOuts;
use caustics_kernels::trace::bvh::BvhTracer;
use glam::{DVec3, Vec3};

use self::animation::NodeTree;

pub use self::bvh::{BvhCache, BvhOptions, BvhQuality};
#[doc(hidden)]
pub use self::bvh::{accepts as accepts_bvh, sealed_file as sealed_bvh};
pub use self::camera::SceneCamera;
pub use self::casters::Cuts;
pub use self::edits::{CameraEdit, Edits, EditsError, Keyframe, NodeEdit};
pub use self::environment::{EnvironmentMap, EnvironmentTables};
pub use self::error::SceneError;
pub use self::file_nodes::FileNode;
pub use self::find::{MADE, names, resolve};
pub use self::gltf::files::files;
pub use self::gltf::options::LoadOptions;
#[doc(hidden)]
pub use self::gltf::read_alone as read;
pub use self::instanced::Instanced;
pub use self::light::Emitter;
pub use self::motion::Motion;
pub use self::parts::SceneParts;
pub use self::punctual::{LightShape, PunctualLight};
pub use self::radiance::Radiance;
pub use self::recorded::Recorded;
pub use self::staging::{DefaultLight, Staged, Staging};
pub use self::texture::TextureParts;
pub use self::viewpoint::{CameraChoice, Eye, Orbit, Position, Viewpoint};

mod animation;
mod borders;
mod buffers;
mod bvh;
mod camera;
mod casters;
mod corner;
mod default_light;
mod deformation;
pub mod edits;
mod environment;
mod error;
mod features;
mod file_nodes;
mod find;
mod fingerprint;
mod floor;
mod geometry;
mod gltf;
pub mod instanced;
mod light;
mod media;
pub mod mesh;
pub mod motion;
mod open_surfaces;
mod parts;
mod pose;
mod priorities;
mod punctual;
mod radiance;
mod recorded;
mod solids;
mod staging;
#[cfg(test)]
mod tests;
pub mod texture;
mod viewpoint;

/// A scene as kernels see it: flat tables, with positions relative to [`Scene::origin`]. [`Scene::load`] reads one from glTF.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Stem of the file, or its folder's name where the file is `scene.gltf`.
    pub name: String,
    /// Corners (m), in the order of the BVH's leaves: those of the world, then those of every mesh in its own space.
    pub triangles: Vec<Triangle>,
    /// What triangles have beside their corners, in the same order.
    pub surfaces: Vec<TriangleSurface>,
    /// Materials, in the file's order; then more records of those whose solids need several priorities
    /// ([`Material::medium`] tells which).
    pub materials: Vec<Material>,
    /// Names of the file's materials.
    pub material_names: Vec<String>,
    /// Emitters of positive power with their alias table; empty in a dark scene.
    pub lights: Vec<Light>,
    /// Lights that are no triangles, where nothing moves.
    pub punctual_lights: Vec<PunctualLight>,
    /// Light from all around.
    pub environment: EnvironmentTables,
    /// Textures, in the order of the triangles and the materials.
    pub textures: texture::TextureData,
    /// Instances: the world, then [`Scene::instanced`].
    pub instances: Vec<Instance>,
    /// Nodes of the software BVH; the first is the root.
    pub nodes: Vec<BvhNode>,
    /// Leaves of the software BVH: up to four triangles each.
    pub blocks: Vec<TriangleBlock>,
    /// Meshes with rows in spaces of their own, and where they stand.
    pub instanced: Instanced,
    /// Triangles that emit, whatever their area at the pose at hand.
    pub emitters: Vec<Emitter>,
    /// The file's nodes, and how they move.
    pub rig: NodeTree,
    /// Index of the node that each triangle of the world is of; [`NONE`](caustics_kernels::interface::NONE) where it is of none.
    pub owners: Vec<u32>,
    /// What moves with them; `None` in a scene that stands still.
    pub motion: Option<Motion>,
    /// A camera that goes its own way.
    pub recorded: Option<Recorded>,
    /// Radiance behind everything that the file asks for (W m^-2 sr^-1); it lights nothing.
    pub background: Vec3,
    /// Cameras, in the order of the file's nodes; then those that were placed.
    pub cameras: Vec<SceneCamera>,
    /// Centre of the file's bounds (m), or of what is small beside huge triangles; subtracted from every position.
    pub origin: DVec3,
    /// Lower and upper corner of the box around its triangles (m), wherever its animations bring them.
    pub bounds: [Vec3; 2],
    /// Emitted flux of each channel (W).
    pub flux: Vec3,
    /// Whether a path can be inside of two solids at once, or of an open surface.
    pub has_nested_media: bool,
    /// What the file asks for and is not rendered, each once; what in it should be repaired.
    pub warnings: Vec<String>,
    /// Triangles without an area, left out.
    pub dropped_triangles: usize,
    /// What it got that its file does not have and that no table tells, by name: attributes of what is rendered of it.
    pub additions: BTreeMap<&'static str, String>,
    /// Where light paths are aimed, as far as somebody asked; whoever changes triangles or materials clears it.
    pub casters: Cuts,
}

impl Scene {
    /// Name of the material that a record is of.
    pub fn material_name(&self, record: u32) -> &str {
        &self.material_names[self.materials[record as usize].medium as usize]
    }

    /// The camera of a name; the first where none is given.
    ///
    /// # Errors
    ///
    /// If there is no such camera; the error lists those there are. [`Scene::place_camera`] makes one.
    pub fn camera(&self, name: Option<&str>) -> Result<&SceneCamera, SceneError> {
        let found = self.cameras.iter().find(|camera| name.is_none_or(|name| camera.name == name));
        found.ok_or_else(|| match name.filter(|_| !self.cameras.is_empty()) {
            None => SceneError::NoCamera { scene: self.name.clone() },
            Some(name) => SceneError::UnknownCamera {
                scene: self.name.clone(),
                camera: name.into(),
                known: self.cameras.iter().map(|camera| camera.name.as_str()).collect::<Vec<_>>().join(", "),
            },
        })
    }

    /// Gives back the memory of the large tables, of which a runner that was opened with it has its own: what is left tells of
    /// the scene, and renders nothing.
    pub fn leave_tables(&mut self) {
        (self.triangles, self.surfaces, self.owners) = Default::default();
        (self.nodes, self.blocks) = Default::default();
        (self.textures, self.environment) = Default::default();
    }

    /// Whether anything in the scene moves, or may be edited.
    pub fn is_animated(&self) -> bool {
        self.motion.is_some() || self.recorded.is_some()
    }

    /// Whether something can shine at some time, because what moves changes.
    pub fn lights_up(&self) -> bool {
        let lights = |motion: &Motion| motion.lights().has(caustics_kernels::light::TYPES);
        self.motion.as_ref().is_some_and(|motion| lights(motion) || !self.emitters.is_empty())
    }

    /// Rows that its light table can have at most, at any time.
    pub fn max_light_count(&self) -> usize {
        let lights = |motion: &Motion| self.emitters.len() + motion.lights.len() + 1;
        self.motion.as_ref().map_or(0, lights).max(self.lights.len())
    }

    /// Time of the last key of its animations and edits (s); 0 where nothing moves.
    pub fn duration(&self) -> f64 {
        self.recorded.as_ref().map_or(0.0, Recorded::duration).max(self.rig.duration())
    }

    /// Its software tracer; `CUT_OUTS` and `INSTANCES` decide whether it looks for holes and for instances.
    pub fn tracer(&self, features: Features) -> BvhTracer<'_> {
        let cut_outs = CutOuts::new(self.tables(), features);
        BvhTracer { nodes: &self.nodes, blocks: &self.blocks, cut_outs }
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
        let Scene { triangles, surfaces, instances, materials, lights, environment, .. } = self;
        SceneTables {
            triangles,
            surfaces,
            instances,
            materials,
            lights,
            environment: &environment.records,
            environment_texels: &environment.texels,
            environment_cdf: &environment.cdf,
            textures,
        }
    }
}
