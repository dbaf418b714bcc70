//! The shown scene: the default scene, or another with a mesh if it has none.

use serde_json::{Value, json};

use super::element::elements;
use crate::SceneError;
use crate::gltf::context::ImportContext;

/// Gives every scene a list of nodes. If the document has meshes, makes a scene with meshes the default scene.
pub fn complete(document: &mut Value, context: &mut ImportContext<'_>) -> Result<(), SceneError> {
    for scene in elements(document, "scenes") {
        if let Some(members) = scene.as_object_mut().filter(|members| !members.contains_key("nodes")) {
            members.insert("nodes".into(), json!([]));
        }
    }
    let scenes = || document["scenes"].as_array().into_iter().flatten();
    let default = document["scene"].as_u64().unwrap_or(0) as usize;
    let is_broken = default >= scenes().count() && !document["scene"].is_null();
    let all = roots(document);
    let shown = scenes().nth(default).map_or_else(|| all.clone(), |scene| indices(&scene["nodes"]));
    let meshes = document["meshes"].as_array().map_or(0, Vec::len);
    if is_broken || meshes == 0 || has_mesh(document, &shown) {
        return Ok(());
    }

    // Find another scene with a mesh, or show all nodes, or else each mesh.
    let other = scenes().position(|scene| has_mesh(document, &indices(&scene["nodes"])));
    let (what, scene) = match other {
        Some(other) => (format!("its scene {default} has no mesh; scene {other} is shown"), other),
        None => {
            let is_placed = has_mesh(document, &all);
            let nodes = if is_placed { all } else { add_nodes(document, meshes) };
            let what = match is_placed {
                true => "its scene has no mesh; all of its nodes are shown",
                false => "no node places its meshes; each is shown as it is",
            };
            (what.into(), add_scene(document, &nodes))
        }
    };
    if context.options.strict {
        let (file, what) = (context.file.into(), what.split(';').next().unwrap_or_default().into());
        return Err(SceneError::NothingToSee { file, what, remedy: "add one to it" });
    }
    document["scene"] = json!(scene);
    context.warn("", what);
    Ok(())
}

/// Indices of a list.
fn indices(list: &Value) -> Vec<usize> {
    list.as_array().into_iter().flatten().filter_map(Value::as_u64).map(|index| index as usize).collect()
}

/// Nodes without a parent.
fn roots(document: &Value) -> Vec<usize> {
    let nodes = document["nodes"].as_array().map_or(&[][..], Vec::as_slice);
    let mut is_child = vec![false; nodes.len()];
    for child in nodes.iter().flat_map(|node| indices(&node["children"])) {
        is_child.get_mut(child).into_iter().for_each(|is_child| *is_child = true);
    }
    (0..nodes.len()).filter(|&node| !is_child[node]).collect()
}

/// Whether any of these nodes or of their descendants has a mesh.
fn has_mesh(document: &Value, roots: &[usize]) -> bool {
    let nodes = document["nodes"].as_array().map_or(&[][..], Vec::as_slice);
    let mut is_seen = vec![false; nodes.len()];
    let mut stack = roots.to_vec();
    while let Some(index) = stack.pop() {
        let Some(node) = nodes.get(index).filter(|_| !std::mem::replace(&mut is_seen[index], true)) else {
            continue;
        };
        if !node["mesh"].is_null() {
            return true;
        }
        stack.extend(indices(&node["children"]));
    }
    false
}

/// Adds a node for each mesh and returns their indices.
fn add_nodes(document: &mut Value, meshes: usize) -> Vec<usize> {
    if !document["nodes"].is_array() {
        document["nodes"] = json!([]);
    }
    let Some(nodes) = document["nodes"].as_array_mut() else { return Vec::new() };
    let first = nodes.len();
    nodes.extend((0..meshes).map(|mesh| json!({ "mesh": mesh })));
    (first..nodes.len()).collect()
}

/// Adds a scene and returns its index.
fn add_scene(document: &mut Value, nodes: &[usize]) -> usize {
    if !document["scenes"].is_array() {
        document["scenes"] = json!([]);
    }
    let Some(scenes) = document["scenes"].as_array_mut() else { return 0 };
    scenes.push(json!({ "nodes": nodes }));
    scenes.len() - 1
}
