//! Files with extensions, one or two each, and files with missing parts.

use glam::DVec3;
use serde_json::{Value, json};

use super::paint;
use super::small::Small;
use super::surfaces::{checks, panel, textured, wall};
use crate::mesh::Mesh;
use crate::texture::draw;

fn floor() -> Mesh {
    Mesh::default().panel(DVec3::ZERO, DVec3::Z * 1.5, DVec3::X * 1.5)
}

fn ball(x: f64) -> Mesh {
    Mesh::default().sphere(DVec3::new(x, 0.4, 0.0), 0.4, 24, 12)
}

/// Two balls on a floor, with these materials.
fn balls(materials: [Value; 2]) -> Small {
    let mut small = Small::new();
    small.thing(paint([0.7, 0.7, 0.7]), &floor());
    for (material, x) in materials.into_iter().zip([-0.5, 0.5]) {
        small.thing(material, &ball(x));
    }
    small
}

pub fn blend() -> Small {
    let mut small = Small::new();
    wall(&mut small);
    let texture = small.texture(&draw(16, |u, _| [220, 120, 40, (255.0 * u) as u8]));
    let mut material = textured(&json!({ "index": texture }));
    material["pbrMetallicRoughness"]["baseColorFactor"] = json!([1.0, 1.0, 1.0, 0.8]);
    material["alphaMode"] = json!("BLEND");
    small.thing(material, &panel());
    small
}

pub fn environment() -> Small {
    let metal = json!({ "pbrMetallicRoughness": { "metallicFactor": 1.0, "roughnessFactor": 0.0 } });
    let mut small = balls([paint([0.8, 0.4, 0.2]), metal]);
    small.json["scenes"][0]["extras"] = json!({ "environment": { "color": [0.4, 0.7, 1.0], "scale": 0.5 } });
    small
}

pub fn sparse() -> Small {
    let mut small = Small::new();
    let material = small.push("materials", paint([0.3, 0.7, 0.5]));
    let grid = Mesh::default().grid(DVec3::new(0.0, 0.5, 0.0), DVec3::X, DVec3::Y * 0.5, 4);
    let mesh = small.mesh(material, &grid);
    small.root(json!({ "mesh": mesh }));
    // Some vertices of the first mesh stand out. In the second mesh all other vertices are at the origin.
    let moved = [1_u8, 6, 11];
    let moved_positions: Vec<f32> =
        moved.iter().flat_map(|&at| (grid.positions[at as usize] + glam::Vec3::Z * 0.4).to_array()).collect();
    let bytes: Vec<u8> = moved_positions.iter().flat_map(|value| value.to_le_bytes()).collect();
    let (at, values) = (small.view(&moved), small.view(&bytes));
    let sparse = json!({
        "count": moved.len(), "indices": { "bufferView": at, "componentType": 5121 },
        "values": { "bufferView": values },
    });
    let positions = small.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64().unwrap_or(0);
    let accessor = &mut small.json["accessors"][positions as usize];
    accessor["sparse"] = sparse.clone();
    accessor["max"][2] = json!(0.4_f32);
    let ends = |pick: fn(f32, f32) -> f32| {
        moved_positions
            .as_chunks::<3>()
            .0
            .iter()
            .fold([0.0_f32; 3], |a, b| std::array::from_fn(|i| pick(a[i], b[i])))
    };
    let (min, max) = (ends(f32::min), ends(f32::max));
    let fan = small.push(
        "accessors",
        json!({
            "componentType": 5126, "count": grid.positions.len(), "type": "VEC3", "sparse": sparse,
            "min": min, "max": max,
        }),
    );
    let indices = small.indices(&[0, 1, 6, 0, 6, 11]);
    let primitive = json!({ "attributes": { "POSITION": fan }, "indices": indices, "material": material });
    let fan = small.push("meshes", json!({ "primitives": [primitive] }));
    small.root(json!({ "mesh": fan, "translation": [0.0, 0.0, -1.0] }));
    small
}

pub fn variants() -> Small {
    let mut small = balls([paint([0.8, 0.2, 0.1]), paint([0.1, 0.2, 0.8])]);
    small.uses("KHR_materials_variants");
    let names = json!([{ "name": "day" }, { "name": "night" }]);
    small.json["extensions"] = json!({ "KHR_materials_variants": { "variants": names } });
    let other = small.push("materials", paint([0.1, 0.1, 0.1]));
    let mappings = json!({ "mappings": [{ "material": other, "variants": [1] }] });
    small.json["meshes"][1]["primitives"][0]["extensions"] = json!({ "KHR_materials_variants": mappings });
    small
}

pub fn clearcoat() -> Small {
    let coated = |roughness: f64| {
        let mut material = paint([0.6, 0.1, 0.1]);
        material["extensions"] = json!({ "KHR_materials_clearcoat": {
            "clearcoatFactor": 1.0, "clearcoatRoughnessFactor": roughness,
        } });
        material
    };
    let mut small = balls([coated(0.0), coated(0.3)]);
    small.uses("KHR_materials_clearcoat");
    small
}

pub fn specular_glossiness() -> Small {
    let material = |diffuse: [f64; 4], specular: [f64; 3], glossiness: f64| {
        json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": diffuse, "specularFactor": specular, "glossinessFactor": glossiness,
        } } })
    };
    let gold = material([0.0, 0.0, 0.0, 1.0], [0.9, 0.7, 0.3], 0.9);
    let mut small = balls([gold, material([0.2, 0.6, 0.3, 1.0], [0.04; 3], 0.5)]);
    small.uses("KHR_materials_pbrSpecularGlossiness");
    small
}

pub fn unlit() -> Small {
    let mut flat = paint([0.9, 0.8, 0.1]);
    flat["extensions"] = json!({ "KHR_materials_unlit": {} });
    let mut small = balls([flat, paint([0.9, 0.8, 0.1])]);
    small.uses("KHR_materials_unlit");
    small
}

pub fn vertex_colors() -> Small {
    let mut small = balls([paint([1.0, 1.0, 1.0]), paint([1.0, 1.0, 1.0])]);
    // Three varying floats, and four constant bytes.
    let count = ball(0.0).positions.len();
    let stripes: Vec<f32> =
        (0..count).flat_map(|at| if at % 2 == 0 { [0.9, 0.2, 0.1] } else { [0.1, 0.3, 0.9] }).collect();
    let varying = small.floats("VEC3", count, &stripes);
    let view = small.view(&[51, 204, 102, 255].repeat(count));
    let even = small.push(
        "accessors",
        json!({
            "bufferView": view, "componentType": 5121, "normalized": true, "count": count, "type": "VEC4",
        }),
    );
    for (mesh, colors) in [(1, varying), (2, even)] {
        small.json["meshes"][mesh]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
    }
    small
}

pub fn instancing() -> Small {
    let mut small = Small::new();
    small.uses("EXT_mesh_gpu_instancing");
    small.thing(paint([0.7, 0.7, 0.7]), &floor());
    let block = Mesh::default().block(DVec3::new(-0.1, 0.0, -0.1), DVec3::new(0.1, 0.4, 0.1));
    let node = small.thing(paint([0.8, 0.5, 0.1]), &block);
    let (sin, cos) = 0.4_f32.sin_cos();
    let translations: Vec<f32> = (0..5).flat_map(|i| [i as f32 * 0.4 - 0.8, 0.0, -0.2 * i as f32]).collect();
    let rotations: Vec<f32> =
        (0..5).flat_map(|i| if i % 2 == 0 { [0.0, sin, 0.0, cos] } else { [0.0, 0.0, 0.0, 1.0] }).collect();
    let scales: Vec<f32> = (0..5).flat_map(|i| [1.0, 0.5 + 0.4 * i as f32, 1.0]).collect();
    let attributes = json!({
        "TRANSLATION": small.floats("VEC3", 5, &translations),
        "ROTATION": small.floats("VEC4", 5, &rotations),
        "SCALE": small.floats("VEC3", 5, &scales),
    });
    small.json["nodes"][node]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    small
}

pub fn second_coordinates() -> Small {
    let mut small = Small::new();
    let texture = small.texture(&checks());
    let mut material = textured(&json!({ "index": texture, "texCoord": 1 }));
    // A texture without an image, such as an extension may add: only its factor is rendered.
    let empty = small.push("textures", json!({}));
    material["emissiveTexture"] = json!({ "index": empty });
    small.thing(material, &panel());
    let attributes = &mut small.json["meshes"][0]["primitives"][0]["attributes"];
    let first = attributes["TEXCOORD_0"].clone();
    let count = panel().uvs.len();
    attributes["TEXCOORD_1"] = first;
    let zero = small.floats("VEC2", count, &vec![0.0; 2 * count]);
    small.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(zero);
    small
}

pub fn left_out() -> Small {
    let mut small = balls([paint([0.2, 0.6, 0.7]), paint([0.7, 0.3, 0.6])]);
    for extension in ["KHR_xmp_json_ld", "VENDOR_unheard_of"] {
        small.uses(extension);
    }
    small.json["extensionsRequired"] = json!(["VENDOR_unheard_of"]);
    for member in ["version", "minVersion"] {
        small.json["asset"][member] = json!("2.1");
    }
    small.json["extensions"] = json!({ "KHR_xmp_json_ld": { "packets": [{ "dc:title": "corpus" }] } });
    let indices = small.indices(&[0, 1, 2, 3]);
    let positions = small.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].clone();
    for mode in [0, 1, 2, 3] {
        let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices, "mode": mode });
        small.json["meshes"][0]["primitives"].as_array_mut().expect("a list").push(primitive);
    }
    let across = json!({ "xmag": 1.0, "ymag": 1.0, "zfar": 10.0, "znear": 0.0 });
    let camera = small.push("cameras", json!({ "type": "orthographic", "orthographic": across }));
    small.root(json!({ "camera": camera, "translation": [0.0, 1.0, 3.0] }));
    small.root(json!({ "mesh": 1, "scale": [0.0, 0.0, 0.0] }));
    // Neither the first nor the default scene shows a mesh. The first lacks a list of nodes.
    let nodes = small.json["scenes"][0]["nodes"].clone();
    small.json["scenes"] = json!([{ "name": "empty" }, { "nodes": nodes }]);
    small
}
