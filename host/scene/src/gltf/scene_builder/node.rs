//! Node tree of the default scene: positions of meshes, cameras and lights, in f64.

use std::collections::{HashMap, HashSet};

use glam::{DAffine3, DVec3};
use gltf::json::scene::Node as JsonNode;
use gltf::json::{Index, Mesh};

use self::walk::Walk;
use super::animation;
use crate::animation::{NodeTree, Nodes};
use crate::file_nodes::no_node;
use crate::gltf::context::ImportContext;
use crate::gltf::decoding::model::Model;
use crate::motion::OnNode;
use crate::{PunctualLight, SceneCamera, SceneError};

mod camera;
mod light;
mod transform;
mod walk;

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

/// Walks the nodes of the default scene, parents first.
pub fn read(model: &Model, context: &mut ImportContext<'_>) -> Result<WorldNodes, SceneError> {
    let mut channels = animation::read(model, context)?;
    let roots = roots(model, context)?;
    let mut walk = Walk { model, context, world: WorldNodes::default() };
    let mut is_visited = vec![false; model.root.nodes.len()];
    let mut stack: Vec<_> = roots.into_iter().rev().map(|root| (root, None)).collect();
    while let Some((index, parent)) = stack.pop() {
        let node = walk.node(index)?;
        if std::mem::replace(&mut is_visited[node.index], true) {
            return Err(walk.context.node_error(&node.label, "has two parents or is below itself"));
        }
        let channels = channels.remove(&node.index).unwrap_or_default();
        let placement = walk.place(&node, parent, channels)?;
        walk.add_mesh(&node, &placement)?;
        walk.add_camera(&node, &placement)?;
        walk.add_light(&node, &placement)?;
        let children = node.json.children.iter().flatten().rev();
        stack.extend(children.map(|&child| (child, Some(placement.joint))));
    }
    let Walk { world, .. } = walk;
    let is_missing = |node: &&usize| !world.joint_of.contains_key(node);
    match context.options.grabbed.iter().find(is_missing) {
        Some(&node) => Err(no_node(context.file, node)),
        None => Ok(world),
    }
}

/// Root nodes of the default scene, else of the first, else every node that is no child.
fn roots(model: &Model, context: &ImportContext<'_>) -> Result<Vec<Index<JsonNode>>, SceneError> {
    let root = &model.root;
    if let Some(scene) = root.scene {
        return Ok(context.get(&root.scenes, scene, "scene", "the document")?.nodes.clone());
    }
    if let Some(scene) = root.scenes.first() {
        return Ok(scene.nodes.clone());
    }
    let children: HashSet<usize> =
        root.nodes.iter().flat_map(|node| node.children.iter().flatten()).map(Index::value).collect();
    Ok((0..root.nodes.len())
        .filter(|node| !children.contains(node))
        .map(|node| Index::new(node as u32))
        .collect())
}
