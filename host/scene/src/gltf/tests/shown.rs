//! Selection of the shown scene, containers, required extensions and versions.

use super::*;

/// Asserts that a document loads with a warning of these words, and that strict reading refuses it.
fn shown(document: &Value, words: &[&str]) -> Scene {
    let scene = load(document, &tiny_binary()).unwrap();
    let is_named = |warning: &String| words.iter().all(|word| warning.contains(word));
    assert!(scene.warnings.iter().any(is_named), "{words:?}: {:?}", scene.warnings);
    assert!(load_strictly(document, &tiny_binary()).is_err());
    scene
}

#[test]
fn scene_needs_no_list_of_nodes() {
    let mut document = tiny_with("/scenes", json!([{ "name": "empty" }, { "nodes": [0, 1] }]));
    document["scene"] = json!(1);
    let scene = load(&document, &tiny_binary()).unwrap();
    assert!(scene.warnings.is_empty() && scene.cameras.len() == 1, "{:?}", scene.warnings);
    // Without a default scene the first scene is used.
    document.as_object_mut().unwrap().remove("scene");
    shown(&document, &["scene 0 has no mesh", "scene 1 is shown"]);
}

#[test]
fn meshes_are_shown_if_the_default_scene_has_none() {
    let other = tiny_with("/scenes", json!([{ "nodes": [1] }, { "nodes": [0] }]));
    assert!(shown(&other, &["scene 0 has no mesh", "scene 1 is shown"]).cameras.is_empty());
    let none = tiny_with("/scenes", json!([{ "nodes": [] }]));
    assert_eq!(shown(&none, &["all of its nodes are shown"]).cameras.len(), 1);
    for nodes in [json!([{}, { "camera": 0 }]), json!([{ "children": [1] }, {}])] {
        shown(&tiny_with("/nodes", nodes), &["no node places its meshes"]);
    }
    let mut library = tiny();
    for section in ["scene", "scenes", "nodes"] {
        library.as_object_mut().unwrap().remove(section);
    }
    shown(&library, &["no node places its meshes"]);
    // A default scene out of range is an error.
    refuses(load_with("/scene", json!(7)), &["scene 7"]);
}

#[test]
fn meshes_with_a_scale_of_zero_are_left_out() {
    let mut document = tiny();
    document["nodes"].as_array_mut().unwrap().push(json!({ "name": "flat", "mesh": 0, "scale": [1, 0, 1] }));
    document["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let scene = load_strictly(&document, &tiny_binary()).unwrap();
    assert_eq!((scene.triangles.len(), scene.warnings.len()), (1, 1));
    assert!(scene.warnings[0].contains("\"flat\": its transform is singular"), "{:?}", scene.warnings);
}

#[test]
fn orthographic_cameras_are_left_out() {
    for camera in [
        json!({ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "zfar": 10, "znear": 0 } }),
        json!({ "type": "orthographic" }),
        json!({ "type": "oblique", "perspective": { "yfov": 0.8 } }),
        json!({ "type": "perspective" }),
    ] {
        let scene = load_with("/cameras/0", camera).unwrap();
        assert!(
            scene.cameras.is_empty() && scene.warnings[0].contains("perspective"),
            "{:?}",
            scene.warnings
        );
    }
    assert_eq!(load_with("/cameras/0/perspective", json!({ "yfov": 0.8 })).unwrap().cameras.len(), 1);
}

#[test]
fn unsupported_required_extensions_are_named() {
    let mut document = tiny_with("/extensionsRequired", json!(["KHR_gaussian_splatting", "VENDOR_x"]));
    let words = ["\"KHR_gaussian_splatting\"", "not supported", "rendered without it", "extensionsRequired"];
    shown(&document, &words);
    shown(&document, &["\"VENDOR_x\""]);
    refuses(load_strictly(&document, &tiny_binary()), &["KHR_gaussian_splatting", "export the scene"]);
    // Without the extension the file has nothing to show.
    document["meshes"][0]["primitives"][0]["mode"] = json!(0);
    refuses(load(&document, &tiny_binary()), &["no triangles", "KHR_gaussian_splatting"]);
    document["accessors"] = json!([]);
    refuses(load(&document, &tiny_binary()), &["accessor", "KHR_gaussian_splatting"]);
    document["buffers"][0]["byteLength"] = json!(1000);
    refuses(load(&document, &tiny_binary()), &["buffer 0", "KHR_gaussian_splatting"]);
}

#[test]
fn documents_for_later_readers_are_read() {
    shown(&tiny_with("/asset/minVersion", json!("2.9")), &["minVersion is \"2.9\"", "as far as it is known"]);
    assert!(load_with("/asset/version", json!("2.9")).is_ok());
    // Documents of glTF 1.0 need not state their version.
    let old = json!({ "meshes": { "box": {} }, "nodes": { "node": {} } });
    refuses(load(&old, &[]), &["glTF 1.0", "npx gltf-pipeline"]);
    refuses(read("tiny.glb", b"glTF\x01\0\0\0\x14\0\0\0\0\0\0\0\0\0\0\0", Path::new(".")), &["glTF 1.0"]);
}

#[test]
fn containers_may_hold_further_chunks() {
    let whole = pack(&serde_json::to_vec(&tiny()).unwrap(), &tiny_binary());
    let json = 20 + u32::from_le_bytes(whole[12..16].try_into().unwrap()) as usize;
    let chunk =
        |name: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], name, bytes].concat();
    let between = [&whole[..json], &chunk(b"XTRA", b"four"), &whole[json..]].concat();
    let behind = [&whole[..], &chunk(b"XTRA", b"four")].concat();
    let padded = [&whole[..], &[0; 13]].concat();
    let cut = [&whole[..], &chunk(b"XTRA", b"four")[..9]].concat();
    let marked = pack(&[b"\xEF\xBB\xBF", &serde_json::to_vec(&tiny()).unwrap()[..]].concat(), &tiny_binary());
    for bytes in [between, behind, padded, cut, marked] {
        assert!(read("tiny.glb", &bytes, Path::new(".")).unwrap().warnings.is_empty());
    }
}

#[test]
fn buffers_of_compressed_views_alone_need_no_bytes() {
    let views = |uri: Value| {
        let compressed = json!({ "EXT_meshopt_compression": { "buffer": 0 } });
        let views = json!([{ "buffer": 1, "extensions": compressed }, { "buffer": 2 }, { "buffer": 3 }]);
        json!({ "buffers": [{}, { "uri": uri }, {}, {}], "bufferViews": views })
    };
    assert_eq!(document::extension::fallbacks(&views(Value::Null), true), [false, true, false, false]);
    assert_eq!(document::extension::fallbacks(&views(json!("there.bin")), true), [false; 4]);
}
