//! glTF documents for tests that need a scene from a file: blocks of a few materials on nodes that may move.

use std::path::{Path, PathBuf};

use caustics::scene::{LoadOptions, Scene};
use glam::DVec3;
use serde_json::{Value, json};

/// A document under construction. The caller writes camera, lights and other content into `json`.
#[derive(Clone, Debug)]
pub struct Document {
    /// The document without its buffer.
    pub json: Value,
    binary: Vec<u8>,
}

impl Default for Document {
    fn default() -> Document {
        let lists = ["accessors", "bufferViews", "materials", "meshes", "nodes"];
        let mut json = json!({ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [] }] });
        lists.into_iter().for_each(|list| json[list] = json!([]));
        Document { json, binary: Vec::new() }
    }
}

/// Clear glass with a volume.
pub fn glass(ior: f64) -> Value {
    json!({
        "extensions": {
            "KHR_materials_ior": { "ior": ior },
            "KHR_materials_transmission": { "transmissionFactor": 1.0 },
            "KHR_materials_volume": { "thicknessFactor": 0.1 },
        },
        "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.0 },
    })
}

/// Lambertian of this albedo.
pub fn lambert(albedo: f64) -> Value {
    json!({
        "extensions": { "KHR_materials_specular": { "specularFactor": 0.0 } },
        "pbrMetallicRoughness": {
            "baseColorFactor": [albedo, albedo, albedo, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0,
        },
    })
}

/// Black emitter of this radiance (W m^-2 sr^-1) on its front side.
pub fn emitter(radiance: f64) -> Value {
    let mut material = lambert(0.0);
    material["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
    material["extensions"]["KHR_materials_emissive_strength"] = json!({ "emissiveStrength": radiance });
    material
}

impl Document {
    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    /// Adds a material and returns its index.
    pub fn material(&mut self, material: Value) -> usize {
        self.push("materials", material)
    }

    /// Adds an accessor of floats and returns its index.
    fn floats(&mut self, kind: &str, components: usize, values: &[f64]) -> usize {
        let start = self.binary.len();
        self.binary.extend(values.iter().flat_map(|value| (*value as f32).to_le_bytes()));
        let length = self.binary.len() - start;
        let view = json!({ "buffer": 0, "byteOffset": start, "byteLength": length });
        let view = self.push("bufferViews", view);
        let component =
            |component: usize| values.iter().skip(component).step_by(components).map(|value| *value as f32);
        let bounds = |pick: fn(f32, f32) -> f32| {
            (0..components).map(|index| component(index).reduce(pick)).collect::<Vec<_>>()
        };
        let (min, max) = (bounds(f32::min), bounds(f32::max));
        self.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": 5126, "count": values.len() / components, "type": kind,
                "min": min, "max": max,
            }),
        )
    }

    /// Returns the primitive of an axis-aligned block of a material; `inwards` turns its fronts to the inside.
    pub fn block(&mut self, material: usize, min: DVec3, max: DVec3, inwards: bool) -> Value {
        let (centre, half) = (0.5 * (min + max), 0.5 * (max - min));
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let unit = |axis: usize| DVec3::AXES[axis % 3] * half[axis % 3];
                let (right, up) = (sign * unit(axis + 1), unit(axis + 2));
                let (right, up) = if inwards { (up, right) } else { (right, up) };
                let middle = centre + sign * unit(axis);
                let [a, b, c, d] =
                    [middle - right - up, middle + right - up, middle + right + up, middle - right + up];
                positions.extend([a, b, c, a, c, d].iter().flat_map(DVec3::to_array));
                normals.extend([right.cross(up).normalize(); 6].iter().flat_map(DVec3::to_array));
            }
        }
        let (positions, normals) = (self.floats("VEC3", 3, &positions), self.floats("VEC3", 3, &normals));
        json!({ "attributes": { "POSITION": positions, "NORMAL": normals }, "material": material })
    }

    /// Adds a mesh and returns its index.
    pub fn mesh(&mut self, primitives: &[Value]) -> usize {
        self.push("meshes", json!({ "primitives": primitives }))
    }

    /// Adds a node to the scene and returns its index.
    pub fn node(&mut self, node: Value) -> usize {
        let node = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().expect("roots").push(json!(node));
        node
    }

    /// Adds a camera that looks along -z, with this vertical field of view (rad).
    pub fn camera(&mut self, eye: DVec3, fov_y: f64) {
        let perspective = json!({ "aspectRatio": 1.0, "yfov": fov_y, "znear": 0.01 });
        self.json["cameras"] = json!([{ "type": "perspective", "perspective": perspective }]);
        self.node(json!({ "camera": 0, "translation": eye.to_array() }));
    }

    /// Animates a node by translations at times (s).
    pub fn animate(&mut self, node: usize, times: &[f64], translations: &[DVec3]) {
        let translations: Vec<f64> = translations.iter().flat_map(DVec3::to_array).collect();
        let (input, output) = (self.floats("SCALAR", 1, times), self.floats("VEC3", 3, &translations));
        self.json["animations"] = json!([{
            "channels": [{ "sampler": 0, "target": { "node": node, "path": "translation" } }],
            "samplers": [{ "input": input, "output": output }],
        }]);
    }

    /// Writes the document and its buffer into a folder, and returns the document's path.
    pub fn write(&self, folder: &Path) -> PathBuf {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.binary.len(), "uri": "scene.bin" }]);
        let materials = json["materials"].as_array().expect("materials");
        let used = materials.iter().filter_map(|material| material["extensions"].as_object());
        let mut used: Vec<String> = used.flat_map(|extensions| extensions.keys().cloned()).collect();
        used.sort();
        used.dedup();
        json["extensionsUsed"] = json!(used);
        std::fs::write(folder.join("scene.bin"), &self.binary).expect("a buffer");
        let path = folder.join("scene.gltf");
        std::fs::write(&path, json.to_string()).expect("a document");
        path
    }

    /// Loads the scene; meshes of several nodes are copied up to `copies` triangles.
    pub fn load(&self, copies: u64) -> Scene {
        let folder = tempfile::tempdir().expect("a folder");
        let options = LoadOptions { copies, ..LoadOptions::default() };
        let mut scene = Scene::load_with(&self.write(folder.path()), &options).expect("the scene loads");
        scene.pose(0.0).expect("a pose");
        scene
    }
}
