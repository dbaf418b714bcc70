//! Missing or invalid elements are replaced with a warning that names them, and refused by strict reading.

use super::textures::textured;
use super::*;

/// Asserts that a document loads with one warning of these words, and that strict reading refuses it with them.
fn forgiven(document: &Value, binary: &[u8], words: &[&str]) -> Scene {
    let scene = load(document, binary).unwrap();
    let named = |warning: &&String| words.iter().all(|word| warning.contains(word));
    assert_eq!(scene.warnings.iter().filter(named).count(), 1, "{words:?}: {:?}", scene.warnings);
    let words: Vec<&str> = words.iter().copied().filter(|word| !word.starts_with("; ")).collect();
    refuses(load_strictly(document, binary), &words);
    scene
}

#[test]
fn strict_reading_accepts_documents_without_faults() {
    let (document, binary) = textured(::image::ImageFormat::Png);
    assert!(load_strictly(&document, &binary).unwrap().warnings.is_empty());
}

#[test]
fn missing_textures_leave_the_factors() {
    let (whole, binary) = textured(::image::ImageFormat::Png);
    let gone = json!([{ "uri": "gone.png" }]);
    for (pointer, value, words) in [
        ("/images", gone, ["image 0", "gone.png"]),
        ("/images/0/bufferView", json!(0), ["image 0", "PNG"]),
        ("/images/0/bufferView", json!(99), ["image 0", "buffer view 99"]),
        ("/textures", json!([{ "sampler": 0 }]), ["", ""]),
        ("/textures", json!([{ "source": 7 }]), ["", ""]),
        ("/textures", json!([]), ["", ""]),
        ("/textures/0/sampler", json!(7), ["", ""]),
    ] {
        let mut document = whole.clone();
        *document.pointer_mut(pointer).unwrap() = value;
        document["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
        document["materials"][0]["normalTexture"] = json!({ "index": 0 });
        let scene = load(&document, &binary).unwrap();
        assert!(!scene.warnings.is_empty());
        for warning in &scene.warnings {
            assert!(words.iter().all(|word| warning.contains(word)), "{:?}", scene.warnings);
            assert!(warning.contains("factor alone"), "{:?}", scene.warnings);
        }
        assert!(load_strictly(&document, &binary).is_err());
        // Factors only: white that emits radiance one from 0.5 m^2.
        assert!((scene.flux - Vec3::splat(0.5 * PI)).length() < 1e-5, "{}", scene.flux);
        let record = scene.textures.materials.first().copied().unwrap_or_default();
        assert_eq!([record.base_color, record.emissive, record.normal], [NONE; 3]);
    }
    // With one of two images missing, the other stays.
    let mut document = whole;
    document["images"].as_array_mut().unwrap().push(json!({ "name": "lost", "uri": "gone.png" }));
    document["textures"].as_array_mut().unwrap().push(json!({ "source": 1 }));
    document["materials"][0]["normalTexture"] = json!({ "index": 1 });
    let scene = forgiven(&document, &binary, &["gone.png", "; its factor alone is rendered"]);
    let record = scene.textures.materials[0];
    assert_eq!((record.base_color, record.normal), (0, NONE));
}

#[test]
fn damaged_images_leave_the_factors() {
    let (document, binary) = textured(::image::ImageFormat::Png);
    // The header stays intact: it gives a size, and decoding fails.
    for at in 104 + 33..binary.len() {
        let mut damaged = binary.clone();
        damaged[at] ^= 0x55;
        let scene = load(&document, &damaged).unwrap();
        let is_flat = scene.textures.materials.first().is_none_or(|record| record.base_color == NONE);
        assert_eq!(
            is_flat,
            scene.warnings.iter().any(|warning| warning.contains("factor alone")),
            "byte {at}"
        );
    }
}

#[test]
fn missing_coordinates_are_zero() {
    let (mut document, binary) = textured(::image::ImageFormat::Png);
    document["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    let scene = forgiven(&document, &binary, &["TEXCOORD_0", "\"m\""]);
    assert_eq!(scene.textures.coordinates[0].uv_b, glam::Vec2::ZERO);

    let (document, mut binary) = textured(::image::ImageFormat::Png);
    binary[80..84].copy_from_slice(&f32::NAN.to_le_bytes());
    let scene = forgiven(&document, &binary, &["texture coordinate", "not finite", "\"m\""]);
    assert_eq!(scene.textures.coordinates[0].uv_b, glam::Vec2::ONE);
}

#[test]
fn normals_that_are_not_finite_become_face_normals() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut binary = tiny_binary();
        binary[48..52].copy_from_slice(&bad.to_le_bytes());
        let scene = forgiven(&tiny(), &binary, &["normal", "not finite", "\"m\""]);
        assert_eq!(scene.surfaces[0].normal_b, Vec3::ZERO);
    }
}

#[test]
fn unusable_cameras_and_primitives_are_left_out() {
    let camera = tiny_with("/cameras/0/perspective/yfov", json!(4));
    let scene = forgiven(&camera, &tiny_binary(), &["main", "yfov is 4 rad", "; left out"]);
    assert!(scene.cameras.is_empty());
    let primitive = json!({ "attributes": { "NORMAL": 1 } });
    let mut document = tiny();
    document["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    let scene = forgiven(&document, &tiny_binary(), &["primitive 1", "has no POSITION", "; left out"]);
    assert_eq!(scene.triangles.len(), 1);
}

#[test]
fn damaged_animations_are_left_out() {
    let (mut document, mut binary) = (tiny(), tiny_binary());
    let bytes: Vec<u8> = [0_f32, 1.0].into_iter().flat_map(f32::to_le_bytes).collect();
    let keys = json!({ "componentType": 5126, "count": 2, "type": "SCALAR" });
    let times = append(&mut document, &mut binary, keys.clone(), &bytes);
    let still = append(&mut document, &mut binary, keys, &[0; 8]);
    let translations = json!({ "componentType": 5126, "count": 2, "type": "VEC3" });
    let translations = append(&mut document, &mut binary, translations, &[0; 24]);
    let animated = |channel: Value, sampler: Value| {
        let mut document = document.clone();
        document["animations"] = json!([{ "name": "sway", "channels": [channel], "samplers": [sampler] }]);
        document
    };
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "translation" } });
    let sampler = json!({ "input": times, "output": translations });
    assert!(load_strictly(&animated(channel.clone(), sampler.clone()), &binary).unwrap().is_animated());
    for (at, value, words) in [
        ("/channels/0/sampler", json!(7), "has no sampler"),
        ("/channels/0/target/node", json!(7), "refers to node 7"),
        ("/channels/0/target/path", json!(null), "no target path"),
        ("/samplers/0/input", json!(still), "do not ascend"),
        ("/samplers/0/input", json!(99), "refers to accessor 99"),
        ("/samplers/0/output", json!(times), "should hold 3 an element"),
        ("/samplers/0/interpolation", json!("SPLINE"), "SPLINE"),
    ] {
        let mut document = animated(channel.clone(), sampler.clone());
        *document["animations"][0].pointer_mut(at).unwrap_or(&mut json!(null)) = value.clone();
        if at.ends_with("interpolation") {
            document["animations"][0]["samplers"][0]["interpolation"] = value;
        }
        let scene = forgiven(&document, &binary, &["\"sway\", channel 0", words, "; left out"]);
        assert!(!scene.is_animated());
    }
}

#[test]
fn factors_out_of_range_are_clamped() {
    let with = |pointer: &str, value: Value, words: &[&str]| {
        let words = [&["glow"], words].concat();
        forgiven(&tiny_with(pointer, value), &tiny_binary(), &words).materials[0]
    };
    let metallic = json!({ "metallicFactor": 1.5, "roughnessFactor": 0.5 });
    let material = with("/materials/0/pbrMetallicRoughness", metallic, &["metallicFactor 1.5"]);
    assert_eq!((material.metallic, material.roughness), (1.0, 0.5));
    let color = json!({ "baseColorFactor": [-0.5, 0.5, 1, 1] });
    let material = with("/materials/0/pbrMetallicRoughness", color, &["baseColorFactor -0.5"]);
    assert_eq!(material.base_color, Vec3::new(0.0, 0.5, 1.0));
    let material = with("/materials/0/emissiveFactor", json!([1, -1, 0]), &["emission"]);
    assert_eq!(material.emission, Vec3::X);
    with("/materials/0/emissiveFactor", json!([1e300, 0, 0]), &["emission"]);
    let ior = with("/materials/0/extensions", json!({ "KHR_materials_ior": { "ior": 0.5 } }), &["ior 0.5"]);
    assert_eq!(ior.ior, 1.0);
    for (dispersion, instead) in [(-0.5, 0.0), (1e6, 1000.0)] {
        let extension = json!({ "KHR_materials_dispersion": { "dispersion": dispersion } });
        let material = with("/materials/0/extensions", extension, &["dispersion"]);
        assert_eq!(material.dispersion, instead);
    }
    let volume = json!({ "KHR_materials_volume": { "thicknessFactor": 1, "attenuationDistance": 0 } });
    let material = with("/materials/0/extensions", volume, &["attenuationDistance"]);
    assert_eq!(material.absorption, Vec3::ZERO);

    let mut document = tiny();
    document["materials"][0]["alphaMode"] = json!("MASK");
    document["materials"][0]["alphaCutoff"] = json!(-1);
    forgiven(&document, &tiny_binary(), &["\"glow\"", "alphaCutoff"]);
}
