//! Accessors of every type, and sparse ones, give the numbers of plain floats.

use super::*;

/// Encodes shares in [-1, 1] as normalized integers of the component type `code`; rows are padded to `padded` bytes.
fn shares(code: u32, padded: usize, rows: &[&[f32]]) -> Vec<u8> {
    let share = |x: &f32| match code {
        5120 => ((x * 127.0).round() as i8).to_le_bytes().to_vec(),
        5121 => ((x * 255.0).round() as u8).to_le_bytes().to_vec(),
        5122 => ((x * 32767.0).round() as i16).to_le_bytes().to_vec(),
        5123 => ((x * 65535.0).round() as u16).to_le_bytes().to_vec(),
        _ => x.to_le_bytes().to_vec(),
    };
    let row = |row: &&[f32]| {
        let mut bytes: Vec<u8> = row.iter().flat_map(share).collect();
        bytes.resize(padded, 0xAA);
        bytes
    };
    rows.iter().flat_map(row).collect()
}

/// `tiny` with these positions and normals, in this component type.
fn tiny_with_type(code: u32, stride: usize, positions: &[&[f32]], normals: &[&[f32]]) -> (Value, Vec<u8>) {
    let (mut document, mut binary) = (tiny(), tiny_binary());
    document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    for (semantic, rows) in [("POSITION", positions), ("NORMAL", normals)] {
        let accessor = json!({
            "componentType": code, "normalized": code != 5126, "count": rows.len(), "type": "VEC3",
        });
        let index = append(&mut document, &mut binary, accessor, &shares(code, stride, rows));
        document["bufferViews"][index]["byteStride"] = json!(stride);
        document["meshes"][0]["primitives"][0]["attributes"][semantic] = json!(index);
    }
    (document, binary)
}

#[test]
fn quantised_meshes_equal_plain_ones_to_the_quantum() {
    let positions: [&[f32]; 3] = [&[0.1, 0.2, 0.3], &[0.9, 0.25, 0.35], &[0.15, 1.0, 0.0]];
    let normals: [&[f32]; 3] = [&[0.0, 0.6, 0.8], &[0.6, 0.0, 0.8], &[0.48, 0.36, 0.8]];
    let (document, binary) = tiny_with_type(5126, 12, &positions, &normals);
    let plain = load(&document, &binary).unwrap();
    for (code, stride, largest) in
        [(5120, 4, 127.0), (5121, 4, 255.0), (5122, 8, 32767.0), (5123, 6, 65535.0)]
    {
        let (document, binary) = tiny_with_type(code, stride, &positions, &normals);
        let scene = load(&document, &binary).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        // The corner and the centre err by half a quantum each; a normal's error is that of three components.
        let (triangle, surface) = (&scene.triangles[0], &scene.surfaces[0]);
        let near = |a: Vec3, b: Vec3, quanta: f32| (a - b).abs().max_element() <= quanta / largest + 1e-6;
        assert!(near(triangle.a, plain.triangles[0].a, 1.0) && near(triangle.c, plain.triangles[0].c, 1.0));
        assert!(near(surface.normal_b, plain.surfaces[0].normal_b, 1.0), "{code}: {}", surface.normal_b);
        // Without normalisation the triangle would be larger by the factor `largest`.
        assert!(!near(triangle.a * largest, plain.triangles[0].a, 1.0));
    }
}

#[test]
fn integers_that_are_not_normalized_are_plain_numbers() {
    let (mut document, mut binary) = (tiny(), tiny_binary());
    let bytes: Vec<u8> = [0_u16, 0, 0, 1000, 0, 0, 0, 1000, 0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let accessor = json!({ "componentType": 5123, "count": 3, "type": "VEC3" });
    let index = append(&mut document, &mut binary, accessor, &bytes);
    document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(index);
    document["nodes"][0]["scale"] = json!([0.001, 0.001, 0.001]);
    let (scene, plain) = (load(&document, &binary).unwrap(), load(&tiny(), &tiny_binary()).unwrap());
    assert!((scene.triangles[0].b - plain.triangles[0].b).length() < 1e-6, "{}", scene.triangles[0].b);
}

/// `tiny` whose positions are a sparse accessor over `base`, with these ids and vectors.
fn sparse(base: Value, ids: &[u16], vectors: &[[f32; 3]]) -> (Value, Vec<u8>) {
    let (mut document, mut binary) = (tiny(), tiny_binary());
    let bytes: Vec<u8> = ids.iter().flat_map(|id| id.to_le_bytes()).collect();
    let indices = append(&mut document, &mut binary, json!({}), &bytes);
    let bytes: Vec<u8> = vectors.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let values = append(&mut document, &mut binary, json!({}), &bytes);
    let accessors = document["accessors"].as_array_mut().unwrap();
    accessors.truncate(3);
    accessors.push(json!({
        "bufferView": base, "componentType": 5126, "count": 3, "type": "VEC3",
        "sparse": {
            "count": ids.len(),
            "indices": { "bufferView": indices, "componentType": 5123 },
            "values": { "bufferView": values },
        },
    }));
    document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(3);
    (document, binary)
}

#[test]
fn sparse_accessors_replace_the_listed_elements() {
    let edge = |(document, binary): &(Value, Vec<u8>)| {
        let scene = load(document, binary).unwrap();
        let triangle = scene.triangles[0];
        (triangle.b - triangle.a, triangle.c - triangle.a)
    };
    // Over the corners (0, 0, 0), (1, 0, 0) and (0, 1, 0), and over zeros.
    assert_eq!(edge(&sparse(json!(0), &[2], &[[0.0, 3.0, 0.0]])), (Vec3::X, 3.0 * Vec3::Y));
    let zeros = sparse(json!(null), &[1, 2], &[[2.0, 0.0, 0.0], [0.0, 3.0, 0.0]]);
    assert_eq!(edge(&zeros), (2.0 * Vec3::X, 3.0 * Vec3::Y));
    let (mut document, binary) = zeros;
    document["accessors"][3]["sparse"] = json!(null);
    refuses(load(&document, &binary), &["geometry", "1 triangles"]);
}

#[test]
fn sparse_accessors_out_of_bounds_are_refused() {
    let (document, binary) = sparse(json!(0), &[3], &[[0.0; 3]]);
    refuses(load(&document, &binary), &["accessor 3", "replaces element 3", "there are 3"]);
    let (whole, binary) = sparse(json!(0), &[2], &[[0.0, 3.0, 0.0]]);
    for (pointer, value, words) in [
        ("/count", json!(2), "4 bytes of a buffer view of 2"),
        ("/count", json!(u64::MAX), "accessor 3"),
        ("/indices/byteOffset", json!(u64::MAX), "accessor 3"),
        ("/values/byteOffset", json!(4), "16 bytes of a buffer view of 12"),
        ("/values/bufferView", json!(77), "buffer view 77"),
        ("/indices/componentType", json!(5126), "5121, 5123, 5125"),
    ] {
        let mut document = whole.clone();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        document["accessors"][3]["sparse"].pointer_mut(parent).unwrap()[key] = value;
        refuses(load(&document, &binary), &[words]);
    }
}

#[test]
fn zeros_without_a_buffer_are_bounded() {
    // These vertices and normals take no bytes of the file.
    let positions = json!({ "componentType": 5126, "count": 1_u64 << 50, "type": "VEC3" });
    refuses(load_with("/accessors/0", positions), &["accessor 0", "elements without a buffer view"]);
    let normals = json!({ "componentType": 5126, "count": 1 << 16, "type": "VEC3" });
    refuses(load_with("/accessors/1", normals), &["normals", "3 positions"]);
}

/// Counts whose size in bytes would overflow to a small number.
#[test]
fn counts_beyond_all_memory_are_refused() {
    let count = 1_u64 << 59;
    let mut document = tiny();
    for accessor in [0, 1] {
        document["accessors"][accessor] = json!({ "componentType": 5126, "count": count, "type": "VEC3" });
    }
    document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(0);
    refuses(load(&document, &tiny_binary()), &["elements without a buffer view"]);

    let mut document = tiny();
    document["accessors"].as_array_mut().unwrap().extend([
        json!({ "componentType": 5126, "count": 1_u64 << 62, "type": "SCALAR" }),
        json!({ "componentType": 5126, "count": 1_u64 << 62, "type": "VEC3" }),
    ]);
    document["animations"] = json!([{
        "samplers": [{ "input": 3, "output": 4 }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
    }]);
    // A damaged animation is left out with a warning.
    let scene = load(&document, &tiny_binary()).unwrap();
    assert!(scene.warnings[0].contains("elements without a buffer view"), "{:?}", scene.warnings);
}

/// A mesh of many vertices and one triangle, on many nodes: it takes little memory, but days of reading.
#[test]
fn meshes_that_are_read_too_often_are_refused() {
    let mut document = tiny();
    for accessor in [0, 1] {
        document["accessors"][accessor] =
            json!({ "componentType": 5126, "count": 1_u64 << 16, "type": "VEC3" });
    }
    let node_count = 2 + (1 << 15);
    document["nodes"].as_array_mut().unwrap().extend((2..node_count).map(|_| json!({ "mesh": 0 })));
    document["scenes"][0]["nodes"] = (0..node_count).collect();
    refuses(load(&document, &tiny_binary()), &["reads more than", "vertices"]);
}
