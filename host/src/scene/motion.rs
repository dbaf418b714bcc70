//! What moves in a scene: its nodes, and the cameras and lights on them.

use caustics_kernels::interface::features::Features;

use super::animation::{NodeTree, Nodes};
use super::instanced::{Instanced, MeshInstance};
use super::{PunctualLight, SceneCamera};

/// Parts of the animations' time, at whose ends one looks where meshes are.
const LOOKS: u32 = 8;

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

/// What moves in a scene.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// The file, for messages.
    pub file: String,
    /// The nodes.
    pub rig: NodeTree,
    /// Cameras, in the scene's order.
    pub cameras: Vec<OnNode<SceneCamera>>,
    /// Punctual lights.
    pub lights: Vec<OnNode<PunctualLight>>,
}

impl Motion {
    /// Where nodes are at some times of the animations; a time at which that is not finite is left out.
    pub fn looks(&self) -> impl Iterator<Item = Nodes> + '_ {
        let last = self.rig.duration();
        let times = (0..=LOOKS).map(move |look| last * f64::from(look) / f64::from(LOOKS));
        times.filter_map(|time| self.rig.at(time).ok())
    }

    /// Types of the punctual lights that shine at some time.
    pub fn lights(&self) -> Features {
        let lights = self.lights.iter().filter(|light| light.what.intensity.max_element() > 0.0);
        lights.fold(Features(0), |all, light| all | light.what.shape.feature())
    }

    /// Names of the nodes whose cameras, lights and meshes move.
    pub fn names(&self, instanced: &Instanced) -> Vec<&str> {
        let cameras = self.cameras.iter().filter(|camera| camera.moves).map(|camera| camera.joint);
        let lights = self.lights.iter().filter(|light| light.moves).map(|light| light.joint);
        let meshes = instanced.instances.iter().filter_map(MeshInstance::node);
        let bent = instanced.meshes.iter().filter_map(|mesh| Some(mesh.deformation.as_ref()?.node));
        let mut joints: Vec<_> = cameras.chain(lights).chain(meshes).chain(bent).collect();
        joints.sort_unstable();
        joints.dedup();
        joints.into_iter().map(|joint| self.rig.joints[joint].label.as_str()).collect()
    }
}
