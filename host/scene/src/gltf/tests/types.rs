//! Values of wrong JSON types are refused with their path; `extras` may be anything.

use super::*;

#[test]
fn extras_are_any_json() {
    let deep = serde_json::from_str::<Value>(&format!("{}{}", "[".repeat(120), "]".repeat(120))).unwrap();
    let owners = [
        "",
        "/asset",
        "/scenes/0",
        "/nodes/0",
        "/nodes/1",
        "/cameras/0",
        "/cameras/0/perspective",
        "/meshes/0",
        "/meshes/0/primitives/0",
        "/materials/0",
        "/accessors/0",
        "/bufferViews/0",
        "/buffers/0",
    ];
    for owner in owners {
        for extras in [
            json!("x"),
            json!([1]),
            json!(5),
            json!(true),
            json!(null),
            json!({ "extras": [] }),
            deep.clone(),
        ] {
            let result = load_with(&format!("{owner}/extras"), extras.clone());
            assert!(result.is_ok(), "{owner}: {extras}: {:?}", result.err().map(|error| error.to_string()));
        }
    }
    // Deeper than the parser's stack allows, in the text itself.
    let deep = format!("{}1{}", "[{\"a\":".repeat(100_000), "}]".repeat(100_000));
    let text = serde_json::to_string(&tiny()).unwrap();
    let text = text.replacen('{', &format!("{{\"extras\":{deep},"), 1);
    let scene = read("tiny.glb", &pack(text.as_bytes(), &tiny_binary()), Path::new(".")).unwrap();
    assert_eq!(scene.triangles.len(), 1);
}

#[test]
fn indices_are_not_taken_modulo_2_to_the_32() {
    for index in [1_u64 << 32, (1 << 32) - 1, 1 << 63, u64::MAX] {
        refuses(load_with("/nodes/0/mesh", json!(index)), &["nodes[0].mesh", "2^32"]);
        let attribute = "/meshes/0/primitives/0/attributes/POSITION";
        refuses(load_with(attribute, json!(index)), &["meshes[0].primitives[0].attributes.POSITION", "2^32"]);
        refuses(load_with("/scene", json!(index)), &["scene is", "2^32"]);
        refuses(load_with("/accessors/0/bufferView", json!(index)), &["accessors[0].bufferView", "2^32"]);
    }
    refuses(load_with("/nodes/0/mesh", json!(-1)), &["nodes[0].mesh is -1"]);
    refuses(load_with("/nodes/0/mesh", json!(0.5)), &["nodes[0].mesh is 0.5"]);
}

#[test]
fn wrong_types_are_refused_with_their_path() {
    let color = "/materials/0/pbrMetallicRoughness";
    let texture = |info: Value| json!({ "baseColorTexture": info });
    let transform =
        |value: Value| texture(json!({ "index": 0, "extensions": { "KHR_texture_transform": value } }));
    let cases = [
        ("/textures", json!([{ "source": 0, "sampler": "0" }]), "textures[0].sampler is \"0\""),
        ("/samplers", json!([{ "wrapS": 1 }]), "samplers[0].wrapS is 1 and should be one of 33071"),
        ("/samplers", json!([{ "magFilter": "nearest" }]), "samplers[0].magFilter"),
        ("/materials/0/alphaMode", json!("X"), "materials[0].alphaMode is \"X\" and should be one of OPAQUE"),
        ("/materials/0/alphaCutoff", json!("0.5"), "materials[0].alphaCutoff"),
        ("/materials/0/doubleSided", json!(1), "materials[0].doubleSided is 1 and should be true or false"),
        (color, texture(json!(0)), "baseColorTexture is 0 and should be an object"),
        (color, texture(json!({ "index": "0" })), "baseColorTexture.index is \"0\""),
        (color, texture(json!({ "index": 0, "texCoord": 0.5 })), "texCoord is 0.5"),
        (color, transform(json!({ "scale": ["x", 2] })), "KHR_texture_transform.scale is a list of 2"),
        (color, transform(json!({ "rotation": [] })), "KHR_texture_transform.rotation"),
        (color, transform(json!([])), "KHR_texture_transform is a list of 0 and should be an object"),
        ("/animations", json!(6), "animations is 6 and should be a list"),
        (
            "/animations",
            json!([{ "channels": {} }]),
            "animations[0].channels is an object and should be a list",
        ),
        ("/animations", json!([{ "channels": [{ "sampler": [] }] }]), "animations[0].channels[0].sampler"),
        ("/asset/minVersion", json!("3.0"), "asset.minVersion is \"3.0\""),
        ("/asset/minVersion", json!(2), "asset.minVersion is 2 and should be a string"),
        ("/images", json!("a.png"), "images is \"a.png\""),
        ("/images", json!([{ "uri": 1 }]), "images[0].uri"),
        ("/extensionsRequired", json!("KHR_x"), "extensionsRequired"),
        ("/nodes/0/translation", json!([1, 2]), "nodes[0].translation is a list of 2"),
        ("/nodes/0/name", json!(["long"]), "nodes[0].name"),
        ("/nodes", json!({}), "nodes is an object and should be a list"),
        ("/nodes/0", json!(null), "nodes[0] is null and should be an object"),
    ];
    for (pointer, value, words) in cases {
        refuses(load_with(pointer, value), &["not a glTF 2.0 document", words]);
    }
    // Valid and missing members.
    for (pointer, value) in [
        ("/asset/minVersion", json!("2.0")),
        ("/samplers", json!([{ "wrapS": 33071, "wrapT": 10497, "magFilter": 9729, "minFilter": 9987 }])),
        ("/materials/0/alphaMode", json!("OPAQUE")),
        ("/nodes/0/camera", json!(null)),
        ("/skins", json!([{ "joints": [0] }])),
        // An integer may be written with a fraction of zero.
        ("/nodes/0/mesh", json!(0.0)),
        ("/accessors/0/count", json!(3.0)),
        ("/accessors/0/componentType", json!(5126.0)),
    ] {
        assert!(load_with(pointer, value).is_ok(), "{pointer}");
    }
}

#[test]
fn long_names_are_cut_in_messages() {
    let name = "n".repeat(1 << 20);
    let mut document = tiny();
    document["nodes"][0]["name"] = json!(name);
    document["nodes"][0]["mesh"] = json!(9);
    let message = load(&document, &tiny_binary()).unwrap_err().to_string();
    assert!(message.len() < 300 && message.contains("characters left out"), "{}", message.len());
}
