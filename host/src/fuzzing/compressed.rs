//! Scenes around compressed bytes, so that the fuzzer's bytes reach the decoders as bytes of a file.

use serde_json::{Value, json};

use caustics_scene as scene;

/// Three corners of a triangle (m), then their texture coordinates; stored as little-endian floats.
const TRIANGLE: [f32; 15] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
/// Size of the corners (bytes).
const CORNERS: usize = 36;
/// Modes of EXT_meshopt_compression; its filters follow.
const MODES: [&str; 3] = ["ATTRIBUTES", "TRIANGLES", "INDICES"];
const FILTERS: [&str; 5] = ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"];

/// Returns a GLB file of a document and its single buffer.
fn glb(mut document: Value, buffer: &[u8]) -> Vec<u8> {
    document["asset"] = json!({ "version": "2.0" });
    document["scenes"] = json!([{ "nodes": [0] }]);
    document["nodes"] = json!([{ "mesh": 0 }]);
    document["buffers"] = json!([{ "byteLength": buffer.len() }]);
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut padded = buffer.to_vec();
    padded.resize(buffer.len().next_multiple_of(4), 0);
    let word = |length: usize| (length as u32).to_le_bytes();
    let length = 12 + 8 + text.len() + 8 + padded.len();
    [
        b"glTF",
        &word(2)[..],
        &word(length),
        &word(text.len()),
        b"JSON",
        &text,
        &word(padded.len()),
        b"BIN\0",
        &padded,
    ]
    .concat()
}

/// Returns a file of a triangle whose buffer ends with these bytes. Their buffer view is the third; `view` holds its
/// extensions.
fn beside_a_triangle(mut document: Value, view: Value, bytes: &[u8]) -> Vec<u8> {
    let triangle: Vec<u8> = TRIANGLE.iter().flat_map(|number| number.to_le_bytes()).collect();
    let mut last = json!({ "buffer": 0, "byteOffset": triangle.len(), "byteLength": bytes.len() });
    if view != Value::Null {
        last["extensions"] = view;
    }
    document["bufferViews"] = json!([
        { "buffer": 0, "byteLength": CORNERS },
        { "buffer": 0, "byteOffset": CORNERS, "byteLength": triangle.len() - CORNERS },
        last,
    ]);
    document["accessors"] = json!([
        { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
        { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2" },
    ]);
    let attributes = json!({ "POSITION": 0, "TEXCOORD_0": 1 });
    document["meshes"] = json!([{ "primitives": [{ "attributes": attributes, "material": 0 }] }]);
    if document.get("materials").is_none() {
        document["materials"] = json!([{}]);
    }
    glb(document, &[&triangle[..], bytes].concat())
}

/// Reads a primitive compressed by Draco: numbers of its points and faces (16 bits each), then the stream.
pub fn draco(bytes: &[u8]) -> bool {
    let Some((&[a, b, c, d], stream)) = bytes.split_first_chunk() else { return false };
    let (points, faces) = (u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]));
    let extension = json!({ "bufferView": 0, "attributes": { "NORMAL": 0, "POSITION": 1 } });
    let primitive = json!({
        "attributes": { "NORMAL": 1, "POSITION": 2 },
        "indices": 0,
        "extensions": { "KHR_draco_mesh_compression": extension },
    });
    let document = json!({
        "extensionsUsed": ["KHR_draco_mesh_compression"],
        "extensionsRequired": ["KHR_draco_mesh_compression"],
        "bufferViews": [{ "buffer": 0, "byteLength": stream.len() }],
        "accessors": [
            { "componentType": 5125, "count": 3 * u32::from(faces), "type": "SCALAR" },
            { "componentType": 5126, "count": points, "type": "VEC3" },
            { "componentType": 5126, "count": points, "type": "VEC3", "min": [-1, -1, -1], "max": [1, 1, 1] },
        ],
        "meshes": [{ "primitives": [primitive] }],
    });
    scene::read(&glb(document, stream)).is_ok()
}

/// Reads a buffer view compressed by meshoptimizer: mode and filter (four bits each), stride (bytes), number of elements
/// (16 bits), then the stream.
pub fn meshopt(bytes: &[u8]) -> bool {
    let Some((&[kind, stride, a, b], stream)) = bytes.split_first_chunk() else { return false };
    let [mode, filter] = [kind & 15, kind >> 4].map(usize::from);
    let extension = json!({
        "buffer": 0,
        "byteOffset": size_of_val(&TRIANGLE),
        "byteLength": stream.len(),
        "byteStride": stride,
        "count": u16::from_le_bytes([a, b]),
        "mode": MODES[mode % MODES.len()],
        "filter": FILTERS[filter % FILTERS.len()],
    });
    let required = json!(["EXT_meshopt_compression"]);
    let document = json!({ "extensionsUsed": required, "extensionsRequired": required });
    let view = json!({ "EXT_meshopt_compression": extension });
    scene::read(&beside_a_triangle(document, view, stream)).is_ok()
}

/// Reads a KTX 2.0 image as a texture.
pub fn ktx2(bytes: &[u8]) -> bool {
    texture("KHR_texture_basisu", "image/ktx2", bytes)
}

/// Reads a WebP image as a texture.
pub fn webp(bytes: &[u8]) -> bool {
    texture("EXT_texture_webp", "image/webp", bytes)
}

fn texture(extension: &str, mime_type: &str, bytes: &[u8]) -> bool {
    let document = json!({
        "extensionsUsed": [extension],
        "extensionsRequired": [extension],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
        "textures": [{ "extensions": { extension: { "source": 0 } } }],
        "images": [{ "bufferView": 2, "mimeType": mime_type }],
    });
    // The reader leaves out an image that it cannot decode, with a warning.
    let is_left_out = |scene: &scene::Scene| scene.warnings.iter().any(|warning| warning.contains("image"));
    scene::read(&beside_a_triangle(document, Value::Null, bytes)).is_ok_and(|scene| !is_left_out(&scene))
}

/// Decodes a Radiance HDR or EXR file of an environment. Building the scene's tables of it is left out: that takes half a
/// second for any texels.
pub fn environment(bytes: &[u8]) -> bool {
    scene::EnvironmentMap::decode(bytes).is_ok()
}
