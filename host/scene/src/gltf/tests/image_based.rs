//! EXT_lights_image_based: the orientation of its faces, and the replacement of missing faces.

use std::io::Cursor;

use ::image::{ImageFormat, RgbaImage};
use caustics_kernels::light::environment::radiance_from;

use super::*;

/// Appends an image of 32 x 32 texels, given by a function of column and row; returns its index.
fn add(document: &mut Value, binary: &mut Vec<u8>, texel: impl Fn(u32, u32) -> [u8; 4]) -> usize {
    let image = RgbaImage::from_fn(32, 32, |x, y| ::image::Rgba(texel(x, y)));
    let mut file = Cursor::new(Vec::new());
    image.write_to(&mut file, ImageFormat::Png).unwrap();
    let view = append(
        document,
        binary,
        json!({ "componentType": 5121, "count": 0, "type": "SCALAR" }),
        file.get_ref(),
    );
    if document["images"].is_null() {
        document["images"] = json!([]);
    }
    let images = document["images"].as_array_mut().unwrap();
    images.push(json!({ "bufferView": view, "mimeType": "image/png" }));
    images.len() - 1
}

/// `tiny` in a light of six faces. Each has its own red level (RGBD: 255 over this alpha), is green on its left half and blue on
/// its upper half.
fn lit(change: impl Fn(&mut Value)) -> Result<Scene, SceneError> {
    let (mut document, mut binary) = (tiny(), tiny_binary());
    let faces: Vec<usize> = (0..6)
        .map(|face| {
            let side = |is_so: bool| if is_so { 255 } else { 0 };
            add(&mut document, &mut binary, |x, y| [255, side(x < 16), side(y < 16), alpha(face)])
        })
        .collect();
    let mut light = json!({
        "intensity": 2, "specularImageSize": 32, "specularImages": [faces, [99, 99, 99, 99, 99, 99]],
        "irradianceCoefficients": vec![[0.0; 3]; 9],
    });
    change(&mut light);
    document["extensions"] = json!({ "EXT_lights_image_based": { "lights": [{}, light] } });
    document["extensionsUsed"] = json!(["EXT_lights_image_based"]);
    document["extensionsRequired"] = json!(["EXT_lights_image_based"]);
    document["scenes"][0]["extensions"] = json!({ "EXT_lights_image_based": { "light": 1 } });
    load(&document, &binary)
}

fn alpha(face: u8) -> u8 {
    255 / (face + 1)
}

fn seen(scene: &Scene, direction: Vec3) -> Vec3 {
    radiance_from(scene.tables(), direction.normalize())
}

/// The faces in order: axis, then the directions to the left and up for an observer inside of the cube.
const FACES: [[Vec3; 3]; 6] = [
    [Vec3::X, Vec3::NEG_Z, Vec3::Y],
    [Vec3::NEG_X, Vec3::Z, Vec3::Y],
    [Vec3::Y, Vec3::X, Vec3::NEG_Z],
    [Vec3::NEG_Y, Vec3::X, Vec3::Z],
    [Vec3::Z, Vec3::X, Vec3::Y],
    [Vec3::NEG_Z, Vec3::NEG_X, Vec3::Y],
];

#[test]
fn faces_are_on_their_axes_upright_and_not_mirrored() {
    let scene = lit(|_| {}).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    for (face, [axis, left, up]) in FACES.into_iter().enumerate() {
        assert_eq!(left.cross(up), axis, "left, up and axis of the face {axis} must be a right-handed frame");
        for (to_left, to_up) in [(0.6, 0.6), (0.6, -0.6), (-0.6, 0.6), (-0.6, -0.6)] {
            let found = seen(&scene, axis + to_left * left + to_up * up);
            let level = 2.0 * 255.0 / f32::from(alpha(face as u8));
            let is = |is_so: bool| if is_so { level } else { 0.0 };
            let expected = Vec3::new(level, is(to_left > 0.0), is(to_up > 0.0));
            // Precision of f32 and of the sRGB bytes.
            assert!((found - expected).abs().max_element() < 1e-5 * level, "{face}: {found} {expected}");
        }
    }
}

/// A quarter turn around +y brings the light from +z to +x.
#[test]
fn rotation_of_the_light_turns_its_faces() {
    let plain = lit(|_| {}).unwrap();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let around_y = lit(|light| light["rotation"] = json!([0, half, 0, half])).unwrap();
    let around_x = lit(|light| light["rotation"] = json!([half, 0, 0, half])).unwrap();
    for (from, to) in [(Vec3::Z, Vec3::X), (Vec3::X, Vec3::NEG_Z), (Vec3::Y, Vec3::Y)] {
        assert!((seen(&around_y, to).x - seen(&plain, from).x).abs() < 0.02, "{from} to {to}");
    }
    for (from, to) in [(Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::NEG_Y), (Vec3::X, Vec3::X)] {
        assert!((seen(&around_x, to).x - seen(&plain, from).x).abs() < 0.02, "{from} to {to}");
    }
}

/// Irradiance coefficients replace missing faces: an irradiance of 3 pi everywhere, and more from above.
#[test]
fn irradiance_coefficients_replace_missing_faces() {
    let mut coefficients = vec![[0.0_f64; 3]; 9];
    coefficients[0] = [3.0 * std::f64::consts::PI / 0.282_095; 3];
    coefficients[1][2] = std::f64::consts::TAU / 3.0 / 0.488_603;
    for images in [json!([[0, 1, 2, 3, 4, 77]]), json!([[0, 1]]), json!([]), Value::Null] {
        let change = |light: &mut Value| {
            light["specularImages"] = images.clone();
            light["irradianceCoefficients"] = json!(coefficients);
        };
        let scene = lit(change).unwrap();
        assert!(scene.warnings.iter().any(|w| w.contains("irradianceCoefficients")), "{:?}", scene.warnings);
        for (direction, blue) in [(Vec3::Y, 8.0), (Vec3::NEG_Y, 4.0), (Vec3::X, 6.0)] {
            let found = seen(&scene, direction);
            // A row covers 6 degrees.
            let expected = Vec3::new(6.0, 6.0, blue);
            assert!((found - expected).abs().max_element() < 0.01, "{direction}: {found}");
        }
    }
}

#[test]
fn missing_or_mistyped_lights_are_named() {
    let mut document = tiny();
    document["scenes"][0]["extensions"] = json!({ "EXT_lights_image_based": { "light": 3 } });
    let scene = load(&document, &tiny_binary()).unwrap();
    assert!(scene.warnings.iter().any(|w| w.contains("light 3")), "{:?}", scene.warnings);
    refuses(load_strictly(&document, &tiny_binary()), &["light 3"]);
    refuses(lit(|light| light["rotation"] = json!([0, 0, 1])), &["rotation", "4 numbers"]);
    refuses(lit(|light| light["specularImages"] = json!([1])), &["specularImages[0]"]);
    refuses(lit(|light| light["intensity"] = json!(-1)), &["scale -1"]);
}
