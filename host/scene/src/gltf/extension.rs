//! Extensions of a document's elements, as plain JSON: the document types drop them.

use std::collections::HashMap;

use serde_json::Value;

/// Names of the compression of buffer views; both have the same members.
const COMPRESSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Light from all around.
pub const IMAGE_BASED: &str = "EXT_lights_image_based";

/// A primitive that is compressed.
pub struct Compressed {
    /// Its mesh.
    pub mesh: usize,
    /// Which of the mesh it is.
    pub primitive: usize,
    /// Its extension KHR_draco_mesh_compression.
    pub extension: Value,
}

/// All compressed primitives of a document.
pub fn compressed_primitives(document: &Value) -> Vec<Compressed> {
    let mut found = Vec::new();
    for (mesh, element) in document["meshes"].as_array().into_iter().flatten().enumerate() {
        for (primitive, element) in element["primitives"].as_array().into_iter().flatten().enumerate() {
            let extension = &element["extensions"]["KHR_draco_mesh_compression"];
            if extension.is_object() {
                found.push(Compressed { mesh, primitive, extension: extension.clone() });
            }
        }
    }
    found
}

/// How a buffer view is compressed.
pub fn compression(view: &Value) -> Option<&Value> {
    COMPRESSIONS
        .iter()
        .find_map(|name| view["extensions"].get(name))
        .filter(|extension| extension.is_object())
}

/// Which buffers only stand in for readers that decompress no views: their bytes need not be there. They say so, or have no
/// bytes and are of compressed views alone.
pub fn fallbacks(document: &Value, has_binary: bool) -> Vec<bool> {
    let list = |section: &str| document[section].as_array().map_or(&[][..], Vec::as_slice);
    let (buffers, views) = (list("buffers"), list("bufferViews"));
    let mut is_read = vec![false; buffers.len()];
    let mut is_compressed = is_read.clone();
    let mark = |flags: &mut Vec<bool>, view: &Value| {
        let buffer = view["buffer"].as_u64().and_then(|buffer| flags.get_mut(buffer as usize));
        buffer.into_iter().for_each(|mark| *mark = true);
    };
    for view in views {
        match compression(view) {
            Some(compression) => {
                mark(&mut is_read, compression);
                mark(&mut is_compressed, view);
            }
            None => mark(&mut is_read, view),
        }
    }
    let is_fallback =
        |buffer: &Value| COMPRESSIONS.iter().any(|name| buffer["extensions"][name]["fallback"] == true);
    let is_empty = |id: usize| buffers[id]["uri"].is_null() && !(has_binary && id == 0);
    (0..buffers.len())
        .map(|id| is_fallback(&buffers[id]) || is_empty(id) && is_compressed[id] && !is_read[id])
        .collect()
}

/// Attributes of EXT_mesh_gpu_instancing, by node.
pub fn instances(document: &Value) -> HashMap<usize, Value> {
    let nodes = document["nodes"].as_array().into_iter().flatten().enumerate();
    let attributes =
        nodes.map(|(id, node)| (id, &node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]));
    attributes.filter(|(_, attributes)| attributes.is_object()).map(|(id, all)| (id, all.clone())).collect()
}

/// The light of EXT_lights_image_based that a scene refers to, or what is wrong with its reference.
pub fn image_based(document: &Value, scene: &Value) -> Option<Result<Value, String>> {
    let index = scene["extensions"][IMAGE_BASED]["light"].as_u64()?;
    let lights = document["extensions"][IMAGE_BASED]["lights"].as_array().map_or(&[][..], Vec::as_slice);
    let found = usize::try_from(index).ok().and_then(|index| lights.get(index));
    let missing = || format!("the scene refers to light {index}, but there are {}", lights.len());
    Some(found.cloned().ok_or_else(missing))
}
