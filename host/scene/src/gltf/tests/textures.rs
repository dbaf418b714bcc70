//! Textures of documents: images in buffers, wraps, mappings, alpha, background.

use std::io::Cursor;

use ::image::{DynamicImage, ImageFormat, RgbaImage};
use caustics_kernels::interface::material::{
    FLAG_BLEND, FLAG_COLOR_TEXTURE, FLAG_CUT_OUT, FLAG_EMISSIVE_TEXTURE, FLAG_NORMAL_MAP,
};
use caustics_kernels::interface::texture::{ENCODING_NORMAL, ENCODING_SRGB, WRAP_CLAMP, WRAP_MIRRORED};
use glam::Vec2;

use super::*;

/// `tiny` with texture coordinates and an image of 2 x 1 texels in its buffer, in this format.
pub fn textured(format: ImageFormat) -> (Value, Vec<u8>) {
    let (mut document, mut binary) = (tiny(), tiny_binary());
    binary.resize(80, 0);
    let uvs: [f32; 6] = [0.0, 1.0, 1.0, 1.0, 0.0, 0.0];
    binary.extend(uvs.iter().flat_map(|x| x.to_le_bytes()));
    let image = RgbaImage::from_raw(2, 1, vec![255, 0, 0, 255, 255, 0, 0, 255]).unwrap();
    let mut file = Cursor::new(Vec::new());
    match format {
        ImageFormat::Jpeg => DynamicImage::from(image).into_rgb8().write_to(&mut file, format).unwrap(),
        _ => image.write_to(&mut file, format).unwrap(),
    }
    let length = file.get_ref().len();
    binary.extend(file.get_ref());
    document["buffers"][0]["byteLength"] = json!(binary.len());
    let views = document["bufferViews"].as_array_mut().unwrap();
    views.push(json!({ "buffer": 0, "byteOffset": 80, "byteLength": 24 }));
    views.push(json!({ "buffer": 0, "byteOffset": 104, "byteLength": length }));
    let accessors = document["accessors"].as_array_mut().unwrap();
    accessors.push(json!({ "bufferView": 3, "componentType": 5126, "count": 3, "type": "VEC2" }));
    document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(3);
    document["images"] = json!([{ "bufferView": 4, "mimeType": "image/png" }]);
    document["samplers"] = json!([{ "wrapS": 33071, "wrapT": 33648, "magFilter": 9728 }]);
    document["textures"] = json!([{ "source": 0, "sampler": 0 }]);
    document["materials"][0]["pbrMetallicRoughness"] = json!({
        "baseColorFactor": [1, 1, 1, 0.25], "baseColorTexture": { "index": 0 },
    });
    (document, binary)
}

#[test]
fn textures_are_read_from_png_and_jpeg() {
    for format in [ImageFormat::Png, ImageFormat::Jpeg] {
        let (mut document, binary) = textured(format);
        document["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
        document["materials"][0]["normalTexture"] = json!({ "index": 0, "scale": 0.5 });
        document["materials"][0]["alphaMode"] = json!("MASK");
        document["materials"][0]["alphaCutoff"] = json!(0.125);
        let scene = load(&document, &binary).unwrap();
        let textures = &scene.textures;
        let record = textures.materials[0];
        assert_eq!((record.alpha, record.alpha_cutoff, record.normal_scale), (0.25, 0.125, 0.5));
        // One image as colour and as normals gives two textures with their own texels.
        assert_eq!(
            (record.base_color, record.emissive, record.normal, record.metallic_roughness),
            (0, 0, 1, NONE)
        );
        assert_eq!((textures.textures.len(), textures.texels.len()), (2, 6));
        let [color, normal] = textures.textures[..] else { panic!("two textures") };
        assert_eq!((color.encoding, normal.encoding), (ENCODING_SRGB, ENCODING_NORMAL));
        assert_eq!((color.wrap_u, color.wrap_v, color.nearest), (WRAP_CLAMP, WRAP_MIRRORED, 1));
        assert_eq!((color.width, color.height, color.level_count), (2, 1, 2));
        assert!((textures.texels[0] & 255) >= 250 && (textures.texels[0] >> 24) == 255);
        let flags = FLAG_COLOR_TEXTURE | FLAG_EMISSIVE_TEXTURE | FLAG_NORMAL_MAP | FLAG_CUT_OUT;
        assert_eq!(scene.materials[0].flags & flags, flags);
        let coordinates = textures.coordinates[0];
        assert_eq!((coordinates.uv_a, coordinates.uv_b), (Vec2::Y, Vec2::ONE));
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        // A flux of pi x 0.5 m^2, only in red.
        assert!((scene.flux.x - 0.5 * PI).abs() < 0.02 && scene.flux.y < 1e-2);
    }
}

#[test]
fn textures_with_other_coordinates_are_named() {
    let (mut document, binary) = textured(ImageFormat::Png);
    document["materials"][0]["emissiveTexture"] = json!({ "index": 0, "texCoord": 1 });
    let scene = load(&document, &binary).unwrap();
    let named = |words: &str| scene.warnings.iter().filter(|warning| warning.contains(words)).count();
    assert_eq!(named("emissiveTexture has other coordinates"), 1, "{:?}", scene.warnings);
}

#[test]
fn blending_is_read_and_scales_emission() {
    let (mut document, binary) = textured(ImageFormat::Png);
    let whole = load(&document, &binary).unwrap();
    assert_eq!(whole.materials[0].flags & FLAG_BLEND, 0, "opaque materials must ignore alpha");
    let set = |document: &mut Value, alpha: f64| {
        document["materials"][0]["alphaMode"] = json!("BLEND");
        document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][3] = json!(alpha);
    };
    for (alpha, blends) in [(0.25, true), (1.0, false)] {
        set(&mut document, alpha);
        let scene = load(&document, &binary).unwrap();
        let record = scene.textures.materials[0];
        assert_eq!((f64::from(record.alpha), record.alpha_cutoff, record.blends), (alpha, 0.0, 1));
        assert_eq!(scene.materials[0].flags & FLAG_BLEND != 0, blends);
        assert!((f64::from(scene.flux.x / whole.flux.x) - alpha).abs() < 1e-5);
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    }

    // A surface that no ray sees emits nothing.
    set(&mut document, 0.0);
    assert!(load(&document, &binary).unwrap().is_dark());
}

#[test]
fn media_with_alpha_are_named() {
    let (mut document, binary) = textured(ImageFormat::Png);
    document["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = json!(0);
    for (mode, flag, thickness, count) in [
        ("BLEND", FLAG_BLEND, 0.0, 0),
        ("BLEND", FLAG_BLEND, 0.5, 1),
        ("MASK", FLAG_CUT_OUT, 0.0, 0),
        ("MASK", FLAG_CUT_OUT, 0.5, 1),
    ] {
        document["materials"][0]["alphaMode"] = json!(mode);
        document["materials"][0]["extensions"] = json!({
            "KHR_materials_transmission": { "transmissionFactor": 1.0 },
            "KHR_materials_volume": { "thicknessFactor": thickness },
        });
        let scene = load(&document, &binary).unwrap();
        let named = scene.warnings.iter().filter(|warning| warning.contains(mode)).count();
        assert_eq!(named, count, "{:?}", scene.warnings);
        assert_eq!(scene.materials[0].flags & flag == 0, count == 1);
    }
}

#[test]
fn texture_transforms_are_applied_to_the_coordinates() {
    let (mut document, binary) = textured(ImageFormat::Png);
    document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
        json!({ "KHR_texture_transform": { "offset": [0.5, 0], "scale": [2, 4] } });
    document["extensionsRequired"] = json!(["KHR_texture_transform"]);
    let scene = load(&document, &binary).unwrap();
    assert_eq!(scene.textures.coordinates[0].uv_b, Vec2::new(2.5, 4.0));
}

#[test]
fn background_is_read_from_the_scene() {
    let mut document = tiny();
    assert_eq!(load(&document, &tiny_binary()).unwrap().background, Vec3::ZERO);
    document["scenes"][0]["extras"] = json!({ "background": [0.5, 1, 2] });
    assert_eq!(load(&document, &tiny_binary()).unwrap().background, Vec3::new(0.5, 1.0, 2.0));
}
