//! Node tree of the default scene: transforms of meshes, cameras and lights, in f64.

use std::collections::HashSet;

use gltf::json::Index;
use gltf::json::scene::Node as JsonNode;

use self::walk::Walk;
use super::animation;
use crate::SceneError;
use crate::file_nodes::no_node;
use crate::gltf::context::ImportContext;
use crate::gltf::decoding::model::Model;

pub use self::world::{WorldMesh, WorldNodes};

mod camera;
mod light;
mod transform;
mod walk;
mod world;

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

/// Root nodes of the default scene, or of the first scene, or all nodes without a parent.
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
