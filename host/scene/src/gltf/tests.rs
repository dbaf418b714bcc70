//! Valid files give the described scene, invalid ones an error that names the file, and no file a panic.

use std::f32::consts::PI;

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::material::{
    FLAG_EMIT_BOTH_SIDES, FLAG_HANGING, FLAG_OPEN_SURFACE, FLAG_THIN,
};
use serde_json::{Value, json};

use glam::{DVec3, Vec3};

use super::*;
use crate::geometry::face_normal;

mod colors;
mod compressed;
mod forgiving;
mod image_based;
mod limits;
mod numbers;
mod shown;
mod textures;
mod translated;
mod types;
mod verdicts;

/// A right triangle of area 0.5 m^2 that emits, and a camera.
fn tiny() -> Value {
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [
            { "name": "thing", "mesh": 0 },
            { "name": "main", "camera": 0, "translation": [0, 0, 5] },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }],
        "meshes": [{ "name": "m", "primitives": [{
            "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": 0,
        }] }],
        "materials": [{ "name": "glow", "emissiveFactor": [1, 1, 1] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 2, "componentType": 5123, "count": 3, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 72, "byteLength": 6 },
        ],
        "buffers": [{ "byteLength": 78 }],
    })
}

fn tiny_binary() -> Vec<u8> {
    let floats: [f32; 18] =
        [0., 0., 0., 1., 0., 0., 0., 1., 0., /* normals */ 0., 0., 1., 0., 0., 1., 0., 0., 1.];
    let indices = [0_u16, 1, 2];
    floats.iter().flat_map(|x| x.to_le_bytes()).chain(indices.iter().flat_map(|x| x.to_le_bytes())).collect()
}

fn pack(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], fill: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), fill);
        bytes
    };
    let (json, binary) = (padded(json, b' '), padded(binary, 0));
    let length = |bytes: usize| (bytes as u32).to_le_bytes();
    [
        b"glTF",
        &length(2)[..],
        &length(28 + json.len() + binary.len()),
        &length(json.len()),
        b"JSON",
        &json,
        &length(binary.len()),
        b"BIN\0",
        &binary,
    ]
    .concat()
}

fn read(file: &str, bytes: &[u8], folder: &Path) -> Result<Scene, SceneError> {
    super::read(file, bytes, folder, &LoadOptions::default())
}

fn load(document: &Value, binary: &[u8]) -> Result<Scene, SceneError> {
    read("tiny.glb", &pack(&serde_json::to_vec(document).unwrap(), binary), Path::new("."))
}

fn load_strictly(document: &Value, binary: &[u8]) -> Result<Scene, SceneError> {
    load_as(document, binary, &LoadOptions { strict: true, ..LoadOptions::default() })
}

fn load_as(document: &Value, binary: &[u8], options: &LoadOptions) -> Result<Scene, SceneError> {
    let bytes = pack(&serde_json::to_vec(document).unwrap(), binary);
    super::read("tiny.glb", &bytes, Path::new("."), options)
}

/// Loads `tiny` with the value at a JSON pointer replaced.
fn load_with(pointer: &str, value: Value) -> Result<Scene, SceneError> {
    load(&tiny_with(pointer, value), &tiny_binary())
}

/// `tiny` with the value at a JSON pointer replaced.
fn tiny_with(pointer: &str, value: Value) -> Value {
    let mut document = tiny();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Object(object) => drop(object.insert(key.into(), value)),
        parent => parent[key.parse::<usize>().unwrap()] = value,
    }
    document
}

/// Appends bytes with a buffer view and an accessor of equal index; returns the index.
fn append(document: &mut Value, binary: &mut Vec<u8>, mut accessor: Value, bytes: &[u8]) -> usize {
    binary.resize(binary.len().next_multiple_of(4), 0);
    let view = json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len() });
    binary.extend(bytes);
    document["buffers"][0]["byteLength"] = json!(binary.len());
    let views = document["bufferViews"].as_array_mut().unwrap();
    views.push(view);
    let index = views.len() - 1;
    accessor["bufferView"] = json!(index);
    let accessors = document["accessors"].as_array_mut().unwrap();
    // If there are more views than accessors, unused accessors fill the gap.
    accessors.resize(index, json!({ "componentType": 5126, "count": 0, "type": "SCALAR" }));
    accessors.push(accessor);
    index
}

/// Asserts that the error names the file and every word.
fn refuses(result: Result<Scene, SceneError>, words: &[&str]) {
    let message = result.expect_err("must be refused").to_string();
    for word in ["tiny.glb"].iter().chain(words) {
        assert!(message.contains(word), "{message:?} does not say {word:?}");
    }
}

#[test]
fn triangle_is_read_and_recentred() {
    let scene = load(&tiny(), &tiny_binary()).unwrap();
    assert_eq!(scene.origin, DVec3::new(0.5, 0.5, 0.0));
    assert_eq!(scene.triangles[0].b, Vec3::new(0.5, -0.5, 0.0));
    assert_eq!(scene.cameras[0].position, Vec3::new(-0.5, -0.5, 5.0));
    assert_eq!((scene.cameras[0].forward, scene.cameras[0].right), (Vec3::NEG_Z, Vec3::X));
    assert_eq!((scene.surfaces[0].light, scene.lights[0].triangle, scene.lights[0].sides), (0, 0, 1));
    assert!((scene.flux.x - 0.5 * PI).abs() < 1e-6);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert!(!scene.features(0.25).has(Features::SMOOTH_NORMALS));
}

#[test]
fn priorities_of_media_are_read_and_open_ones_named() {
    let scene = |high: Value| {
        let mut document = tiny();
        let medium = |name: &str, priority: Value| {
            json!({
                "name": name,
                "extras": { "priority": priority, "other": [null, "x"] },
                "pbrMetallicRoughness": { "metallicFactor": 0 },
                "extensions": {
                    "KHR_materials_transmission": { "transmissionFactor": 1 },
                    "KHR_materials_volume": { "thicknessFactor": 1 },
                },
            })
        };
        let materials = document["materials"].as_array_mut().unwrap();
        materials.extend([medium("high", high), medium("low", json!(-7))]);
        let mut primitives = document["meshes"][0]["primitives"].clone();
        let first = primitives[0].clone();
        primitives.as_array_mut().unwrap().extend([first.clone(), first]);
        (primitives[1]["material"], primitives[2]["material"]) = (json!(1), json!(2));
        document["meshes"][0]["primitives"] = primitives;
        load(&document, &tiny_binary()).unwrap()
    };
    let named = scene(json!(3));
    assert!(named.materials[1].priority > named.materials[2].priority);
    assert_eq!(named.warnings.len(), 2, "{:?}", named.warnings);
    for (warning, name) in named.warnings.iter().zip(["\"high\"", "\"low\""]) {
        assert!(
            ["tiny.glb", name, "open", "thicknessFactor"].iter().all(|word| warning.contains(word)),
            "{warning}"
        );
    }
    // The lowest priority, and values that are not integers.
    let lowest = scene(json!(-8));
    assert!(lowest.materials[1].priority < lowest.materials[2].priority);
    for wrong in [json!("first"), json!(1.5), json!(1e30), json!(null)] {
        let warnings = scene(wrong).warnings;
        assert!(warnings.iter().any(|warning| warning.contains("extras.priority")), "{warnings:?}");
    }
}

#[test]
fn far_scenes_are_as_precise_as_near_ones() {
    let mut document = tiny();
    document["nodes"][0]["translation"] = json!([100_000, 0, 0]);
    document["nodes"][1]["translation"] = json!([100_000, 0, 5]);
    let (near, far) = (load(&tiny(), &tiny_binary()).unwrap(), load(&document, &tiny_binary()).unwrap());
    assert_eq!(near.triangles, far.triangles);
    assert_eq!(near.cameras, far.cameras);
}

#[test]
fn transforms_compose_and_mirrors_keep_the_front() {
    let mut document = tiny();
    document["nodes"] = json!([
        { "children": [2], "scale": [2, 2, 2] },
        { "name": "main", "camera": 0 },
        { "mesh": 0, "scale": [-1, 1, 1], "rotation": [0, 1, 0, 1] },
    ]);
    let scene = load(&document, &tiny_binary()).unwrap();
    let face = face_normal(&scene.triangles[0]);
    assert!((face - Vec3::X).length() < 1e-6, "{face}");
    // The file's normals equal the face normals, and so are stored as zero.
    assert_eq!(scene.surfaces[0].normal_a, Vec3::ZERO);
    assert!((scene.flux.x - 2.0 * PI).abs() < 1e-5);
}

#[test]
fn strips_and_fans_keep_their_winding() {
    let square: [f32; 12] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.];
    for (mode, order) in [(5, [0_u16, 1, 2, 3]), (6, [0, 1, 3, 2])] {
        let mut document = tiny();
        document["meshes"][0]["primitives"][0] = json!({
            "attributes": { "POSITION": 0 }, "indices": 1, "material": 0, "mode": mode,
        });
        document["accessors"] = json!([
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 4, "type": "SCALAR" },
        ]);
        document["bufferViews"] =
            json!([{ "buffer": 0, "byteLength": 48 }, { "buffer": 0, "byteOffset": 48, "byteLength": 8 }]);
        document["buffers"][0]["byteLength"] = json!(56);
        let floats = square.iter().flat_map(|x| x.to_le_bytes());
        let binary: Vec<u8> = floats.chain(order.iter().flat_map(|x| x.to_le_bytes())).collect();
        let scene = load(&document, &binary).unwrap();
        assert_eq!(scene.triangles.len(), 2);
        assert!(scene.triangles.iter().all(|triangle| face_normal(triangle) == Vec3::Z));
        assert!((scene.flux.x - PI).abs() < 1e-5);
    }
}

#[test]
fn materials_are_resolved() {
    let material = |value: Value| load_with("/materials/0", value).unwrap().materials[0];
    let glass = material(json!({
        "emissiveFactor": [0, 1, 0],
        "doubleSided": true,
        "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0, "baseColorFactor": [0.1, 0.2, 0.3, 1] },
        "extensions": {
            "KHR_materials_dispersion": { "dispersion": 0.25 },
            "KHR_materials_emissive_strength": { "emissiveStrength": 3 },
            "KHR_materials_ior": { "ior": 1.7 },
            "KHR_materials_specular": { "specularFactor": 0.5 },
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_volume": {
                "thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [1, 0.5, 0],
            },
        },
    }));
    assert_eq!((glass.base_color, glass.emission), (Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.0, 3.0, 0.0)));
    assert_eq!(
        (glass.ior, glass.specular, glass.flags),
        (1.7, 0.5, FLAG_EMIT_BOTH_SIDES | FLAG_OPEN_SURFACE | FLAG_HANGING)
    );
    let expected = Vec3::new(0.0, 2_f32.ln() / 2.0, 1e6_f32.ln() / 2.0);
    assert!((glass.absorption - expected).length() < 1e-5);
    assert_eq!(glass.dispersion, 0.25);

    let thin = material(json!({
        "emissiveFactor": [1, 1, 1], "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 } },
    }));
    assert_eq!((thin.flags, thin.ior, thin.specular, thin.metallic), (FLAG_THIN, 1.5, 1.0, 1.0));
}

#[test]
fn point_lights_are_read() {
    let mut document = tiny();
    document["materials"] = json!([{}]);
    document["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "color": [1, 0, 0.5], "intensity": 2 }] } });
    document["extensionsRequired"] = json!(["KHR_lights_punctual", "KHR_materials_volume"]);
    document["nodes"][1]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    let scene = load(&document, &tiny_binary()).unwrap();
    assert_eq!((scene.lights.len(), scene.lights[0].triangle), (1, NONE));
    assert_eq!(scene.lights[0].emission, Vec3::new(2.0, 0.0, 1.0));
    assert_eq!(scene.lights[0].position, Vec3::new(-0.5, -0.5, 5.0));

    document["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(-1);
    refuses(load_strictly(&document, &tiny_binary()), &["main", "negative"]);
    document["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = json!(7);
    refuses(load(&document, &tiny_binary()), &["light 7", "main"]);
}

/// `tiny` without emission, with this light on the node of the camera.
fn lit_by(light: &Value) -> Value {
    let mut document = tiny();
    document["materials"] = json!([{}]);
    document["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    document["nodes"][1]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    document
}

#[test]
fn spot_and_directional_lights_shine_along_minus_z() {
    let mut document = lit_by(&json!({
        "type": "spot", "intensity": 2, "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.5 }, "range": 3,
    }));
    // A quarter turn about y takes -z to -x; the scale has no effect.
    document["nodes"][1]["rotation"] = json!([0, 0.5_f64.sqrt(), 0, 0.5_f64.sqrt()]);
    document["nodes"][1]["scale"] = json!([2, 3, 4]);
    let scene = load(&document, &tiny_binary()).unwrap();
    let spot = scene.lights[0];
    assert_eq!((scene.lights.len(), spot.triangle, spot.kind), (1, NONE, Features::SPOT_LIGHTS.0));
    assert!((spot.direction - Vec3::NEG_X).length() < 1e-6, "{}", spot.direction);
    assert_eq!((spot.position, spot.emission), (Vec3::new(-0.5, -0.5, 5.0), Vec3::splat(2.0)));
    assert!((spot.cone - (1.0 - 0.5_f32.cos())).abs() < 1e-6);
    assert!((spot.falloff * (0.2_f32.cos() - 0.5_f32.cos()) - 1.0).abs() < 1e-5);
    assert_eq!(scene.features(0.25).0 & !Features::RECEIVERS.0 & !Features::METAL.0, Features::SPOT_LIGHTS.0);
    assert!(scene.warnings.iter().any(|warning| warning.contains("range")), "{:?}", scene.warnings);

    let sun = &mut document["extensions"]["KHR_lights_punctual"]["lights"][0];
    *sun = json!({ "type": "directional", "color": [1, 0.5, 0], "intensity": 4 });
    let scene = load(&document, &tiny_binary()).unwrap();
    let sun = scene.lights[0];
    assert_eq!((sun.kind, sun.emission), (Features::DIRECTIONAL_LIGHTS.0, Vec3::new(4.0, 2.0, 0.0)));
    assert!((sun.direction - Vec3::NEG_X).length() < 1e-6);
    assert!(sun.position.x > 0.5, "the disc must lie before the scene: {}", sun.position);
    assert!((scene.flux.x - 4.0 * PI * sun.radius * sun.radius).abs() < 1e-4);
    assert!(
        scene.features(0.25).has(Features::DIRECTIONAL_LIGHTS)
            && !scene.features(0.25).has(Features::POINT_LIGHTS)
    );
}

#[test]
fn bad_spots_are_refused() {
    let spot = |inner: f64, outer: f64| {
        let cone = json!({ "innerConeAngle": inner, "outerConeAngle": outer });
        load_strictly(&lit_by(&json!({ "type": "spot", "spot": cone })), &tiny_binary())
    };
    assert!(spot(0.0, std::f64::consts::FRAC_PI_2).is_ok());
    for (inner, outer) in [(0.5, 0.5), (0.6, 0.5), (-0.1, 0.5), (0.0, 1.6), (0.0, 0.0)] {
        refuses(spot(inner, outer), &["main", "cone angle"]);
    }
    let laser = lit_by(&json!({ "type": "laser" }));
    refuses(load_strictly(&laser, &tiny_binary()), &["main", "no point, spot"]);
    let mut flat = lit_by(&json!({ "type": "directional" }));
    flat["nodes"][1] =
        json!({ "name": "sun", "scale": [1, 1, 0], "extensions": flat["nodes"][1]["extensions"] });
    flat["nodes"][0]["children"] = json!([]);
    flat["nodes"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "name": "eye", "camera": 0, "translation": [0, 0, 5] }));
    flat["scenes"][0]["nodes"] = json!([0, 1, 2]);
    for (document, words) in [(laser, ["main", "no point, spot"]), (flat, ["sun", "no direction"])] {
        let scene = load(&document, &tiny_binary()).unwrap();
        let is_named = |warning: &String| words.iter().all(|word| warning.contains(word));
        assert!(scene.is_dark() && scene.warnings.iter().any(is_named), "{:?}", scene.warnings);
    }
}

#[test]
fn warnings_name_each_unsupported_feature_once() {
    let mut document = tiny();
    document["materials"][0]["extensions"] = json!({
        "KHR_materials_sheen": {},
        "KHR_materials_transmission": { "transmissionTexture": { "index": 0 } },
        "KHR_materials_specular": { "specularColorFactor": [1, 0, 0] },
    });
    document["animations"] = json!([{
        "channels": [{
            "sampler": 0,
            "target": { "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": "/x" } } },
        }],
        "samplers": [],
    }]);
    let primitives = document["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(json!({ "attributes": { "POSITION": 0 }, "mode": 1 }));
    let scene = load(&document, &tiny_binary()).unwrap();
    let words =
        ["transmissionTexture", "sheen", "specularColor", "animated pointer", "animation_pointer", "lines"];
    for word in words {
        let named = scene.warnings.iter().filter(|warning| warning.contains(word)).count();
        assert_eq!(named, 1, "{word}: {:?}", scene.warnings);
    }
    assert!(scene.warnings.iter().all(|warning| warning.starts_with("tiny.glb: ")));
}

#[test]
fn bad_references_are_refused() {
    refuses(load_with("/nodes/0/mesh", json!(9)), &["mesh 9", "thing"]);
    refuses(load_with("/nodes/1/camera", json!(9)), &["camera 9", "main"]);
    refuses(load_with("/nodes/0/children", json!([1])), &["main", "two parents"]);
    refuses(load_with("/nodes/0/children", json!([0])), &["thing", "below itself"]);
    refuses(load_with("/scenes/0/nodes", json!([0, 1, 17])), &["node 17"]);
    refuses(load_with("/meshes/0/primitives/0/material", json!(4)), &["material 4", "\"m\""]);
    refuses(load_with("/meshes/0/primitives/0/indices", json!(4)), &["accessor 4", "\"m\""]);
    refuses(load_with("/accessors/0/bufferView", json!(4)), &["buffer view 4", "accessor 0"]);
    refuses(load_with("/bufferViews/0/buffer", json!(4)), &["buffer 4"]);
    refuses(load_with("/accessors/0/componentType", json!(5125)), &["accessor 0", "3 an element"]);
    refuses(load_with("/accessors/2/componentType", json!(5126)), &["accessor 2", "integer"]);
}

#[test]
fn bad_ranges_are_refused() {
    refuses(load_with("/accessors/0/count", json!(4)), &["accessor 0", "48 bytes", "36"]);
    refuses(load_with("/accessors/0/count", json!(u64::MAX)), &["accessor 0"]);
    refuses(load_with("/accessors/0/byteOffset", json!(u64::MAX)), &["accessor 0"]);
    refuses(load_with("/bufferViews/1/byteOffset", json!(u64::MAX)), &["accessor 1"]);
    refuses(load_with("/bufferViews/1/byteLength", json!(4000)), &["accessor 1", "buffer of 78"]);
    refuses(load_with("/bufferViews/0/byteStride", json!(4)), &["accessor 0"]);
    refuses(load_with("/buffers/0/byteLength", json!(100)), &["buffer 0", "80 of 100"]);
    refuses(load_with("/buffers/0/uri", json!("gone.bin")), &["buffer 0", "gone.bin"]);
    refuses(load_with("/buffers/0/uri", json!("https://a.b/c")), &["buffer 0", "https"]);
    let mut binary = tiny_binary();
    binary[74] = 3;
    refuses(load(&tiny(), &binary), &["index 3", "\"m\""]);
}

#[test]
fn bad_numbers_are_refused() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut binary = tiny_binary();
        binary[..4].copy_from_slice(&bad.to_le_bytes());
        refuses(load(&tiny(), &binary), &["vertex 0", "\"m\""]);
    }
    refuses(load_with("/nodes/0/rotation", json!([0, 0, 0, 0])), &["thing", "transform"]);
    refuses(load_with("/nodes/0/translation", json!([1e300, 0, 0])), &["thing", "finite"]);
    refuses(load_with("/nodes/0/scale", json!([1e20, 1e20, 1e20])), &["beyond"]);
    let narrow = tiny_with("/cameras/0/perspective/yfov", json!(0));
    refuses(load_strictly(&narrow, &tiny_binary()), &["main", "yfov"]);
}

#[test]
fn empty_scenes_are_refused() {
    refuses(load_with("/meshes", json!([])), &["mesh 0"]);
    let mut empty = tiny_with("/nodes/0", json!({}));
    empty["meshes"] = json!([]);
    refuses(load(&empty, &tiny_binary()), &["no mesh", "export it"]);
    refuses(load_with("/nodes/0/scale", json!([0, 0, 0])), &["no triangles", "add a mesh"]);
    for mode in 0..4 {
        refuses(load_with("/meshes/0/primitives/0/mode", json!(mode)), &["points and lines", "Blender"]);
    }
    let mut flat = tiny_binary();
    flat[12..16].copy_from_slice(&0_f32.to_le_bytes());
    refuses(load(&tiny(), &flat), &["geometry", "1 triangles"]);
}

#[test]
fn scenes_may_have_no_camera_and_no_light() {
    let unseen = load_with("/nodes/1", json!({})).unwrap();
    assert!(unseen.cameras.is_empty() && !unseen.is_dark());
    let dark = load_with("/materials/0", json!({})).unwrap();
    assert!(dark.is_dark() && dark.cameras.len() == 1);
    assert_eq!(dark.bounds, [Vec3::new(-0.5, -0.5, 0.0), Vec3::new(0.5, 0.5, 0.0)]);
}

#[test]
fn zero_area_triangles_are_dropped_and_counted() {
    let mut document = tiny();
    document["accessors"][2]["count"] = json!(6);
    document["bufferViews"][2]["byteLength"] = json!(12);
    document["buffers"][0]["byteLength"] = json!(84);
    let mut binary = tiny_binary();
    binary.extend([0, 0, 1, 0, 1, 0]);
    let scene = load(&document, &binary).unwrap();
    assert_eq!((scene.triangles.len(), scene.dropped_triangles), (1, 1));
}

#[test]
fn damaged_containers_are_refused() {
    let whole = pack(&serde_json::to_vec(&tiny()).unwrap(), &tiny_binary());
    for length in 0..whole.len() {
        refuses(read("tiny.glb", &whole[..length], Path::new(".")), &[]);
    }
    refuses(load_with("/asset/version", json!("1.0")), &["glTF 1.0", "npx gltf-pipeline"]);
    refuses(read("tiny.glb", "[".repeat(100_000).as_bytes(), Path::new(".")), &[]);
    let missing = Scene::load(Path::new("no/such/tiny.glb"));
    refuses(missing, &["cannot be read"]);
    assert!(Scene::load(Path::new("/")).is_err());
}

#[test]
fn no_byte_makes_the_loader_panic() {
    let whole = pack(&serde_json::to_vec(&tiny()).unwrap(), &tiny_binary());
    for position in 0..whole.len() {
        for flip in [0x01, 0x10, 0x80, 0xFF] {
            let mut damaged = whole.clone();
            damaged[position] ^= flip;
            let _ = read("tiny.glb", &damaged, Path::new("."));
        }
        for replacement in *b"09-[{\"e" {
            let mut damaged = whole.clone();
            damaged[position] = replacement;
            let _ = read("tiny.glb", &damaged, Path::new("."));
        }
    }
}

#[test]
fn no_damage_to_a_committed_scene_makes_the_loader_panic() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/ring");
    let json = std::fs::read(folder.join("scene.gltf")).unwrap();
    let mut document: Value = serde_json::from_slice(&json).unwrap();
    document["buffers"][0].as_object_mut().unwrap().remove("uri");
    let json = serde_json::to_vec(&document).unwrap();
    let whole = pack(&json, &std::fs::read(folder.join("scene.bin")).unwrap());
    assert!(read("ring.glb", &whole, &folder).is_ok());
    for step in 0..60_usize {
        // Damage the document and the buffer in turn, and cut the file.
        let position = if step % 2 == 0 { step * json.len() / 60 } else { step * whole.len() / 60 };
        let mut damaged = whole.clone();
        damaged[position + 3] ^= 0x7F;
        let _ = read("ring.glb", &damaged, &folder);
        assert!(read("ring.glb", &whole[..position], &folder).is_err());
    }
}
