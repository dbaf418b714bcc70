//! Scene with the user's edits. When a node is moved for the first time, the scene is read again with the node movable.

use std::path::PathBuf;

use caustics::scene::{CameraChoice, CameraEdit, Edits, Eye, FileNode, Keyframe, Scene};
use glam::DAffine3;
use serde::Serialize;

use super::request::NodeEdits;
use crate::cli::Viewer;
use crate::command::open::staged;

/// A scene and its current edits.
pub struct Edited {
    /// The scene.
    pub scene: Scene,
    /// Its file.
    pub file: PathBuf,
    nodes: NodeEdits,
    keys: Vec<Keyframe>,
}

/// Description of a node for a page.
#[derive(Clone, Debug, Serialize)]
pub struct NodeInfo {
    index: usize,
    name: String,
    /// Transform of the node itself, as edited.
    translation: [f64; 3],
    rotation: [f64; 4],
    scale: [f64; 3],
    /// Position in the file's coordinates (m).
    position: [f64; 3],
    /// Columns of the linear map from world space to the space of its parent.
    to_parent: [[f64; 3]; 3],
}

/// A change by edits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Changed {
    /// Nothing.
    Nothing,
    /// The pose alone.
    Pose,
    /// The scene was read again.
    Scene,
}

impl Edited {
    /// Makes the state of a scene that was opened with these edits.
    pub fn new(scene: Scene, file: PathBuf, edits: &Edits) -> Edited {
        Edited { scene, file, nodes: by_node(edits), keys: edits.keys.clone() }
    }

    /// Applies these edits to the scene. Returns what they changed.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, or a node cannot be placed so; the scene and its edits stay as they were.
    pub fn bring(&mut self, options: &Viewer, nodes: &NodeEdits) -> anyhow::Result<Changed> {
        if *nodes == self.nodes {
            return Ok(Changed::Nothing);
        }
        let edits = Edits { nodes: nodes.values().cloned().collect(), keys: self.keys.clone(), camera: None };
        let is_new = nodes.keys().any(|node| !self.nodes.contains_key(node))
            || self.nodes.keys().any(|node| !nodes.contains_key(node));
        if is_new {
            // Reading with these edits makes their nodes movable, as for a scene that is opened with them.
            self.scene = staged(&self.file, &options.view, &options.loading, if_any(&edits))?.scene;
        } else {
            self.scene.play(&edits)?;
        }
        self.nodes.clone_from(nodes);
        Ok(if is_new { Changed::Scene } else { Changed::Pose })
    }

    /// Whether there are edits or keys.
    pub fn is_edited(&self) -> bool {
        !self.nodes.is_empty() || !self.keys.is_empty()
    }

    /// Returns all edits, for `render --edits`, including a placed camera.
    pub fn edits(&self, camera: &CameraChoice) -> Edits {
        let nodes = self.nodes.values().cloned().collect();
        Edits { camera: camera_edit(camera), nodes, keys: self.keys.clone() }
    }

    /// Returns all edits, with the keys of a recording instead of the current ones.
    pub fn recorded(&self, keys: Vec<Keyframe>) -> Edits {
        Edits { camera: None, nodes: self.nodes.values().cloned().collect(), keys }
    }

    /// Returns the edits of nodes.
    pub fn nodes(&self) -> &NodeEdits {
        &self.nodes
    }

    /// Description of a node for a page at a time (s); none if the file has no such node.
    pub fn node_info(&self, node: usize, time: f64) -> Option<NodeInfo> {
        let tree = self.scene.node_tree();
        let of_file = tree.iter().find(|of_file| of_file.index == node)?;
        let edit = self.nodes.get(&node).cloned().unwrap_or_default();
        let parent = of_file
            .parent
            .map_or(Some(DAffine3::IDENTITY), |parent| self.scene.node_to_world(parent, time))?;
        let to_world = self.scene.node_to_world(node, time)?;
        Some(NodeInfo {
            index: node,
            name: label(of_file),
            translation: edit.translation.unwrap_or(of_file.translation.to_array()),
            rotation: edit.rotation.unwrap_or(of_file.rotation.to_array()),
            scale: edit.scale.unwrap_or(of_file.scale.to_array()),
            position: to_world.translation.to_array(),
            to_parent: parent.matrix3.inverse().to_cols_array_2d(),
        })
    }
}

/// Edits by the index of their node.
pub fn by_node(edits: &Edits) -> NodeEdits {
    edits.nodes.iter().map(|edit| (edit.node, edit.clone())).collect()
}

/// Returns the edits, unless they are empty.
pub fn if_any(edits: &Edits) -> Option<Edits> {
    (*edits != Edits::default()).then(|| edits.clone())
}

/// Name of a node for the user.
pub fn label(node: &FileNode) -> String {
    let name = node.name.clone().unwrap_or_else(|| format!("node {}", node.index));
    if node.has_light { format!("{name} (light)") } else { name }
}

/// Returns a placed camera as an edit.
pub fn camera_edit(camera: &CameraChoice) -> Option<CameraEdit> {
    let CameraChoice::Placed(viewpoint) = camera else { return None };
    let (Some(Eye::At(from)), Some(look_at), Some(fov)) = (viewpoint.eye, viewpoint.look_at, viewpoint.field)
    else {
        return None;
    };
    Some(CameraEdit { from: from.0.to_array(), look_at: look_at.0.to_array(), fov })
}

/// File name of the edits in commands.
pub const FILE: &str = "edits.toml";
