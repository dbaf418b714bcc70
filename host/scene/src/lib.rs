//! Reads glTF into the flat tables of the kernels. Imports interface.
//!
//! `gltf` reads a file into [`SceneParts`], which build the tables. `bvh` orders the triangles, `light` builds the light table,
//! `features` finds the code that the scene needs, and `pose` moves the scene to a time. These modules know [`Scene`]; it knows
//! none of them.

#![cfg_attr(not(test), deny(clippy::print_stderr, clippy::print_stdout))]
#![forbid(unsafe_code)]

use std::collections::BTreeMap;

use caustics_kernels::interface::bvh::{BvhNode, TriangleBlock};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::instance::Instance;
use caustics_kernels::interface::light::Light;
use caustics_kernels::interface::light_bvh::LightBvhNode;
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
    /// Corners (m) in the order of the BVH's leaves: first the world's, then every mesh's in its own space.
    pub triangles: Vec<Triangle>,
    /// Surface records of the triangles, in the same order.
    pub surfaces: Vec<TriangleSurface>,
    /// Materials in the file's order. Further records follow if solids of one material need several priorities;
    /// [`Material::medium`] names the file's material.
    pub materials: Vec<Material>,
    /// Names of the file's materials.
    pub material_names: Vec<String>,
    /// Emitters of positive power with their alias table; empty in a dark scene.
    pub lights: Vec<Light>,
    /// Nodes of the light BVH over `lights`; none where they are few.
    pub light_bvh: Vec<LightBvhNode>,
    /// Keys ([`Light::key`]) of all lights, whether they shine or not: emitters, punctual lights, environment.
    pub light_keys: Vec<u32>,
    /// Punctual lights, if nothing moves.
    pub punctual_lights: Vec<PunctualLight>,
    /// Environment light.
    pub environment: EnvironmentTables,
    /// Textures, in the order of the triangles and the materials.
    pub textures: texture::TextureData,
    /// Instances: the world, then [`Scene::instanced`].
    pub instances: Vec<Instance>,
    /// Nodes of the software BVH; the first is the root.
    pub nodes: Vec<BvhNode>,
    /// Leaves of the software BVH: up to four triangles each.
    pub blocks: Vec<TriangleBlock>,
    /// Meshes with records in their own space, and their instances.
    pub instanced: Instanced,
    /// Triangles that emit, independent of their area at the current pose.
    pub emitters: Vec<Emitter>,
    /// Node tree of the file, with its animations.
    pub rig: NodeTree,
    /// Node of each world triangle; [`NONE`](caustics_kernels::interface::NONE) without a node.
    pub owners: Vec<u32>,
    /// Cameras and lights on nodes; `None` in a static scene.
    pub motion: Option<Motion>,
    /// Camera that follows keyframes of edits.
    pub recorded: Option<Recorded>,
    /// Background radiance of the file (W m^-2 sr^-1), seen but not lighting.
    pub background: Vec3,
    /// Cameras in the order of the file's nodes, then placed cameras.
    pub cameras: Vec<SceneCamera>,
    /// Origin of the scene in the file's coordinates (m), subtracted from every position: the centre of the bounds, or of small
    /// objects beside huge triangles.
    pub origin: DVec3,
    /// Lower and upper corner of the box around the triangles at all times (m).
    pub bounds: [Vec3; 2],
    /// Emitted flux of each channel (W).
    pub flux: Vec3,
    /// Whether a path can be inside of two solids at once, or of an open surface.
    pub has_nested_media: bool,
    /// Warnings, each once: features that are not rendered, and faults of the file.
    pub warnings: Vec<String>,
    /// Number of triangles that were left out because they have no area.
    pub dropped_triangles: usize,
    /// Attributes of the rendered scene that neither file nor tables hold, by name.
    pub additions: BTreeMap<&'static str, String>,
    /// Spheres around casters, computed on demand. Code that changes triangles or materials must clear them.
    pub casters: Cuts,
}

impl Scene {
    /// Name of a record's material.
    pub fn material_name(&self, record: u32) -> &str {
        &self.material_names[self.materials[record as usize].medium as usize]
    }

    /// Returns the camera with this name; without a name, the first.
    ///
    /// # Errors
    ///
    /// If the scene has no such camera; the error lists its cameras. [`Scene::place_camera`] adds one.
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

    /// Frees the large tables after a runner has copied them. The remaining scene describes itself, but cannot be rendered.
    pub fn leave_tables(&mut self) {
        (self.triangles, self.surfaces, self.owners) = Default::default();
        (self.nodes, self.blocks) = Default::default();
        (self.textures, self.environment) = Default::default();
    }

    /// Whether anything moves or may be edited.
    pub fn is_animated(&self) -> bool {
        self.motion.is_some() || self.recorded.is_some()
    }

    /// Whether the scene can emit at some time because something moves.
    pub fn lights_up(&self) -> bool {
        let lights = |motion: &Motion| motion.lights().has(caustics_kernels::light::TYPES);
        self.motion.as_ref().is_some_and(|motion| lights(motion) || !self.emitters.is_empty())
    }

    /// Maximum number of light records at any time.
    pub fn max_light_count(&self) -> usize {
        let lights = |motion: &Motion| self.emitters.len() + motion.lights.len() + 1;
        self.motion.as_ref().map_or(0, lights).max(self.lights.len())
    }

    /// Share of the candidates of light samples that the light BVH samples, if it is chosen; 0 where lights are few.
    pub fn light_bvh_share(&self) -> f32 {
        light::bvh::share(&self.lights)
    }

    /// Maximum number of nodes of the light BVH at any time.
    pub fn max_light_bvh_nodes(&self) -> usize {
        light::bvh::node_count(self.max_light_count())
    }

    /// Time of the last key of animations and edits (s); 0 without any.
    pub fn duration(&self) -> f64 {
        self.recorded.as_ref().map_or(0.0, Recorded::duration).max(self.rig.duration())
    }

    /// Software tracer of the scene. `CUT_OUTS` and `INSTANCES` select the support of cut-outs and instances.
    pub fn tracer(&self, features: Features) -> BvhTracer<'_> {
        let cut_outs = CutOuts::new(self.tables(), features);
        BvhTracer { nodes: &self.nodes, blocks: &self.blocks, cut_outs }
    }

    /// The tables in the form that kernels take.
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
        let Scene { triangles, surfaces, instances, materials, lights, light_bvh, environment, .. } = self;
        SceneTables {
            triangles,
            surfaces,
            instances,
            materials,
            lights,
            light_bvh,
            environment: &environment.records,
            environment_texels: &environment.texels,
            environment_cdf: &environment.cdf,
            textures,
        }
    }
}
