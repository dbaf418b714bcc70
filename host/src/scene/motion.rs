//! What moves in a scene with its nodes: cameras and lights.

use caustics_kernels::interface::features::Features;

use super::instanced::MeshInstance;
use super::{PunctualLight, Scene, SceneCamera};

/// Something on a node.
#[derive(Clone, Debug, PartialEq)]
pub struct OnNode<T> {
    /// Its node.
    pub joint: usize,
    /// Whether the node moves.
    pub moves: bool,
    /// What it is, not yet placed.
    pub what: T,
}

/// What moves in a scene beside its meshes.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// The file, for messages.
    pub file: String,
    /// Cameras, in the scene's order.
    pub cameras: Vec<OnNode<SceneCamera>>,
    /// Punctual lights.
    pub lights: Vec<OnNode<PunctualLight>>,
}

impl Motion {
    /// Types of the punctual lights that shine at some time.
    pub fn lights(&self) -> Features {
        let lights = self.lights.iter().filter(|light| light.what.intensity.max_element() > 0.0);
        lights.fold(Features(0), |all, light| all | light.what.shape.feature())
    }
}

impl Scene {
    /// Names of the nodes whose cameras, lights and meshes move.
    pub fn moving_nodes(&self) -> Vec<&str> {
        let Some(motion) = &self.motion else { return Vec::new() };
        let instanced = &self.instanced;
        let cameras = motion.cameras.iter().filter(|camera| camera.moves).map(|camera| camera.joint);
        let lights = motion.lights.iter().filter(|light| light.moves).map(|light| light.joint);
        let meshes = instanced.instances.iter().filter_map(MeshInstance::node);
        let bent = instanced.meshes.iter().filter_map(|mesh| Some(mesh.deformation.as_ref()?.node));
        let mut joints: Vec<_> = cameras.chain(lights).chain(meshes).chain(bent).collect();
        joints.sort_unstable();
        joints.dedup();
        joints.into_iter().map(|joint| self.rig.joints[joint].label.as_str()).collect()
    }
}
