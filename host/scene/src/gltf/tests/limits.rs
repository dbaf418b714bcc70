//! Memory is reserved before it is allocated, and errors of poses name the file.

use super::*;

/// `tiny` with a mesh of `triangles` equal triangles on each of `nodes` nodes. Indices have one byte: a triangle takes three.
fn many(triangles: usize, nodes: usize) -> (Value, Vec<u8>) {
    let mut document = tiny();
    let mut binary = tiny_binary();
    binary.truncate(72);
    binary.extend([0, 1, 2].repeat(triangles));
    document["accessors"][2] =
        json!({ "bufferView": 2, "componentType": 5121, "count": 3 * triangles, "type": "SCALAR" });
    document["bufferViews"][2]["byteLength"] = json!(3 * triangles);
    document["buffers"][0]["byteLength"] = json!(72 + 3 * triangles);
    let list = document["nodes"].as_array_mut().unwrap();
    list.extend((1..nodes).map(|_| json!({ "name": "copy", "mesh": 0 })));
    document["scenes"][0]["nodes"] = (0..list.len()).collect();
    (document, binary)
}

#[test]
fn triangles_are_counted_before_they_are_made() {
    let (document, binary) = many(1_000_000, 2000);
    let start = std::time::Instant::now();
    let all = LoadOptions { copies: u64::MAX, ..LoadOptions::default() };
    refuses(load_as(&document, &binary, &all), &["copy", "more than 268435456 triangles"]);
    // Below that limit memory decides: 250 million triangles would take 175 GB.
    if caustics_files::memory::available()
        .is_some_and(|available| available < 250_000_000 * scene_builder::sharing::TRIANGLE_BYTES)
    {
        let (document, binary) = many(1_000_000, 250);
        refuses(
            load_as(&document, &binary, &all),
            &["its 250000000 triangles", "GiB of memory", "are available"],
        );
    }
    // Making one copy takes longer than refusing all of them; an unoptimised build needs a while to read the document.
    assert!(start.elapsed().as_secs() < 20);
    assert_eq!(load(&many(10, 3).0, &many(10, 3).1).unwrap().triangles.len(), 30);
}

#[test]
fn buffer_file_is_read_up_to_its_declared_length() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.bin"), tiny_binary().repeat(2)).unwrap();
    let mut document = tiny();
    document["buffers"][0]["uri"] = json!("a.bin");
    let text = serde_json::to_vec(&document).unwrap();
    assert!(read("tiny.gltf", &text, folder.path()).is_ok());

    // A length beyond memory is refused before the file is read.
    if caustics_files::memory::available().is_some() {
        document["buffers"][0]["byteLength"] = json!(1_u64 << 60);
        let text = serde_json::to_vec(&document).unwrap();
        let message = read("tiny.gltf", &text, folder.path()).unwrap_err().to_string();
        assert!(message.contains("its buffers would take"), "{message}");
    }
}

#[test]
fn error_of_an_invalid_pose_names_the_file() {
    let mut document = tiny();
    // One instance stays within the bounds at first and leaves them by the second key.
    let keys: [f32; 8] = [0., 1., 0., 0., 0., 1e20, 0., 0.];
    let mut binary = tiny_binary();
    binary.resize(80, 0);
    binary.extend(keys.iter().flat_map(|x| x.to_le_bytes()));
    document["buffers"][0]["byteLength"] = json!(112);
    let views = document["bufferViews"].as_array_mut().unwrap();
    views.push(json!({ "buffer": 0, "byteOffset": 80, "byteLength": 8 }));
    views.push(json!({ "buffer": 0, "byteOffset": 88, "byteLength": 24 }));
    let accessors = document["accessors"].as_array_mut().unwrap();
    accessors.push(json!({ "bufferView": 3, "componentType": 5126, "count": 2, "type": "SCALAR" }));
    accessors.push(json!({ "bufferView": 4, "componentType": 5126, "count": 2, "type": "VEC3" }));
    document["animations"] = json!([{
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
        "samplers": [{ "input": 3, "output": 4 }],
    }]);
    let mut scene = load(&document, &binary).unwrap();
    // `Scene::load` sets the name so.
    scene.name = "scene".into();
    let message = scene.pose(1.0).unwrap_err().to_string();
    assert!(message.starts_with("tiny.glb: node \"thing\": at 1 s"), "{message}");
}
