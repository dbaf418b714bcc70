//! Builder of small documents: any JSON, with an embedded buffer.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use crate::mesh::Mesh;

/// A document and its buffer.
pub struct Small {
    /// The document without its buffer.
    pub json: Value,
    binary: Vec<u8>,
}

impl Small {
    /// Creates a document with a default scene without nodes.
    pub fn new() -> Small {
        let json = json!({
            "asset": { "generator": "caustics corpus", "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [] }],
        });
        Small { json, binary: Vec::new() }
    }

    /// Appends to a list of the document; returns the index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        let list = &mut self.json[list];
        if list.is_null() {
            *list = json!([]);
        }
        let list = list.as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    /// Adds a node to the default scene.
    pub fn root(&mut self, node: Value) -> usize {
        let node = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().expect("a list").push(json!(node));
        node
    }

    /// Lists an extension as used.
    pub fn uses(&mut self, extension: &str) {
        self.push("extensionsUsed", json!(extension));
    }

    /// Adds a view of the buffer.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.binary.len();
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.push("bufferViews", json!({ "buffer": 0, "byteLength": bytes.len(), "byteOffset": offset }))
    }

    /// Adds an accessor of vectors, with their bounds.
    pub fn vectors(&mut self, vectors: &[[f32; 3]]) -> usize {
        let bound = |pick: fn(f32, f32) -> f32| {
            vectors.iter().copied().reduce(|a, b| [0, 1, 2].map(|i| pick(a[i], b[i]))).expect("a vector")
        };
        let (min, max) = (bound(f32::min), bound(f32::max));
        let bytes: Vec<u8> = vectors.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.view(&bytes);
        self.push("accessors", json!({
            "bufferView": view, "componentType": 5126, "count": vectors.len(), "type": "VEC3", "min": min, "max": max,
        }))
    }

    /// Adds an accessor of `count` elements of floats.
    pub fn floats(&mut self, kind: &str, count: usize, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.view(&bytes);
        self.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": 5126, "count": count, "type": kind,
            }),
        )
    }

    /// Adds an accessor of indices of two bytes.
    pub fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        let view = self.view(&bytes);
        self.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": 5123, "count": indices.len(), "type": "SCALAR",
            }),
        )
    }

    /// Adds a mesh of one material.
    pub fn mesh(&mut self, material: usize, mesh: &Mesh) -> usize {
        let array = |vectors: &[glam::Vec3]| vectors.iter().map(|v| v.to_array()).collect::<Vec<_>>();
        let positions = self.vectors(&array(&mesh.positions));
        let normals = self.vectors(&array(&mesh.normals));
        let mut attributes = json!({ "POSITION": positions, "NORMAL": normals });
        if !mesh.uvs.is_empty() {
            let uvs: Vec<f32> = mesh.uvs.iter().flat_map(|uv| uv.to_array()).collect();
            attributes["TEXCOORD_0"] = json!(self.floats("VEC2", mesh.uvs.len(), &uvs));
        }
        let indices: Vec<u16> = mesh.indices.iter().map(|&index| index as u16).collect();
        let indices = self.indices(&indices);
        self.push(
            "meshes",
            json!({ "primitives": [
            { "attributes": attributes, "indices": indices, "material": material },
        ] }),
        )
    }

    /// Adds a material, and a node with a mesh of this material.
    pub fn thing(&mut self, material: Value, mesh: &Mesh) -> usize {
        let material = self.push("materials", material);
        let mesh = self.mesh(material, mesh);
        self.root(json!({ "mesh": mesh }))
    }

    /// Adds an image in the buffer, and a texture of it.
    pub fn texture(&mut self, png: &[u8]) -> usize {
        let view = self.view(png);
        let image = self.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
        self.push("textures", json!({ "source": image }))
    }

    /// Writes a .gltf file whose buffer is a data URI.
    pub fn gltf(mut self) -> Vec<u8> {
        let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.binary));
        self.json["buffers"] = json!([{ "byteLength": self.binary.len(), "uri": uri }]);
        self.json.sort_all_objects();
        let mut json = serde_json::to_vec_pretty(&self.json).expect("a JSON value can be written");
        json.push(b'\n');
        json
    }

    /// Writes a .glb file.
    pub fn glb(mut self) -> Vec<u8> {
        self.json["buffers"] = json!([{ "byteLength": self.binary.len() }]);
        self.json.sort_all_objects();
        let mut json = serde_json::to_vec(&self.json).expect("a JSON value can be written");
        json.resize(json.len().next_multiple_of(4), b' ');
        let word = |length: usize| (length as u32).to_le_bytes();
        let whole = 28 + json.len() + self.binary.len();
        let head =
            [b"glTF", &word(2), &word(whole), &word(json.len()), b"JSON"].map(<[u8; 4]>::as_slice).concat();
        [head, json, word(self.binary.len()).into(), b"BIN\0".into(), self.binary].concat()
    }
}
