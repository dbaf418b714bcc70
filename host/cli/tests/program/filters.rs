//! Default filters of pixels and textures: means of frames agree with the reference.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use caustics::image_file::Channels;
use serde_json::{Value, json};

use crate::test_dir::TestDir;

const SIZE: usize = 32;
/// Number of independent runs of each mean.
const SEEDS: usize = 8;

/// A mirror in a dim room, whose normal map tilts columns of texels alternately right and left. Only a level mirror would
/// reflect the lamp. A pixel covers many columns, whose mean normal is level.
fn mirror() -> TestDir {
    let columns = image::RgbImage::from_fn(256, 4, |x, _| {
        let lean = if x % 2 == 0 { 0.3f64 } else { -0.3 };
        let length = (1.0 + lean * lean).sqrt();
        image::Rgb([lean / length, 0.0, 1.0 / length].map(|part| (128.0 + 127.0 * part).round() as u8))
    });
    let mut png = std::io::Cursor::new(Vec::new());
    columns.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let uri = |kind: &str, bytes: &[u8]| format!("data:{kind};base64,{}", BASE64_STANDARD.encode(bytes));

    // The mirror lies on y = 0; the lamp is where the mirror reflects the view of its middle.
    let positions: [[f32; 3]; 8] = [
        [-1.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [1.0, 0.0, -1.0],
        [-1.0, 0.0, -1.0],
        [-0.6, 1.2, -2.0],
        [0.6, 1.2, -2.0],
        [0.6, 2.8, -2.0],
        [-0.6, 2.8, -2.0],
    ];
    let uvs: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let floats = positions.as_flattened().iter().chain(uvs.as_flattened());
    let mut bytes: Vec<u8> = floats.flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|id| id.to_le_bytes()));
    let view =
        |offset: usize, length: usize| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    let points = |view: usize| json!({ "bufferView": view, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, -2], "max": [1, 2.8, 1] });
    let camera = [-(0.125f64.sqrt()), 0.0, 0.0, 0.875f64.sqrt()];
    let document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2], "extras": { "environment": { "color": [0.1, 0.1, 0.1] } } }],
        "nodes": [
            { "mesh": 0 },
            { "mesh": 1 },
            { "camera": 0, "translation": [0.0, 1.8, 2.0], "rotation": camera },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }],
        "meshes": [
            { "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 2 }, "indices": 3, "material": 0 }] },
            { "primitives": [{ "attributes": { "POSITION": 1 }, "indices": 3, "material": 1 }] },
        ],
        "materials": [
            {
                "pbrMetallicRoughness": { "metallicFactor": 1.0, "roughnessFactor": 0.0 },
                "normalTexture": { "index": 0 },
            },
            {
                "emissiveFactor": [1, 1, 1],
                "doubleSided": true,
                "pbrMetallicRoughness": { "metallicFactor": 0.0, "baseColorFactor": [0, 0, 0, 1] },
                "extensions": { "KHR_materials_specular": { "specularFactor": 0.0 } },
            },
        ],
        "textures": [{ "source": 0 }],
        "images": [{ "uri": uri("image/png", png.get_ref()) }],
        "accessors": [
            points(0),
            points(1),
            { "bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2" },
            { "bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
        "bufferViews": [view(0, 48), view(48, 48), view(96, 32), view(128, 12)],
        "buffers": [{ "byteLength": bytes.len(), "uri": uri("application/octet-stream", &bytes) }],
    });
    let dir = TestDir::new();
    dir.write("mirror.gltf", document.to_string());
    dir
}

/// Renders, which must succeed. Returns the green values of the image and the report.
fn render(dir: &TestDir, options: &[&str]) -> (Vec<f32>, Value) {
    let size = SIZE.to_string();
    let files = ["render", "mirror.gltf", "-o", "a.exr", "--force", "--json"];
    let tiny = ["--runner", "cpu", "--light-paths", "500", "--width", &size, "--height", &size];
    let report = dir.succeeds(&[&files[..], &tiny, options].concat()).json();
    let image = Channels::read(&dir.path("a.exr")).unwrap();
    (image.layer("").unwrap()[1].to_vec(), report)
}

/// Mean and standard error over independent runs, of an image's middle and of the whole image.
fn means(dir: &TestDir, options: &[&str], first: usize) -> [[f64; 2]; 2] {
    let runs: Vec<Vec<f32>> = (first..first + SEEDS)
        .map(|seed| render(dir, &[&["--seed", &seed.to_string()], options].concat()).0)
        .collect();
    let middle = |id: usize| [id % SIZE, id / SIZE].iter().all(|at| (12..20).contains(at));
    let estimate = |is_in: &dyn Fn(usize) -> bool| {
        let mean = |image: &Vec<f32>| {
            let values: Vec<f64> =
                image.iter().enumerate().filter(|&(id, _)| is_in(id)).map(|(_, &v)| v.into()).collect();
            values.iter().sum::<f64>() / values.len() as f64
        };
        let of_runs: Vec<f64> = runs.iter().map(mean).collect();
        let mean = of_runs.iter().sum::<f64>() / SEEDS as f64;
        let square = of_runs.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        [mean, (square / (SEEDS * (SEEDS - 1)) as f64).sqrt()]
    };
    [estimate(&middle), estimate(&|_| true)]
}

/// Difference of two means in standard errors.
fn sigmas([a, error_a]: [f64; 2], [b, error_b]: [f64; 2]) -> f64 {
    (a - b).abs() / error_a.hypot(error_b)
}

#[test]
fn means_of_frames_show_a_normal_mapped_mirror_like_the_reference() {
    let dir = mirror();
    let reference = means(&dir, &["--method", "path", "--frames", "64"], 100);
    for method in ["basic", "progressive", "kim2019"] {
        let found = means(&dir, &["--method", method, "--frames", "32"], 0);
        for (region, (found, reference)) in
            ["middle", "all"].into_iter().zip(found.into_iter().zip(reference))
        {
            let [ratio, sigmas] = [found[0] / reference[0], sigmas(found, reference)];
            println!("{method}, {region}: {ratio:.4}, {sigmas:.1} standard errors");
            assert!(sigmas < 4.0, "{method}, {region}: {found:?}, reference {reference:?}");
            assert!(
                reference[1].hypot(found[1]) < 0.01 * reference[0],
                "the standard errors are too large for this test: {found:?} {reference:?}"
            );
        }
    }
    // This test can fail: averaged normals are much brighter.
    let wrong = means(&dir, &["--method", "basic", "--frames", "32", "--texture-filter", "cone"], 0);
    println!("cone: middle {:.4}, all {:.4}", wrong[0][0] / reference[0][0], wrong[1][0] / reference[1][0]);
    assert!(sigmas(wrong[0], reference[0]) > 10.0, "{wrong:?}, reference {reference:?}");
}

#[test]
fn single_frames_and_named_filters_keep_their_filter() {
    let dir = mirror();
    let filter = |options: &[&str]| render(&dir, options).1["texture_filter"].clone();
    for (options, expected) in [
        (&["--frames", "1"][..], "cone"),
        (&["--frames", "2"], "finest"),
        (&["--frames", "2", "--method", "kim2019"], "finest"),
        (&["--frames", "2", "--pixel-filter", "centre"], "cone"),
        (&["--frames", "1", "--pixel-filter", "box"], "cone"),
        (&["--frames", "2", "--texture-filter", "cone"], "cone"),
        (&["--frames", "1", "--texture-filter", "finest"], "finest"),
        (&["--frames", "1", "--method", "path"], "finest"),
        (&["--preset", "frame"], "cone"),
        (&["--preset", "preview"], "finest"),
    ] {
        assert_eq!(filter(options), expected, "{options:?}");
    }
}
