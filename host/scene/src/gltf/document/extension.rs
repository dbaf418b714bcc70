//! Extensions of a document's elements that the crate gltf drops.

use std::collections::{BTreeMap, HashMap};

use gltf::json::Index;
use gltf::json::accessor::Accessor;
use serde::Deserialize;
use serde_json::Value;

use super::members::or_default;

/// Names of the compression of buffer views; both have the same members.
const COMPRESSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Name of the extension of environment lights.
pub const IMAGE_BASED: &str = "EXT_lights_image_based";

/// EXT_meshopt_compression of a buffer view.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Compression {
    /// Index of the buffer with the stream.
    pub buffer: Option<usize>,
    /// Offset of the stream (bytes).
    pub byte_offset: Option<u64>,
    /// Length of the stream (bytes).
    pub byte_length: Option<u64>,
    /// Size of a decoded element (bytes).
    pub byte_stride: Option<u64>,
    /// Number of decoded elements.
    pub count: Option<u64>,
    /// Kind of the elements.
    pub mode: Option<String>,
    /// Filter after decoding.
    pub filter: Option<String>,
}

/// A compressed primitive.
#[derive(Clone, Debug)]
pub struct DracoPrimitive {
    /// Index of the mesh.
    pub mesh: usize,
    /// Index of the primitive in the mesh.
    pub primitive: usize,
    /// Compressed stream.
    pub stream: DracoStream,
}

/// KHR_draco_mesh_compression of a primitive.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct DracoStream {
    /// Index of the buffer view.
    pub buffer_view: Option<usize>,
    /// Ids of attributes in the stream, by the names of the attributes.
    #[serde(deserialize_with = "or_default")]
    pub attributes: BTreeMap<String, Option<u64>>,
}

/// Attributes of EXT_mesh_gpu_instancing.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE", default)]
pub struct InstanceAttributes {
    /// Accessor of translations.
    pub translation: Option<Index<Accessor>>,
    /// Accessor of rotations.
    pub rotation: Option<Index<Accessor>>,
    /// Accessor of scales.
    pub scale: Option<Index<Accessor>>,
}

/// Light of EXT_lights_image_based.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct ImageBasedLight {
    /// Factor on all radiances.
    pub intensity: Option<f64>,
    /// Quaternion, not necessarily of unit length.
    pub rotation: Option<[f64; 4]>,
    /// Coefficients of the irradiance.
    pub irradiance_coefficients: Option<Vec<[f64; 3]>>,
    /// Indices of the images of the faces, by level.
    #[serde(deserialize_with = "or_default")]
    pub specular_images: Vec<Vec<usize>>,
}

/// Elements of a section.
fn elements<'a>(document: &'a Value, section: &str) -> &'a [Value] {
    document[section].as_array().map_or(&[], Vec::as_slice)
}

/// Returns all compressed primitives of a document.
pub fn draco_primitives(document: &Value) -> Result<Vec<DracoPrimitive>, serde_json::Error> {
    let mut found = Vec::new();
    for (mesh, element) in elements(document, "meshes").iter().enumerate() {
        for (primitive, element) in elements(element, "primitives").iter().enumerate() {
            let extension = &element["extensions"]["KHR_draco_mesh_compression"];
            if extension.is_object() {
                found.push(DracoPrimitive { mesh, primitive, stream: DracoStream::deserialize(extension)? });
            }
        }
    }
    Ok(found)
}

/// Compression of each buffer view.
pub fn compressions(document: &Value) -> Result<Vec<Option<Compression>>, serde_json::Error> {
    let read = |view: &Value| compression(view).map(Compression::deserialize).transpose();
    elements(document, "bufferViews").iter().map(read).collect()
}

/// Compression extension of a buffer view, if any.
fn compression(view: &Value) -> Option<&Value> {
    COMPRESSIONS
        .iter()
        .find_map(|name| view["extensions"].get(name))
        .filter(|extension| extension.is_object())
}

/// Marks fallback buffers, which serve readers that cannot decompress views and need no bytes. Either the document marks them, or
/// they have no bytes and only compressed views use them.
pub fn fallbacks(document: &Value, has_binary: bool) -> Vec<bool> {
    let (buffers, views) = (elements(document, "buffers"), elements(document, "bufferViews"));
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

/// Attributes of the instances of nodes' meshes, by the index of the node.
pub fn instances(document: &Value) -> Result<HashMap<usize, InstanceAttributes>, serde_json::Error> {
    let mut found = HashMap::new();
    for (id, node) in elements(document, "nodes").iter().enumerate() {
        let attributes = &node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
        if attributes.is_object() {
            found.insert(id, InstanceAttributes::deserialize(attributes)?);
        }
    }
    Ok(found)
}

/// Light of EXT_lights_image_based of a scene, or the fault of its reference.
pub fn image_based(document: &Value, scene: &Value) -> Option<Result<ImageBasedLight, String>> {
    let index = scene["extensions"][IMAGE_BASED]["light"].as_u64()?;
    let lights = elements(&document["extensions"][IMAGE_BASED], "lights");
    let light = usize::try_from(index).ok().and_then(|index| lights.get(index));
    let missing = || format!("the scene refers to light {index}, but there are {}", lights.len());
    let read = |light: &Value| ImageBasedLight::deserialize(light).map_err(|error| error.to_string());
    Some(light.ok_or_else(missing).and_then(read))
}
