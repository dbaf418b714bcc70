//! Steps of the walk through the node tree.

use glam::{DAffine3, DVec3};
use gltf::json::Index;
use gltf::json::scene::Node as JsonNode;

use super::transform::{bytes, local, morph};
use super::world::{WorldMesh, WorldNodes};
use super::{camera, light};
use crate::animation::{Channel, Local, Node, OfFile, Path, is_singular};
use crate::gltf::context::{ImportContext, label};
use crate::gltf::decoding::model::Model;
use crate::gltf::scene_builder::instancing;
use crate::motion::OnNode;
use crate::{PunctualLight, SceneError};

/// Walk through the nodes of a model.
pub struct Walk<'a, 'b> {
    pub model: &'a Model,
    pub context: &'a mut ImportContext<'b>,
    /// Result so far.
    pub world: WorldNodes,
}

/// A node of the file.
pub struct SourceNode<'a> {
    pub index: usize,
    pub json: &'a JsonNode,
    /// Name in messages.
    pub label: String,
}

/// Transform of a node in the world.
pub struct Placement {
    /// Index in the rig.
    pub joint: usize,
    /// Transform at time 0.
    to_world: DAffine3,
    /// Whether the node moves.
    moves: bool,
    /// Whether its transform is singular, so that nothing on it is visible.
    is_flat: bool,
}

impl<'a> Walk<'a, '_> {
    /// Looks a node up.
    pub fn node(&self, index: Index<JsonNode>) -> Result<SourceNode<'a>, SceneError> {
        let json = self.context.get(&self.model.root.nodes, index, "node", "the node tree")?;
        let index = index.value();
        Ok(SourceNode { index, json, label: label("node", index, json.name.as_deref()) })
    }

    /// Adds a node to the rig, below its parent.
    pub fn place(
        &mut self,
        node: &SourceNode<'_>,
        parent: Option<usize>,
        channels: Vec<Channel>,
    ) -> Result<Placement, SceneError> {
        let (index, json) = (node.index, node.json);
        let (weights, channels) = channels.into_iter().partition(|channel| channel.path == Path::Weights);
        let (local, morph) = (local(json, channels), morph(self.model, json, weights));

        // Transform
        let not_finite = |what: &str| self.context.node_error(&node.label, format!("{what} is not finite"));
        let to_parent = parent.map_or(DAffine3::IDENTITY, |parent| self.world.nodes.to_world[parent]);
        let to_world = to_parent * local.at(0.0).ok_or_else(|| not_finite("its transform"))?;
        if !to_world.is_finite() {
            return Err(not_finite("its transform in the world"));
        }
        let is_grabbed = self.context.options.grabbed.contains(&index);
        let parent_moves = parent.is_some_and(|parent| self.world.rig.joints[parent].moves);
        let moves = is_grabbed || !local.channels.is_empty() || parent_moves;
        // Skinned vertices are in the world, independent of the mesh's node.
        let is_flat = !moves && json.skin.is_none() && is_singular(&to_world);
        if is_flat && (json.mesh.is_some() || json.camera.is_some()) {
            let what = "its transform is singular (a scale of zero, or axes in one plane)";
            self.context.warn(&node.label, format_args!("{what}; not shown"));
        }

        // Node of the rig
        let world = &mut self.world;
        let joint = world.rig.joints.len();
        world.joint_of.insert(index, joint);
        world.nodes.weights.push(morph.at(0.0));
        world.nodes.to_world.push(to_world);
        let of_file = OfFile {
            index,
            name: json.name.clone(),
            has_mesh: json.mesh.is_some(),
            has_light: light::of_node(json).is_some(),
            has_camera: json.camera.is_some(),
        };
        let (label, of_file) = (node.label.clone(), Some(of_file));
        world.rig.joints.push(Node { label, of_file, parent, local, moves, morph });
        Ok(Placement { joint, to_world, moves, is_flat })
    }

    /// Adds the mesh of a node, once or for each of its instances.
    pub fn add_mesh(&mut self, node: &SourceNode<'_>, placement: &Placement) -> Result<(), SceneError> {
        let &Placement { joint, to_world, moves, is_flat } = placement;
        let Some(mesh) = node.json.mesh.filter(|_| !is_flat) else { return Ok(()) };
        let skin = node.json.skin.map(|skin| skin.value());
        let mesh = WorldMesh { node: node.label.clone(), mesh, to_world, joint, moves, skin };
        let of_node = moves.then(|| bytes(&self.world.rig.joints[joint].morph));
        match instancing::read(self.model, self.context, node.index, &node.label, of_node)? {
            Some(transforms) => self.add_instances(&mesh, transforms),
            None => {
                self.push_mesh(mesh);
                Ok(())
            }
        }
    }

    /// Adds many instances of a mesh; those with a scale of zero are left out. If the node moves, each becomes a child node.
    fn add_instances(&mut self, first: &WorldMesh, transforms: Vec<Local>) -> Result<(), SceneError> {
        for (id, local) in transforms.into_iter().enumerate() {
            let node = format!("{}, instance {id}", first.node);
            let to_world = local.at(0.0).map(|local| first.to_world * local).filter(DAffine3::is_finite);
            let Some(to_world) = to_world else {
                return Err(self.context.node_error(&node, "its transform in the world is not finite"));
            };
            if is_singular(&to_world) {
                continue;
            }
            let mut joint = first.joint;
            if first.moves {
                let world = &mut self.world;
                joint = world.rig.joints.len();
                let (label, morph) = (node.clone(), world.rig.joints[first.joint].morph.clone());
                world.nodes.weights.push(morph.weights.clone());
                world.nodes.to_world.push(to_world);
                let parent = Some(first.joint);
                world.rig.joints.push(Node { label, of_file: None, parent, local, moves: true, morph });
            }
            self.push_mesh(WorldMesh { node, to_world, joint, ..*first });
        }
        Ok(())
    }

    fn push_mesh(&mut self, mut mesh: WorldMesh) {
        if mesh.moves {
            mesh.to_world = DAffine3::IDENTITY;
        }
        self.world.meshes.push(mesh);
    }

    /// Adds the camera of a node.
    pub fn add_camera(&mut self, node: &SourceNode<'_>, placement: &Placement) -> Result<(), SceneError> {
        let &Placement { joint, moves, is_flat, .. } = placement;
        if let Some(index) = node.json.camera.filter(|_| !is_flat) {
            let camera = camera::read(self.model, self.context, index, node.json, &node.label)?;
            self.world.cameras.extend(camera.map(|what| OnNode { joint, moves, what }));
        }
        Ok(())
    }

    /// Adds the punctual light of a node; a light that never has a direction is left out.
    pub fn add_light(&mut self, node: &SourceNode<'_>, placement: &Placement) -> Result<(), SceneError> {
        let &Placement { joint, to_world, moves, .. } = placement;
        let Some(index) = light::of_node(node.json) else { return Ok(()) };
        let light = light::read(self.model, self.context, index, &node.label)?;
        let is_lost = |light: &PunctualLight| !moves && light.placed(&to_world, DVec3::ZERO).is_none();
        if light.as_ref().is_some_and(is_lost) {
            self.context.warn(&node.label, "its light has no direction (a scale of zero); left out");
        }
        let light = light.filter(|light| !is_lost(light));
        self.world.lights.extend(light.map(|what| OnNode { joint, moves, what }));
        Ok(())
    }
}
