//! Writes glTF 2.0: one JSON document and one binary buffer.

use glam::{DMat3, DQuat, DVec3, Vec2, Vec3};
use serde_json::{Value, json};

use crate::mesh::Mesh;

mod animation;

pub use animation::{Interpolation, Property};

/// Index of a node; returned when it is added.
#[derive(Clone, Copy, Debug)]
pub struct Node(usize);

/// Index of a material; returned by [`Document::material`].
#[derive(Clone, Copy, Debug)]
pub struct MaterialId(usize);

/// Index of a mesh, for any number of nodes; returned by [`Document::shape`].
#[derive(Clone, Copy, Debug)]
pub struct Shape(usize);

/// Index of a texture; returned by [`Document::texture`].
#[derive(Clone, Copy, Debug)]
pub struct Texture(usize);

impl Texture {
    /// Reference of a material to the texture.
    pub fn info(self) -> Value {
        json!({ "index": self.0 })
    }
}

/// Builder of a glTF document.
#[derive(Default)]
pub struct Document {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    materials: Vec<Value>,
    meshes: Vec<Value>,
    cameras: Vec<Value>,
    lights: Vec<Value>,
    nodes: Vec<Value>,
    images: Vec<Value>,
    /// Indices of nodes with a parent.
    children: Vec<usize>,
    channels: Vec<Value>,
    samplers: Vec<Value>,
    extensions: Vec<String>,
}

/// A Lambertian material of this albedo.
pub fn lambert(albedo: [f64; 3]) -> Value {
    json!({
        "extensions": { "KHR_materials_specular": { "specularFactor": 0.0 } },
        "pbrMetallicRoughness": pbr(albedo, 0.0, 1.0),
    })
}

/// A metal; a delta mirror below roughness 0.08.
pub fn metal(color: [f64; 3], roughness: f64) -> Value {
    json!({ "pbrMetallicRoughness": pbr(color, 1.0, roughness) })
}

/// A Lambertian under a smooth dielectric coat of index 1.5 and this roughness.
pub fn coated(albedo: [f64; 3], roughness: f64) -> Value {
    json!({ "pbrMetallicRoughness": pbr(albedo, 0.0, roughness) })
}

/// A volume of this index of refraction that attenuates white to `color` after `distance` (m).
pub fn tinted(ior: f64, color: [f64; 3], distance: f64) -> Value {
    let mut material = glass(ior, 0.05);
    let volume = &mut material["extensions"]["KHR_materials_volume"];
    volume["attenuationColor"] = json!(color);
    volume["attenuationDistance"] = json!(distance);
    material
}

/// Clear glass with a volume.
pub fn glass(ior: f64, thickness: f64) -> Value {
    json!({
        "extensions": {
            "KHR_materials_ior": { "ior": ior },
            "KHR_materials_transmission": { "transmissionFactor": 1.0 },
            "KHR_materials_volume": { "thicknessFactor": thickness },
        },
        "pbrMetallicRoughness": pbr([1.0; 3], 0.0, 0.0),
    })
}

/// A black material that emits `strength` times `color` (W m^-2 sr^-1) from its front.
pub fn emitter(color: [f64; 3], strength: f64) -> Value {
    json!({
        "emissiveFactor": color,
        "extensions": {
            "KHR_materials_emissive_strength": { "emissiveStrength": strength },
            "KHR_materials_specular": { "specularFactor": 0.0 },
        },
        "pbrMetallicRoughness": pbr([0.0; 3], 0.0, 1.0),
    })
}

fn pbr(color: [f64; 3], metallic: f64, roughness: f64) -> Value {
    json!({
        "baseColorFactor": [color[0], color[1], color[2], 1.0],
        "metallicFactor": metallic,
        "roughnessFactor": roughness,
    })
}

/// Rotation of a camera that looks from `eye` at `target`, y upwards.
pub fn looking(eye: DVec3, target: DVec3) -> DQuat {
    let back = (eye - target).normalize();
    let right = DVec3::Y.cross(back).normalize();
    DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back))
}

impl Document {
    /// Adds a material.
    pub fn material(&mut self, name: &str, mut material: Value) -> MaterialId {
        let used = material["extensions"].as_object().into_iter().flat_map(|extensions| extensions.keys());
        self.extensions.extend(used.cloned());
        material["name"] = name.into();
        self.materials.push(material);
        MaterialId(self.materials.len() - 1)
    }

    /// Adds a repeating texture of an image file beside the document.
    pub fn texture(&mut self, file: &str) -> Texture {
        self.images.push(json!({ "uri": file }));
        Texture(self.images.len() - 1)
    }

    /// Adds a mesh of one material, and a node with it.
    pub fn mesh(&mut self, name: &str, material: MaterialId, mesh: &Mesh) -> Node {
        let shape = self.shape(name, &[(material, mesh)]);
        self.node(name, shape)
    }

    /// Adds a mesh with a primitive for each material, without a node.
    pub fn shape(&mut self, name: &str, parts: &[(MaterialId, &Mesh)]) -> Shape {
        let primitives: Vec<_> =
            parts.iter().map(|(material, mesh)| self.primitive(name, *material, mesh)).collect();
        self.meshes.push(json!({ "name": name, "primitives": primitives }));
        Shape(self.meshes.len() - 1)
    }

    /// Adds a node with this shape.
    pub fn node(&mut self, name: &str, shape: Shape) -> Node {
        self.nodes.push(json!({ "mesh": shape.0, "name": name }));
        Node(self.nodes.len() - 1)
    }

    fn primitive(&mut self, name: &str, material: MaterialId, mesh: &Mesh) -> Value {
        let positions = self.vectors(&mesh.positions, true);
        let normals = self.vectors(&mesh.normals, false);
        let mut attributes = json!({ "NORMAL": normals, "POSITION": positions });
        if !mesh.uvs.is_empty() {
            assert_eq!(
                mesh.uvs.len(),
                mesh.positions.len(),
                "every vertex of {name} has coordinates, or none"
            );
            attributes["TEXCOORD_0"] = json!(self.pairs(&mesh.uvs));
        }
        let indices = self.indices(&mesh.indices);
        json!({ "attributes": attributes, "indices": indices, "material": material.0 })
    }

    /// Adds a camera at `eye` that looks at `target`, with a vertical field of view (rad) and y upwards.
    pub fn camera(&mut self, name: &str, eye: DVec3, target: DVec3, fov_y: f64, aspect: f64) -> Node {
        let rotation = looking(eye, target);
        self.nodes.push(json!({
            "camera": self.cameras.len(),
            "name": name,
            "rotation": rotation.as_quat().to_array(),
            "translation": eye.to_array(),
        }));
        self.cameras.push(json!({
            "name": name,
            "perspective": { "aspectRatio": aspect, "yfov": fov_y as f32, "znear": 0.01 },
            "type": "perspective",
        }));
        Node(self.nodes.len() - 1)
    }

    /// Adds a spot light at `position` that points at `target`. On its axis it emits `color` times `intensity` (W sr^-1). `cone`
    /// holds the angles from the axis (rad) at which it starts to fade, and at which it is dark.
    pub fn spot(
        &mut self,
        name: &str,
        position: DVec3,
        target: DVec3,
        color: [f64; 3],
        intensity: f64,
        cone: [f64; 2],
    ) -> Node {
        self.extensions.push("KHR_lights_punctual".into());
        self.nodes.push(json!({
            "extensions": { "KHR_lights_punctual": { "light": self.lights.len() } },
            "name": name,
            "rotation": looking(position, target).as_quat().to_array(),
            "translation": position.to_array(),
        }));
        self.lights.push(json!({
            "color": color,
            "intensity": intensity,
            "name": name,
            "spot": { "innerConeAngle": cone[0], "outerConeAngle": cone[1] },
            "type": "spot",
        }));
        Node(self.nodes.len() - 1)
    }

    fn view(&mut self, bytes: &[u8], target: u32) -> usize {
        let view = self.plain_view(bytes);
        self.views[view]["target"] = target.into();
        view
    }

    /// Adds a view of other data than vertices and indices.
    fn plain_view(&mut self, bytes: &[u8]) -> usize {
        self.views.push(json!({
            "buffer": 0, "byteLength": bytes.len(), "byteOffset": self.binary.len(),
        }));
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn vectors(&mut self, vectors: &[Vec3], with_bounds: bool) -> usize {
        let bytes: Vec<u8> = vectors.iter().flat_map(|v| v.to_array()).flat_map(f32::to_le_bytes).collect();
        let mut accessor = json!({
            "bufferView": self.view(&bytes, 34962), "componentType": 5126, "count": vectors.len(), "type": "VEC3",
        });
        if with_bounds {
            let bound =
                |pick: fn(Vec3, Vec3) -> Vec3| vectors.iter().copied().reduce(pick).unwrap().to_array();
            accessor["min"] = json!(bound(Vec3::min));
            accessor["max"] = json!(bound(Vec3::max));
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn pairs(&mut self, pairs: &[Vec2]) -> usize {
        let bytes: Vec<u8> = pairs.iter().flat_map(|v| v.to_array()).flat_map(f32::to_le_bytes).collect();
        let view = self.view(&bytes, 34962);
        self.accessors.push(json!({
            "bufferView": view, "componentType": 5126, "count": pairs.len(), "type": "VEC2",
        }));
        self.accessors.len() - 1
    }

    fn indices(&mut self, indices: &[u32]) -> usize {
        let is_short = indices.iter().all(|&index| index < u32::from(u16::MAX));
        let bytes: Vec<u8> = if is_short {
            indices.iter().flat_map(|&index| (index as u16).to_le_bytes()).collect()
        } else {
            indices.iter().flat_map(|index| index.to_le_bytes()).collect()
        };
        let view = self.view(&bytes, 34963);
        self.accessors.push(json!({
            "bufferView": view,
            "componentType": if is_short { 5123 } else { 5125 },
            "count": indices.len(),
            "type": "SCALAR",
        }));
        self.accessors.len() - 1
    }

    /// Encodes the document and its buffer, which the document refers to as `scene.bin`.
    pub fn encode(mut self) -> (Vec<u8>, Vec<u8>) {
        self.extensions.sort();
        self.extensions.dedup();
        let mut document = json!({
            "accessors": self.accessors,
            "asset": { "generator": "caustics scene make", "version": "2.0" },
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.binary.len(), "uri": "scene.bin" }],
            "cameras": self.cameras,
            "extensionsUsed": self.extensions,
            "materials": self.materials,
            "meshes": self.meshes,
            "nodes": self.nodes,
            "scene": 0,
            "scenes": [{ "nodes": (0..self.nodes.len()).filter(|node| !self.children.contains(node)).collect::<Vec<_>>() }],
        });
        if !self.channels.is_empty() {
            document["animations"] = json!([{ "channels": self.channels, "samplers": self.samplers }]);
        }
        if !self.lights.is_empty() {
            document["extensions"] = json!({ "KHR_lights_punctual": { "lights": self.lights } });
        }
        if !self.images.is_empty() {
            let textures = (0..self.images.len()).map(|image| json!({ "source": image }));
            document["textures"] = textures.collect();
            document["images"] = json!(self.images);
        }
        // Sort keys: their order must not depend on serde_json features that other crates enable.
        document.sort_all_objects();
        let mut json = serde_json::to_vec_pretty(&document).expect("a JSON value can be written");
        json.push(b'\n');
        (json, self.binary)
    }
}
