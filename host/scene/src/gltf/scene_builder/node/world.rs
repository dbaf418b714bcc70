//! Meshes, cameras and lights in the world.

use std::collections::HashMap;

use glam::{DAffine3, DVec3};
use gltf::json::{Index, Mesh};

use crate::animation::{NodeTree, Nodes};
use crate::gltf::context::ImportContext;
use crate::motion::OnNode;
use crate::{PunctualLight, SceneCamera, SceneError};

/// Mesh in the world.
#[derive(Clone)]
pub struct WorldMesh {
    /// Name of its node in messages.
    pub node: String,
    /// The mesh.
    pub mesh: Index<Mesh>,
    /// Its transform; that of a mesh that moves is left to the poses.
    pub to_world: DAffine3,
    /// Its node in the rig.
    pub joint: usize,
    /// Whether it moves.
    pub moves: bool,
    /// Index of its skin.
    pub skin: Option<usize>,
}

/// Everything that stands in the world, not yet recentred.
#[derive(Default)]
pub struct WorldNodes {
    /// The nodes.
    pub rig: NodeTree,
    /// Their transforms at time 0.
    pub nodes: Nodes,
    /// Index in the rig of each node of the file.
    pub joint_of: HashMap<usize, usize>,
    /// Meshes.
    pub meshes: Vec<WorldMesh>,
    /// Cameras.
    pub cameras: Vec<OnNode<SceneCamera>>,
    /// Punctual lights.
    pub lights: Vec<OnNode<PunctualLight>>,
}

impl WorldNodes {
    /// Punctual lights in a world around an origin (m); one that moves may have no direction yet.
    pub fn lights_around(
        &self,
        context: &ImportContext<'_>,
        origin: DVec3,
    ) -> Result<Vec<PunctualLight>, SceneError> {
        let mut lights = Vec::new();
        for light in &self.lights {
            match light.what.placed(&self.nodes.to_world[light.joint], origin) {
                Some(light) => lights.push(light),
                None if light.moves => {}
                None => {
                    let node = &self.rig.joints[light.joint].label;
                    return Err(context.node_error(node, "its light has no direction (a scale of zero)"));
                }
            }
        }
        Ok(lights)
    }

    /// Cameras in a world around an origin (m).
    pub fn cameras_around(&self, origin: DVec3) -> Vec<SceneCamera> {
        let placed =
            |camera: &OnNode<SceneCamera>| camera.what.placed(&self.nodes.to_world[camera.joint], origin);
        self.cameras.iter().map(placed).collect()
    }
}
