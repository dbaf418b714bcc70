//! Files with vertices and indices of various layouts and types.

use glam::DVec3;
use serde_json::json;

use super::paint;
use super::small::Small;
use crate::mesh::Mesh;

pub fn strips_fans() -> Small {
    let mut small = Small::new();
    let material = small.push("materials", paint([0.7, 0.6, 0.2]));
    // A band of squares and a hexagon, each twice: with and without indices.
    let band: Vec<[f32; 3]> =
        (0..8u8).map(|i| [f32::from(i / 2) * 0.3, f32::from(i % 2) * 0.3, 0.1 * f32::from(i)]).collect();
    let mut hexagon = vec![[0.3, 0.8, 0.0]];
    for corner in 0..=6 {
        let (sin, cos) = (f64::from(corner % 6) * std::f64::consts::FRAC_PI_3).sin_cos();
        hexagon.push([0.3 + 0.3 * cos as f32, 0.8 + 0.3 * sin as f32, 0.1]);
    }
    for (mode, vertices, x) in [(5, band, 0.0), (6, hexagon, 0.1)] {
        let positions = small.vectors(&vertices);
        let indices: Vec<u16> = (0..vertices.len() as u16).collect();
        let indices = small.indices(&indices);
        let attributes = json!({ "POSITION": positions });
        let with = small.push(
            "meshes",
            json!({ "primitives": [
            { "attributes": attributes, "indices": indices, "material": material, "mode": mode },
        ] }),
        );
        let without = small.push(
            "meshes",
            json!({ "primitives": [
            { "attributes": attributes, "material": material, "mode": mode },
        ] }),
        );
        small.root(json!({ "mesh": with, "translation": [x, 0.0, 0.0] }));
        small.root(json!({ "mesh": without, "translation": [x - 1.1, 0.0, 0.0] }));
    }
    small
}

pub fn no_normals() -> Small {
    let mut small = Small::new();
    // An octahedron with three vertices a face.
    let tips =
        |axis: usize, sign: f32| std::array::from_fn::<f32, 3, _>(|i| if i == axis { sign } else { 0.0 });
    let mut vertices = Vec::new();
    for octant in 0..8 {
        let sign = |bit: u32| if octant & bit == 0 { 1.0 } else { -1.0 };
        let [a, b, c] = [tips(0, sign(1)), tips(1, sign(2)), tips(2, sign(4))];
        let faces_out = sign(1) * sign(2) * sign(4) > 0.0;
        vertices.extend(if faces_out { [a, b, c] } else { [a, c, b] });
    }
    let positions = small.vectors(&vertices);
    let mesh = small.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": positions } }] }));
    small.root(json!({ "mesh": mesh }));
    small
}

pub fn small_types() -> Small {
    let mut small = Small::new();
    let texture = small.texture(&crate::texture::draw(4, |u, v| {
        [if u < 0.5 { 220 } else { 40 }, if v < 0.5 { 200 } else { 60 }, 90, 255]
    }));
    let material = small.push(
        "materials",
        json!({ "pbrMetallicRoughness": {
        "baseColorTexture": { "index": texture }, "metallicFactor": 0.0, "roughnessFactor": 0.8,
    } }),
    );
    // Position and normal of a vertex side by side; then coordinates in 16 bits, and indices in 8.
    let corners: [[f32; 3]; 4] = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let both: Vec<u8> = corners
        .iter()
        .flat_map(|p| p.iter().chain(&[0.0, 0.0, 1.0]))
        .flat_map(|value| value.to_le_bytes())
        .collect();
    let view = small.view(&both);
    small.json["bufferViews"][view]["byteStride"] = json!(24);
    let of_view = |offset: usize| json!({ "bufferView": view, "byteOffset": offset, "componentType": 5126, "count": 4, "type": "VEC3" });
    let mut positions = of_view(0);
    (positions["min"], positions["max"]) = (json!([-1.0, 0.0, 0.0]), json!([1.0, 1.0, 0.0]));
    let positions = small.push("accessors", positions);
    let normals = small.push("accessors", of_view(12));
    let uvs: Vec<u8> = [[0, 65535], [65535, 65535], [65535, 0], [0u16, 0]]
        .iter()
        .flatten()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    let view = small.view(&uvs);
    let uvs = small.push(
        "accessors",
        json!({
            "bufferView": view, "componentType": 5123, "count": 4, "type": "VEC2", "normalized": true,
        }),
    );
    let view = small.view(&[0, 1, 2, 0, 2, 3]);
    let indices = small.push(
        "accessors",
        json!({ "bufferView": view, "componentType": 5121, "count": 6, "type": "SCALAR" }),
    );
    let mesh = small.push(
        "meshes",
        json!({ "primitives": [{
        "attributes": { "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs },
        "indices": indices, "material": material,
    }] }),
    );
    small.root(json!({ "mesh": mesh }));
    small
}

pub fn far() -> Small {
    let mut small = Small::new();
    let node = small.thing(paint([0.3, 0.6, 0.7]), &Mesh::default().sphere(DVec3::ZERO, 1.0, 16, 8));
    small.json["nodes"][node]["scale"] = json!([0.001, 0.001, 0.001]);
    small.json["nodes"][node]["translation"] = json!([30_000.0, 0.0, -10_000.0]);
    small
}

pub fn sheet() -> Small {
    let mut small = Small::new();
    small.thing(paint([0.9, 0.8, 0.7]), &Mesh::default().panel(DVec3::Y, DVec3::X, DVec3::Y));
    small
}
