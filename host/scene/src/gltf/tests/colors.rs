//! Vertex colours, sets of texture coordinates, and EXT_mesh_gpu_instancing.

use glam::Vec2;

use super::textures::textured;
use super::*;

/// A document with colours at its triangle's corners, in this type of accessor.
fn colored((mut document, mut binary): (Value, Vec<u8>), colors: [[f32; 3]; 3]) -> (Value, Vec<u8>) {
    let bytes: Vec<u8> = colors.iter().flatten().flat_map(|share| share.to_le_bytes()).collect();
    let accessor = json!({ "componentType": 5126, "count": 3, "type": "VEC3" });
    let index = append(&mut document, &mut binary, accessor, &bytes);
    document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(index);
    (document, binary)
}

fn base(scene: &Scene) -> Vec3 {
    scene.materials[scene.surfaces[0].material as usize].base_color
}

#[test]
fn constant_vertex_colour_becomes_a_factor() {
    let mut plain = (tiny(), tiny_binary());
    plain.0["materials"][0]["pbrMetallicRoughness"] = json!({ "baseColorFactor": [0.5, 0.5, 1, 1] });
    let (document, binary) = colored(plain.clone(), [[0.5, 1.0, 0.25]; 3]);
    let scene = load(&document, &binary).unwrap();
    assert_eq!((base(&scene), scene.warnings.len()), (Vec3::new(0.25, 0.5, 0.25), 0), "{:?}", scene.warnings);
    // The other materials stay unchanged, and white gives no copy.
    assert_eq!(scene.materials[0].base_color, Vec3::new(0.5, 0.5, 1.0));
    let (document, binary) = colored(plain, [[1.0; 3]; 3]);
    assert_eq!(load(&document, &binary).unwrap().materials.len(), 2);
    // Without a material, the default material gets the factor.
    let mut plain = (lit_by(&json!({ "type": "point" })), tiny_binary());
    plain.0["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("material");
    let (document, binary) = colored(plain, [[0.5, 1.0, 0.25]; 3]);
    assert_eq!(base(&load(&document, &binary).unwrap()), Vec3::new(0.5, 1.0, 0.25));
}

#[test]
fn varying_vertex_colours_become_a_texture() {
    let colors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let (document, binary) = colored((tiny(), tiny_binary()), colors);
    for mirror in [1, -1] {
        let mut document = document.clone();
        document["nodes"][0]["scale"] = json!([mirror, 1, 1]);
        let scene = load(&document, &binary).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let textures = &scene.textures;
        let record = textures.materials[scene.surfaces[0].material as usize];
        let texture = textures.textures[record.base_color as usize];
        // Only the finest level exists: neighbours on the image need not be neighbours on the surface.
        assert_eq!((texture.width, texture.height, texture.level_count), (2, 2, 1));
        // Each corner has its colour, for both orientations of the triangle.
        let triangle = scene.triangles[0];
        let position = |at: Vec3| (at + scene.origin.as_vec3()) * Vec3::new(mirror as f32, 1.0, 1.0);
        let [uv_a, uv_b, uv_c] =
            [textures.coordinates[0].uv_a, textures.coordinates[0].uv_b, textures.coordinates[0].uv_c];
        for (corner, uv) in [(triangle.a, uv_a), (triangle.b, uv_b), (triangle.c, uv_c)] {
            let texel = (2.0 * uv).as_uvec2();
            let [red, green, blue, _] = textures.texels[(2 * texel.y + texel.x) as usize].to_le_bytes();
            let at = position(corner);
            let is = |x: f32, y: f32| (at - Vec3::new(x, y, 0.0)).length() < 1e-6;
            assert_eq!(
                [red, green, blue].map(|byte| byte == 255),
                [is(0.0, 0.0), is(1.0, 0.0), is(0.0, 1.0)]
            );
        }
    }
}

#[test]
fn varying_vertex_colours_beside_a_texture_become_their_mean() {
    let colors = [[1.0, 0.0, 0.5], [0.5, 0.0, 0.5], [0.0, 0.75, 0.5]];
    let (document, binary) = colored(textured(::image::ImageFormat::Png), colors);
    let scene = load(&document, &binary).unwrap();
    assert!((base(&scene) - Vec3::new(0.5, 0.25, 0.5)).length() < 1e-6);
    assert!(scene.warnings.len() == 1 && scene.warnings[0].contains("mean"), "{:?}", scene.warnings);
    assert_eq!(scene.textures.materials[scene.surfaces[0].material as usize].base_color, 0);

    let (mut document, binary) = colored((tiny(), tiny_binary()), colors);
    let accessor = document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"].as_u64().unwrap() as usize;
    document["accessors"][accessor]["count"] = json!(2);
    assert!(load(&document, &binary).unwrap().warnings[0].contains("2 colours"));
    refuses(load_strictly(&document, &binary), &["2 colours", "\"m\""]);
}

#[test]
fn second_set_of_texture_coordinates_is_used() {
    let (mut document, binary) = textured(::image::ImageFormat::Png);
    let attributes = document["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap();
    let coordinates = attributes.remove("TEXCOORD_0").unwrap();
    attributes.insert("TEXCOORD_1".into(), coordinates);
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = json!(1);
    let scene = load(&document, &binary).unwrap();
    assert_eq!((scene.textures.coordinates[0].uv_b, scene.warnings.len()), (Vec2::ONE, 0));
}

/// `tiny` with two instances of its mesh: one of half the size at x = 2, and a turned one of twice the size.
fn with_two_instances() -> (Value, Vec<u8>) {
    let (mut document, mut binary) = (tiny(), tiny_binary());
    let mut attribute = |accessor: Value, bytes: &[u8]| append(&mut document, &mut binary, accessor, bytes);
    let floats = |numbers: &[f32]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let vectors = json!({ "componentType": 5126, "count": 2, "type": "VEC3" });
    let translations = attribute(vectors.clone(), &floats(&[2.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
    let scales = attribute(vectors, &floats(&[0.5, 0.5, 0.5, 2.0, 2.0, 2.0]));
    // A half turn about z, as normalized integers (127 is 1).
    let turns = json!({ "componentType": 5120, "normalized": true, "count": 2, "type": "VEC4" });
    let rotations = attribute(turns, &[0, 0, 0, 127, 0, 0, 127, 0]);
    document["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": {
        "TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales, "_ID": 0,
    } } });
    document["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    (document, binary)
}

#[test]
fn gpu_instances_place_the_mesh() {
    let (document, binary) = with_two_instances();
    let scene = load(&document, &binary).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let mut corners: Vec<_> =
        scene.triangles.iter().map(|triangle| triangle.b + scene.origin.as_vec3()).collect();
    corners.sort_by(|a, b| a.x.total_cmp(&b.x));
    assert_eq!(corners.len(), 2);
    for (corner, x) in corners.into_iter().zip([-2.0, 2.5]) {
        assert!((corner - Vec3::new(x, 0.0, 0.0)).length() < 1e-5, "{corner}");
    }
    // Factors of 1/2 and 2 on lengths are 1/4 and 4 on areas.
    assert!((scene.flux.x - 0.5 * PI * 4.25).abs() < 1e-5);
}

#[test]
fn bad_instances_are_refused() {
    let (document, binary) = with_two_instances();
    let attributes = "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes";
    for (member, value, words) in [
        ("TRANSLATION", json!(99), ["accessor 99", "thing"]),
        ("SCALE", json!(0), ["thing", "as many"]),
        ("ROTATION", json!(2), ["thing", "as many"]),
    ] {
        let mut document = document.clone();
        document.pointer_mut(attributes).unwrap()[member] = value;
        refuses(load(&document, &binary), &words);
    }
    // More instances than any memory holds, of no bytes at all.
    let mut document = document.clone();
    let accessor = json!({ "componentType": 5126, "count": 1_u64 << 50, "type": "VEC3" });
    document["accessors"].as_array_mut().unwrap().push(accessor);
    let index = document["accessors"].as_array().unwrap().len() - 1;
    *document.pointer_mut(attributes).unwrap() = json!({ "TRANSLATION": index });
    refuses(load(&document, &binary), &["thing", "elements without a buffer view"]);
}

#[test]
fn clearcoat_replaces_the_coat_of_dielectrics() {
    let material = |metallic: f64| {
        json!({
            "emissiveFactor": [1, 1, 1],
            "pbrMetallicRoughness": { "metallicFactor": metallic, "roughnessFactor": 0.75 },
            "extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.125 } },
        })
    };
    for (metallic, roughness) in [(0.0, 0.125), (1.0, 0.75)] {
        let scene = load_with("/materials/0", material(metallic)).unwrap();
        assert_eq!(scene.materials[0].roughness, roughness);
        assert!(scene.warnings.len() == 1 && scene.warnings[0].contains("clearcoat"), "{:?}", scene.warnings);
    }
}
