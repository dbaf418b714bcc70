//! Damage to textures of a scene.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::{Scene, TINY};

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/textured-room")
}

/// Returns a scene with all of its images.
pub fn whole() -> Scene {
    let scene = Scene::new("textured-room");
    for file in ["tiles.png", "bricks.png", "rings.png", "leaves.png", "panes.png"] {
        std::fs::copy(source().join(file), scene.dir.path(file)).unwrap();
    }
    scene
}

/// The transcoder adds two offsets of the file, one of which is the maximum.
#[test]
fn a_panicking_decoder_prints_nothing_of_its_own() {
    let word = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let long = |words: &[u64]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let header = word(&[0, 1, 16, 16, 0, 0, 1, 1, 1, 104, 44, 0, 0]);
    let global = long(&[u64::MAX, 145]);
    let level = long(&[329, 8, 0]);
    let format = word(&[44, 0, 40 << 16 | 2, 2 << 16 | 419, 3 << 8 | 3, 8, 0, 63 << 16, 0, 0, u32::MAX]);
    let file = [&b"\xABKTX 20\xBB\r\n\x1A\n"[..], &header, &global, &level, &format, &[0; 189]].concat();
    let mut scene = whole();
    scene.dir.write("a.ktx2", file);
    scene.json["images"][0] = json!({ "uri": "a.ktx2" });
    scene.replaces(&["image 0", "Basis Universal data are damaged"]);
    let run = scene.dir.run(&[&["render", "scene.gltf", "-o", "b.exr"], &TINY[..]].concat());
    assert!(!run.stderr.contains("panicked") && !run.stderr.contains(".rs:"), "{}", run.stderr);
}

#[test]
fn unavailable_textures_are_replaced() {
    let tiles = std::fs::read(source().join("tiles.png")).unwrap();
    let render = [&["render", "scene.gltf", "-o", "out.exr"], &TINY[..]].concat();
    whole().write().dir.succeeds(&render);

    // Damage the file: missing, empty, not an image, cut off, and with a wrong length.
    let scene = whole();
    std::fs::remove_file(scene.dir.path("tiles.png")).unwrap();
    scene.replaces(&["image 0", "tiles.png"]);
    let mut damaged = tiles.clone();
    damaged[40] ^= 0xff;
    let contents: [(&[u8], &str); 5] = [
        (b"", "is no PNG, JPEG, WebP or KTX 2.0"),
        (b"GIF89a and so on", "is no PNG, JPEG, WebP or KTX 2.0"),
        (b"\x89PNG\r\n\x1a\n", "cannot be decoded"),
        (&tiles[..tiles.len() / 2], "cannot be decoded"),
        (&damaged, "cannot be decoded"),
    ];
    for (bytes, words) in contents {
        let scene = whole();
        scene.dir.write("tiles.png", bytes);
        scene.replaces(&["image 0", words]);
    }

    // No memory has room for this size.
    let mut huge = tiles.clone();
    huge[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]);
    let scene = whole();
    scene.dir.write("tiles.png", &huge);
    scene.replaces(&["image 0", "cannot be decoded"]);

    // Damage indices of the document.
    for (pointer, words) in [
        ("/materials/0/pbrMetallicRoughness/baseColorTexture/index", "texture 4321"),
        ("/textures/0/source", "image 4321"),
    ] {
        let mut scene = whole();
        *scene.json.pointer_mut(pointer).unwrap() = json!(4321);
        scene.replaces(&[words]);
    }
    let mut scene = whole();
    scene.json["images"][0] = json!({ "bufferView": 4321 });
    scene.replaces(&["image 0", "buffer view 4321"]);
    let mut scene = whole();
    scene.json["images"][0] = json!({});
    scene.replaces(&["image 0", "neither a uri nor a bufferView"]);

    // Damage coordinates: missing, not finite, of the wrong kind.
    let mut scene = whole();
    scene.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    scene.replaces(&["mesh", "TEXCOORD_0"]);
    let mut scene = whole();
    let at = scene.offset(&scene.primitive()["attributes"]["TEXCOORD_0"]);
    scene.binary[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    scene.replaces(&["texture coordinate", "mesh"]);
    let mut scene = whole();
    let position = scene.primitive()["attributes"]["POSITION"].clone();
    scene.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = position;
    scene.refuses(1, &["accessor", "2 an element"]);

    // Damage the background of the scene.
    let mut scene = whole();
    scene.json["scenes"][0]["extras"] = json!({ "background": [1, -1, 0] });
    scene.refuses(1, &["extras.background", "three radiances"]);
}
