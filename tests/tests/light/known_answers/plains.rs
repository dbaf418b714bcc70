//! A huge plain does not change the light of small objects on it.

use super::*;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::gather::variant::PHOTONS_GRID;
use caustics_tests::direct::mean_of;
use caustics_tests::gpu::gpu;
use serde_json::{Value, json};

/// Corners and normals of a mesh, triangle by triangle.
type Mesh = Vec<(DVec3, DVec3)>;

fn panel(centre: DVec3, right: DVec3, up: DVec3) -> Mesh {
    let corner = |x: f64, y: f64| (centre + x * right + y * up, right.cross(up).normalize());
    let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    vec![a, b, c, a, c, d]
}

fn block(centre: DVec3, half: f64) -> Mesh {
    let face = |axis: usize, sign: f64| {
        let unit = |axis: usize| DVec3::AXES[axis % 3] * half;
        panel(centre + sign * unit(axis), sign * unit(axis + 1), unit(axis + 2))
    };
    (0..3).flat_map(|axis| [1.0, -1.0].map(|sign| face(axis, sign))).flatten().collect()
}

fn ball(centre: DVec3, radius: f64) -> Mesh {
    let (segments, rows) = (32, 16);
    let at = |row: u32, segment: u32| {
        let (sin, cos) = (std::f64::consts::PI * f64::from(row) / f64::from(rows)).sin_cos();
        let (s, c) = (std::f64::consts::TAU * f64::from(segment) / f64::from(segments)).sin_cos();
        let normal = DVec3::new(sin * c, cos, -sin * s);
        (centre + radius * normal, normal)
    };
    let quad = |row, segment| {
        let corners = [(0, 0), (1, 0), (1, 1), (0, 0), (1, 1), (0, 1)];
        corners.map(|(down, on): (u32, u32)| at(row + down, segment + on))
    };
    (0..rows)
        .flat_map(|row| (0..segments).map(move |segment| (row, segment)))
        .flat_map(|(r, s)| quad(r, s))
        .collect()
}

/// A block, a glass ball and a metal ball of 0.3 m on a floor of +- `half` m, below a point light. All of it is tilted,
/// in f64; lengths are multiplied by `scale`.
fn plain(half: f64, tilt_degrees: f64, scale: f64) -> Scene {
    let meshes = [
        panel(DVec3::ZERO, half * DVec3::Z, half * DVec3::X),
        block(DVec3::new(-0.4, 0.15, -0.1), 0.15),
        ball(DVec3::new(0.05, 0.2, 0.1), 0.15),
        ball(DVec3::new(0.4, 0.16, -0.1), 0.15),
    ];
    let mut binary = Vec::new();
    let (mut views, mut accessors, mut gltf_meshes) = (Vec::new(), Vec::new(), Vec::new());
    for (material, mesh) in meshes.iter().enumerate() {
        for vectors in
            [mesh.iter().map(|&(p, _)| scale * p).collect::<Vec<_>>(), mesh.iter().map(|&(_, n)| n).collect()]
        {
            views.push(json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": 12 * vectors.len() }));
            accessors.push(json!({
                "bufferView": views.len() - 1, "componentType": 5126, "count": vectors.len(), "type": "VEC3",
            }));
            binary.extend(vectors.iter().flat_map(|v| v.as_vec3().to_array()).flat_map(f32::to_le_bytes));
        }
        let attributes = json!({ "POSITION": accessors.len() - 2, "NORMAL": accessors.len() - 1 });
        gltf_meshes.push(json!({ "primitives": [{ "attributes": attributes, "material": material }] }));
    }
    let pbr = |metallic: f64, roughness: f64| json!({ "baseColorFactor": [0.6, 0.6, 0.6, 1], "metallicFactor": metallic, "roughnessFactor": roughness });
    let matte = json!({ "pbrMetallicRoughness": pbr(0.0, 1.0),
        "extensions": { "KHR_materials_specular": { "specularFactor": 0 } } });
    let glass = json!({ "pbrMetallicRoughness": pbr(0.0, 0.0),
        "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_volume": { "thicknessFactor": 1 } } });
    let metal = json!({ "pbrMetallicRoughness": pbr(1.0, 0.0) });
    let (sin, cos) = (0.5 * tilt_degrees.to_radians()).sin_cos();
    let (pitch_sin, pitch_cos) = (-0.5 * 25f64.to_radians()).sin_cos();
    let document: Value = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [
            { "rotation": [0, 0, sin, cos], "children": [1, 2, 3, 4, 5, 6] },
            { "mesh": 0 }, { "mesh": 1 }, { "mesh": 2 }, { "mesh": 3 },
            { "camera": 0, "translation": [0, 0.8 * scale, 1.4 * scale], "rotation": [pitch_sin, 0, 0, pitch_cos] },
            { "translation": [0.2 * scale, 0.8 * scale, 0.1 * scale], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.6, "znear": 0.1 } }],
        "meshes": gltf_meshes, "materials": [matte.clone(), matte, glass, metal],
        "accessors": accessors, "bufferViews": views,
        "buffers": [{ "byteLength": binary.len(), "uri": "plain.bin" }],
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_specular"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": scale * scale }] } },
    });
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plain.bin"), binary).unwrap();
    let file = folder.path().join("plain.gltf");
    std::fs::write(&file, serde_json::to_vec(&document).unwrap()).unwrap();
    Scene::load(&file).unwrap()
}

/// Frames of one image. Where rays round differently a few paths take another turn, and each moves many photons.
const FRAMES: u32 = 16;

/// Sums of the path-traced light and of the caustics.
fn means(scene: &Scene, choice: &RunnerChoice) -> [f64; 2] {
    let config = config(64, 48, 60_000);
    let features = scene.features(config.specular_roughness);
    let mut session = Session::new(
        choice,
        scene,
        &scene.cameras[0],
        &RenderConfig { gather: Some(&PHOTONS_GRID), ..config.clone() },
        features,
    )
    .unwrap();
    let mut sums = [0.0; 2];
    for frame in 0..FRAMES {
        session.frame(frame).unwrap();
        let image = session.image().unwrap();
        let each = [mean_of(&image.path), mean_of(&image.caustics)];
        sums = [0, 1].map(|layer| sums[layer] + each[layer]);
    }
    sums
}

fn is_as_a_small_one(choice: &RunnerChoice) {
    let mut faults = Vec::new();
    for tilt in [0.0, 10.0, 37.0] {
        let small = means(&plain(20.0, tilt, 1.0), choice);
        assert!(small[1] > 0.02 * small[0], "the test has nothing to check: {small:?}");
        // Bounds for plains of 20 and 200 km. The paths are the same, so that the few that take another turn are all
        // the noise.
        for (half, bound) in [(2e4, 0.003), (2e5, 0.01)] {
            let scene = plain(half, tilt, 1.0);
            let huge = means(&scene, choice);
            let ratios = [0, 1].map(|layer| huge[layer] / small[layer]);
            println!(
                "+- {half} m, tilted by {tilt}: path {:.4}, caustics {:.4}; {} triangles",
                ratios[0],
                ratios[1],
                scene.triangles.len()
            );
            if ratios.iter().any(|ratio| (ratio - 1.0).abs() > bound) {
                faults.push((half, tilt, ratios));
            }
        }
    }
    assert!(faults.is_empty(), "{faults:?}");
}

#[test]
fn objects_on_a_plain_of_200_km_are_lit_as_on_a_small_one() {
    is_as_a_small_one(&RunnerChoice::Cpu { threads: 0 });
}

#[test]
fn objects_on_a_huge_plain_are_lit_as_on_a_small_one_on_a_gpu() {
    let Some(gpu) = gpu() else { return };
    // Take ray queries where available: the CPU test covers the software tracer, which takes a software driver minutes
    // to compile for another dozen scenes.
    let hardware = gpu.tracers().contains(&true);
    let (small, huge) = (plain(20.0, 37.0, 1.0), plain(2e5, 37.0, 1.0));
    let [small, huge] = [(&small, &RunnerChoice::Cpu { threads: 0 }), (&huge, &gpu.choice(hardware))]
        .map(|(scene, choice)| means(scene, choice));
    let ratios = [0, 1].map(|layer| huge[layer] / small[layer]);
    println!("path {:.4}, caustics {:.4}", ratios[0], ratios[1]);
    assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.01), "{ratios:?}");
}

/// Splitting of large triangles has no unit of length: lengths times powers of two give the same bits.
#[test]
fn image_of_a_huge_plain_does_not_depend_on_the_unit_of_length() {
    let frame = |scale: f64| {
        let scene = plain(2e5, 37.0, scale);
        let config = config(64, 48, 20_000);
        let image = caustics_tests::direct::render(&scene, &config, "photons-grid", None, 0, 1).remove(0).0;
        (scene.triangles.len(), image.path, image.caustics)
    };
    let plain = frame(1.0);
    assert!(mean_of(&plain.2) > 0.0 && plain.0 > 2000, "the test has nothing to check");
    for exponent in [-10, 11] {
        assert!(plain == frame(2f64.powi(exponent)), "lengths x 2^{exponent}");
    }
}
