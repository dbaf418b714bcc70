//! Compressed meshes equal plain ones, and damage to them does not make the loader panic.

use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, GeometryAttributeType, Mesh, MeshEncoder, PointAttribute,
    PointIndex,
};

use super::*;

/// A lossless Draco stream of these corners and faces.
fn draco_stream(corners: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<u8> {
    let mut mesh = Mesh::new();
    let mut positions = PointAttribute::new();
    positions.init(GeometryAttributeType::Position, 3, DataType::Float32, false, corners.len());
    for (id, corner) in corners.iter().enumerate() {
        let bytes: Vec<u8> = corner.iter().flat_map(|x| x.to_le_bytes()).collect();
        positions.buffer_mut().update(&bytes, Some(12 * id));
    }
    mesh.set_num_points(corners.len());
    mesh.add_attribute(positions);
    faces.iter().for_each(|face| mesh.add_face(face.map(PointIndex)));
    let mut stream = EncoderBuffer::new();
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    encoder.encode(&EncoderOptions::new(), &mut stream).unwrap();
    stream.data().to_vec()
}

/// `tiny` compressed by Draco, with accessors without bytes.
fn draco(stream: &[u8], vertices: usize, corners: usize) -> (Value, Vec<u8>) {
    let (mut document, mut binary) = (tiny(), tiny_binary());
    let view = append(&mut document, &mut binary, json!({}), stream);
    document["accessors"] = json!([
        { "componentType": 5126, "count": vertices, "type": "VEC3" },
        { "componentType": 5123, "count": corners, "type": "SCALAR" },
    ]);
    document["meshes"][0]["primitives"][0] = json!({
        "attributes": { "POSITION": 0 }, "indices": 1, "material": 0,
        "extensions": { "KHR_draco_mesh_compression": { "bufferView": view, "attributes": { "POSITION": 0 } } },
    });
    document["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    (document, binary)
}

const SQUARE: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];

#[test]
fn draco_is_decompressed() {
    let stream = draco_stream(&SQUARE, &[[0, 1, 2], [2, 1, 3]]);
    let (document, binary) = draco(&stream, 4, 6);
    let scene = load(&document, &binary).unwrap();
    assert_eq!((scene.triangles.len(), scene.warnings.len()), (2, 0), "{:?}", scene.warnings);
    // Both halves of the square face the camera.
    assert!((scene.flux.x - PI).abs() < 1e-3, "{}", scene.flux);
    assert!(scene.triangles.iter().all(|triangle| (face_normal(triangle) - Vec3::Z).length() < 1e-3));

    // Two primitives share a stream.
    let mut twice = document.clone();
    let primitive = twice["meshes"][0]["primitives"][0].clone();
    twice["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    assert_eq!(load(&twice, &binary).unwrap().triangles.len(), 4);
}

#[test]
fn damaged_draco_is_refused_or_other_triangles() {
    let stream = draco_stream(&SQUARE, &[[0, 1, 2], [2, 1, 3]]);
    for at in 0..stream.len() {
        for damage in [0x01, 0x10, 0x80, 0xFF] {
            let mut damaged = stream.clone();
            damaged[at] ^= damage;
            let (document, binary) = draco(&damaged, 4, 6);
            let _ = load(&document, &binary);
        }
        let (document, binary) = draco(&stream[..at], 4, 6);
        refuses(load(&document, &binary), &["\"m\", primitive 0", "gltf-transform"]);
    }
    // More triangles than the document declares.
    let (document, binary) = draco(&stream, 4, 3);
    refuses(load(&document, &binary), &["Draco"]);
    let (mut document, binary) = draco(&stream, 4, 6);
    document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"] =
        json!({ "POSITION": 7 });
    refuses(load(&document, &binary), &["no attribute 7"]);
}

#[test]
fn uncompressed_copy_replaces_a_damaged_stream() {
    let (mut document, mut binary) = draco(b"no stream", 3, 3);
    document.as_object_mut().unwrap().remove("extensionsRequired");
    let positions = append(
        &mut document,
        &mut binary,
        json!({ "componentType": 5126, "count": 3, "type": "VEC3" }),
        &tiny_binary()[..36],
    );
    let primitive = &mut document["meshes"][0]["primitives"][0];
    (primitive["attributes"]["POSITION"], primitive["indices"]) = (json!(positions), json!(null));
    let scene = load(&document, &binary).unwrap();
    assert_eq!(scene.triangles.len(), 1);
    assert!(scene.warnings.iter().any(|warning| warning.contains("uncompressed")), "{:?}", scene.warnings);
    refuses(load_strictly(&document, &binary), &["Draco"]);
}

/// `tiny` whose indices are compressed by meshopt, without their plain bytes.
fn meshopt(stream: &[u8]) -> (Value, Vec<u8>) {
    let (mut document, mut binary) = (tiny(), tiny_binary());
    let view = append(&mut document, &mut binary, json!({}), stream);
    document["accessors"].as_array_mut().unwrap().truncate(3);
    document["buffers"].as_array_mut().unwrap().push(json!({
        "byteLength": 1_u64 << 60, "extensions": { "EXT_meshopt_compression": { "fallback": true } },
    }));
    let offset = document["bufferViews"][view]["byteOffset"].clone();
    document["bufferViews"][2] = json!({
        "buffer": 1, "byteLength": 6, "byteOffset": 1234,
        "extensions": { "EXT_meshopt_compression": {
            "buffer": 0, "byteOffset": offset, "byteLength": stream.len(), "byteStride": 2, "count": 3,
            "mode": "TRIANGLES",
        } },
    });
    document["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    (document, binary)
}

/// The triangle 0, 1, 2: a code, and the table of two-vertex codes.
const TRIANGLE: [u8; 18] =
    [0xE1, 0xF0, 0x00, 0x76, 0x87, 0x56, 0x67, 0x78, 0xA9, 0x86, 0x65, 0x89, 0x68, 0x98, 0x01, 0x69, 0, 0];

#[test]
fn meshopt_is_decompressed() {
    let (document, binary) = meshopt(&TRIANGLE);
    let (scene, plain) = (load(&document, &binary).unwrap(), load(&tiny(), &tiny_binary()).unwrap());
    assert_eq!((scene.triangles, scene.warnings), (plain.triangles, plain.warnings));
    let view = "/bufferViews/2/extensions/EXT_meshopt_compression";
    for (member, value, words) in [
        ("byteLength", json!(17), "buffer view 2"),
        ("byteLength", json!(u64::MAX), "buffer view 2"),
        ("byteOffset", json!(u64::MAX), "buffer view 2"),
        ("buffer", json!(9), "buffer 9"),
        ("count", json!(4), "has 4 elements"),
        ("count", json!(3_u64 << 50), "memory"),
        ("byteStride", json!(8), "of 8 bytes"),
        ("mode", json!(null), "mode"),
        ("mode", json!("X"), "mode is \"X\""),
        ("mode", json!("ATTRIBUTES"), "of 2 bytes"),
        ("filter", json!("OCTAHEDRAL"), ""),
    ] {
        let mut document = document.clone();
        document.pointer_mut(view).unwrap()[member] = value;
        if !words.is_empty() && (words != "memory" || caustics_files::memory::available().is_some()) {
            refuses(load(&document, &binary), &[words]);
        }
    }
}
