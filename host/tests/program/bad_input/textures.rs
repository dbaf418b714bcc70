//! Textures of a scene.

use std::path::Path;

use serde_json::json;

use super::{Scene, TINY, caustics};

#[test]
fn textures_that_cannot_be_had_are_replaced() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/textured-room");
    let tiles = std::fs::read(source.join("tiles.png")).unwrap();
    let whole = || {
        let scene = Scene::new("textured-room");
        for file in ["tiles.png", "bricks.png", "rings.png", "leaves.png", "panes.png"] {
            std::fs::copy(source.join(file), scene.path().join(file)).unwrap();
        }
        scene
    };
    let run =
        caustics(whole().write().path(), &[&["render", "scene.gltf", "-o", "out.exr"], &TINY[..]].concat());
    assert_eq!(run.code, Some(0), "{}", run.stderr);

    // The file: missing, empty, no picture, cut off, and with a damaged length.
    let scene = whole();
    std::fs::remove_file(scene.path().join("tiles.png")).unwrap();
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
        std::fs::write(scene.path().join("tiles.png"), bytes).unwrap();
        scene.replaces(&["image 0", words]);
    }

    // A size that no picture has room for.
    let mut huge = tiles.clone();
    huge[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]);
    let scene = whole();
    std::fs::write(scene.path().join("tiles.png"), &huge).unwrap();
    scene.replaces(&["image 0", "cannot be decoded"]);

    // Indices of the document.
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

    // Coordinates: missing, not finite, of the wrong kind.
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

    // The background of the scene.
    let mut scene = whole();
    scene.json["scenes"][0]["extras"] = json!({ "background": [1, -1, 0] });
    scene.refuses(1, &["extras.background", "three radiances"]);
}
