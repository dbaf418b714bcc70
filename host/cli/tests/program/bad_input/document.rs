//! Damage to the document of a scene, its buffers and their contents.

use serde_json::{Value, json};

use super::{Scene, TINY, refuses, render_refuses};
use crate::test_dir::TestDir;

#[test]
fn missing_scenes_are_named() {
    let dir = TestDir::new();
    render_refuses(&dir, "missing.glb", &[], 1, &["missing.glb", "check the path"]);
    render_refuses(&dir, "missing/scene.gltf", &[], 1, &["missing/scene.gltf", "check the path"]);
    render_refuses(&dir, "no-such-room", &[], 2, &["no-such-room", "mirror-room", ".glb"]);
    refuses(&dir, &["scene", "info", "no-such-room"], 2, &["no-such-room", "mirror-room"]);
    refuses(&dir, &["scene", "make", "no-such-room"], 2, &["no-such-room", "mirror-room"]);
}

#[test]
fn truncated_containers_are_refused_wherever_they_end() {
    let scene = Scene::new("mirror-room");
    let whole = scene.container();
    let json = u32::from_le_bytes(whole[12..16].try_into().unwrap()) as usize;
    for length in [0, 3, 4, 11, 12, 19, 20, 20 + json / 2, 20 + json, 24 + json, whole.len() - 1] {
        scene.dir.write("cut.glb", &whole[..length]);
        render_refuses(&scene.dir, "cut.glb", &[], 1, &["cut.glb"]);
    }
    scene.dir.write("cut.glb", &whole[..whole.len() / 2]);
    render_refuses(&scene.dir, "cut.glb", &[], 1, &["cut.glb", "export or download it again"]);
}

#[test]
fn truncated_and_missing_buffers_are_refused() {
    let scene = Scene::new("mirror-room");
    scene.write();
    scene.dir.write("scene.bin", &scene.binary[..scene.binary.len() / 2]);
    render_refuses(&scene.dir, "scene.gltf", &[], 1, &["scene.gltf", "cut off", "restore the file"]);
    std::fs::remove_file(scene.dir.path("scene.bin")).unwrap();
    render_refuses(&scene.dir, "scene.gltf", &[], 1, &["scene.gltf", "scene.bin", "restore the file"]);
}

#[test]
fn corrupted_json_is_refused() {
    let scene = Scene::new("mirror-room");
    let text = serde_json::to_vec(&scene.json).unwrap();
    for bytes in [&text[..text.len() / 2], b"{}", b"[1, 2]", b"\xff\xfe\x00", b""] {
        scene.dir.write("scene.gltf", bytes);
        render_refuses(&scene.dir, "scene.gltf", &[], 1, &["scene.gltf", "not a glTF 2.0 document"]);
    }
}

#[test]
fn vertices_that_are_not_finite_are_refused() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut scene = Scene::new("mirror-room");
        scene.set_first_coordinate(value);
        scene.refuses(1, &["vertex 0 is not finite", "mesh", "repair the mesh"]);
    }
}

#[test]
fn indices_out_of_range_are_refused() {
    let mut scene = Scene::new("mirror-room");
    let at = scene.offset(&scene.primitive()["indices"]);
    scene.binary[at..at + 2].copy_from_slice(&60_000_u16.to_le_bytes());
    scene.refuses(1, &["index 60000 is out of range", "mesh"]);

    // Repeat this for every index in the document.
    let pointers = [
        ("/nodes/0/mesh", "mesh"),
        ("/meshes/0/primitives/0/material", "material"),
        ("/meshes/0/primitives/0/indices", "accessor"),
        ("/meshes/0/primitives/0/attributes/POSITION", "accessor"),
        ("/accessors/0/bufferView", "buffer view"),
        ("/bufferViews/0/buffer", "buffer"),
        ("/scenes/0/nodes/0", "node"),
    ];
    for (pointer, kind) in pointers {
        let mut scene = Scene::new("mirror-room");
        *scene.json.pointer_mut(pointer).unwrap() = json!(4321);
        scene.refuses(1, &[&format!("{kind} 4321")]);
    }
}

#[test]
fn scenes_without_geometry_are_refused() {
    let mut scene = Scene::new("mirror-room");
    let camera = scene.node("main");
    scene.json["scenes"][0]["nodes"] = json!([camera]);
    scene.json["meshes"] = json!([]);
    scene.json["nodes"].as_array_mut().unwrap().iter_mut().for_each(|node| node["mesh"] = json!(null));
    scene.refuses(1, &["no mesh", "export it"]);
}

#[test]
fn singular_transforms_are_not_shown() {
    let zero_axis = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
    for (key, value) in [("scale", json!([1, 0, 1])), ("matrix", json!(zero_axis))] {
        let mut scene = Scene::new("mirror-room");
        let ball = scene.node("ball");
        scene.json["nodes"][ball][key] = value;
        let run = scene.write().dir.succeeds(&["scene", "info", "scene.gltf"]);
        let output = [run.stdout, run.stderr].concat();
        assert!(
            ["node \"ball\"", "singular", "not shown"].iter().all(|word| output.contains(word)),
            "{output}"
        );
    }
}

#[test]
fn triangles_without_an_area_are_dropped_and_counted() {
    let mut scene = Scene::new("mirror-room");
    let info = |scene: &Scene| -> Value {
        scene.write().dir.succeeds(&["scene", "info", "scene.gltf", "--json"]).json()
    };
    assert_eq!(info(&scene)["dropped_triangles"], 0);
    let triangles = info(&scene)["triangles"].as_u64().unwrap();

    // Make the first two vertices of the first triangle equal.
    let at = scene.offset(&scene.primitive()["indices"]);
    scene.binary.copy_within(at..at + 2, at + 2);
    let spoilt = info(&scene);
    assert_eq!(spoilt["dropped_triangles"], 1);
    assert_eq!(spoilt["triangles"], triangles - 1);
    scene.dir.succeeds(&[&["render", "scene.gltf", "-o", "out.exr"], &TINY[..]].concat());
}
