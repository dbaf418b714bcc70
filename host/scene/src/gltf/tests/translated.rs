//! Extensions that are translated into core glTF.

use super::textures::textured;
use super::*;

#[test]
fn unlit_materials_are_diffuse() {
    let material = json!({
        "pbrMetallicRoughness": { "baseColorFactor": [0.25, 0.5, 1, 1], "metallicFactor": 1 },
        "emissiveFactor": [0, 0, 0],
        "extensions": { "KHR_materials_unlit": {} },
    });
    let mut document = lit_by(&json!({ "type": "point" }));
    document["materials"] = json!([material]);
    document["extensionsRequired"] = json!(["KHR_materials_unlit"]);
    let scene = load(&document, &tiny_binary()).unwrap();
    let material = scene.materials[0];
    assert_eq!(material.base_color, Vec3::new(0.25, 0.5, 1.0));
    assert_eq!((material.metallic, material.specular, material.roughness), (0.0, 0.0, 1.0));
    assert!(scene.warnings.iter().any(|warning| warning.contains("unlit")), "{:?}", scene.warnings);
}

#[test]
fn variants_are_chosen_by_name() {
    let mut document = tiny();
    document["materials"].as_array_mut().unwrap().push(json!({ "emissiveFactor": [0, 1, 0] }));
    document["extensions"] =
        json!({ "KHR_materials_variants": { "variants": [{ "name": "day" }, { "name": "night" }] } });
    document["meshes"][0]["primitives"][0]["extensions"] =
        json!({ "KHR_materials_variants": { "mappings": [{ "material": 1, "variants": [1] }] } });
    let with_variant = |variant: Option<&str>| {
        let bytes = pack(&serde_json::to_vec(&document).unwrap(), &tiny_binary());
        let options = LoadOptions { variant: variant.map(Into::into), ..LoadOptions::default() };
        super::super::read("tiny.glb", &bytes, Path::new("."), &options)
    };
    for (variant, material) in [(None, 0), (Some("day"), 0), (Some("night"), 1)] {
        let scene = with_variant(variant).unwrap();
        assert_eq!(scene.surfaces[0].material, material);
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    }
    refuses(with_variant(Some("dusk")), &["\"dusk\"", "day, night"]);
}

#[test]
fn animations_are_chosen_by_name() {
    let mut document = tiny();
    let mut binary = tiny_binary();
    let view = json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": 28 });
    for value in [1.0_f32, 5.0, 0.0, 0.0, 7.0, 0.0, 0.0] {
        binary.extend(value.to_le_bytes());
    }
    document["buffers"][0]["byteLength"] = json!(binary.len());
    let views = document["bufferViews"].as_array_mut().unwrap();
    views.push(view);
    let view = views.len() - 1;
    let accessors = document["accessors"].as_array_mut().unwrap();
    let first = accessors.len();
    for (offset, kind) in [(0, "SCALAR"), (4, "VEC3"), (16, "VEC3")] {
        accessors.push(json!({
            "bufferView": view, "byteOffset": offset, "componentType": 5126, "count": 1, "type": kind,
        }));
    }
    let animation = |name: &str, output: usize| {
        let sampler = json!({ "input": first, "output": output, "interpolation": "STEP" });
        let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "translation" } });
        json!({ "name": name, "samplers": [sampler], "channels": [channel] })
    };
    document["animations"] = json!([animation("walk", first + 1), animation("run", first + 2)]);
    let with_animation = |name: Option<&str>| {
        let options = LoadOptions { animation: name.map(Into::into), ..LoadOptions::default() };
        load_as(&document, &binary, &options)
    };
    for (name, x) in [(Some("walk"), 5.0), (Some("run"), 7.0), (None, 7.0)] {
        let scene = with_animation(name).unwrap();
        let rig = &scene.rig;
        assert_eq!(rig.at(1.0).unwrap().to_world[0].translation.x, x, "{name:?}");
        assert_eq!(scene.warnings.len(), usize::from(name.is_none()), "{:?}", scene.warnings);
    }
    refuses(with_animation(Some("fly")), &["\"fly\"", "walk, run"]);
}

#[test]
fn webp_is_read() {
    let (mut document, binary) = textured(::image::ImageFormat::WebP);
    document["textures"] = json!([{ "sampler": 0, "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
    document["extensionsRequired"] = json!(["EXT_texture_webp"]);
    let scene = load(&document, &binary).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert_eq!(scene.textures.texels[0], 0xFF00_00FF);
}

/// `textured` with a material of specular-glossiness.
fn glossy(extension: Value) -> Scene {
    let (mut document, binary) = textured(::image::ImageFormat::Png);
    document["materials"][0] = json!({
        "name": "old", "emissiveFactor": [1, 1, 1],
        "extensions": { "KHR_materials_pbrSpecularGlossiness": extension },
    });
    document["extensionsRequired"] = json!(["KHR_materials_pbrSpecularGlossiness"]);
    let scene = load(&document, &binary).unwrap();
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    assert!(scene.warnings[0].contains("\"old\""), "{:?}", scene.warnings);
    scene
}

#[test]
fn specular_glossiness_is_converted() {
    let scene = glossy(json!({
        "diffuseFactor": [0.8, 0.4, 0.2, 1], "specularFactor": [0.04, 0.04, 0.04], "glossinessFactor": 0.75,
    }));
    let material = scene.materials[0];
    assert!((material.base_color - Vec3::new(0.8, 0.4, 0.2)).length() < 1e-5);
    assert!(material.metallic < 1e-5 && material.roughness == 0.25);

    // A red texture on a dielectric without a glossiness texture: the images hold base colour, and roughness with metallic.
    let scene = glossy(json!({
        "diffuseTexture": { "index": 0 }, "specularFactor": [0.04, 0.04, 0.04], "glossinessFactor": 0.75,
    }));
    let record = scene.textures.materials[0];
    assert_eq!((record.base_color, record.metallic_roughness), (0, 1));
    let texel = |texture: u32| {
        let texture = scene.textures.textures[texture as usize];
        assert_eq!((texture.width, texture.height), (2, 1));
        scene.textures.texels[texture.offset as usize].to_le_bytes()
    };
    assert_eq!(texel(0), [255, 0, 0, 255]);
    // Roughness 0.25 is 63.75 of 255.
    assert_eq!((texel(1)[1], texel(1)[2]), (64, 0));
    // The texture as specular colour without diffuse: red metal of glossiness 1 by the texture's alpha.
    let scene = glossy(json!({ "diffuseFactor": [0, 0, 0, 1], "specularGlossinessTexture": { "index": 0 } }));
    let texels: Vec<_> = scene.textures.texels.iter().map(|texel| texel.to_le_bytes()).collect();
    assert_eq!((texels[0], texels[3]), ([255, 0, 0, 255], [255, 0, 255, 255]));
}
