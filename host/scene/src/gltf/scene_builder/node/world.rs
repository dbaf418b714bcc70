//! Meshes, cameras and lights in the world.

use std::collections::HashMap;

use glam::{DAffine3, DVec3};
use gltf::json::{Index, Mesh};

use crate::animation::{NodeTree, Nodes};
use crate::gltf::context::ImportContext;
use crate::motion::OnNode;
use crate::{PunctualLight, SceneCamera, SceneError};

/// A mesh in the world.
#[derive(Clone)]
pub struct WorldMesh {
    /// Name of the node in messages.
    pub node: String,
    /// The mesh.
    pub mesh: Index<Mesh>,
    /// Transform to the world; for a moving mesh, the poses define it.
    pub to_world: DAffine3,
    /// Index of the node in the rig.
    pub joint: usize,
    /// Whether the node moves.
    pub moves: bool,
    /// Index of the skin.
    pub skin: Option<usize>,
}

/// Contents of the world, not recentred.
#[derive(Default)]
pub struct WorldNodes {
    /// The nodes.
    pub rig: NodeTree,
    /// Transforms of the nodes at time 0.
    pub nodes: Nodes,
    /// Index in the rig, by the index of the file's node.
    pub joint_of: HashMap<usize, usize>,
    /// Meshes.
    pub meshes: Vec<WorldMesh>,
    /// Cameras.
    pub cameras: Vec<OnNode<SceneCamera>>,
    /// Punctual lights.
    pub lights: Vec<OnNode<PunctualLight>>,
}

impl WorldNodes {
    /// Punctual lights in a world recentred to an origin (m). A moving light may still lack a direction.
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

    /// Cameras in a world recentred to an origin (m).
    pub fn cameras_around(&self, origin: DVec3) -> Vec<SceneCamera> {
        let placed =
            |camera: &OnNode<SceneCamera>| camera.what.placed(&self.nodes.to_world[camera.joint], origin);
        self.cameras.iter().map(placed).collect()
    }
}
