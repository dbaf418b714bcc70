//! A mesh of several primitives: leaves with holes and a glass ball in one mesh look as in two.

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::{LoadOptions, Scene};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::ray::{Hit, Ray};
use caustics_kernels::pass::step::STEP_HIT;
use caustics_kernels::trace::Tracer;
use caustics_tests::direct::render;
use caustics_tests::gpu::gpu;
use caustics_tests::parity::RunnerPair;
use caustics_tests::rays;
use caustics_tests::scenes::copied;
use glam::Vec3;
use serde_json::{Value, json};

/// Meshes of `textured-room`.
const LEAVES: usize = 7;
const BALL: usize = 9;

/// Storage of the meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Storage {
    /// In world space.
    Copied,
    /// Once, for two instances.
    Once,
    /// On nodes that move.
    Moving,
}

const STORAGES: [Storage; 3] = [Storage::Copied, Storage::Once, Storage::Moving];

/// `textured-room` with its leaves and its ball as two meshes, and as one mesh of two primitives.
fn rooms(storage: Storage) -> [Scene; 2] {
    [false, true].map(|merged| {
        let (folder, mut document) = copied("textured-room");
        let meshes = document["meshes"].as_array_mut().expect("meshes");
        let ball = meshes[BALL]["primitives"][0].clone();
        let mut shown = vec![LEAVES, BALL];
        if merged {
            meshes[LEAVES]["primitives"].as_array_mut().expect("primitives").push(ball);
            shown.pop();
        }
        let nodes = document["nodes"].as_array_mut().expect("nodes");
        nodes.iter_mut().filter(|node| shown_by(node, &[LEAVES, BALL])).for_each(|node| *node = json!({}));
        let mut roots: Vec<Value> = (0..nodes.len()).map(Value::from).collect();
        let copy_count = if storage == Storage::Once { 2 } else { 1 };
        for copy in 0..copy_count {
            let children: Vec<usize> = shown
                .iter()
                .map(|mesh| {
                    nodes.push(json!({ "mesh": mesh }));
                    nodes.len() - 1
                })
                .collect();
            // Another size, turned by 0.6 rad.
            let other = json!({
                "scale": [0.5, 0.5, 0.5], "rotation": [0.0, 0.2955, 0.0, 0.9553], "translation": [0.5, 0.8, 0.2],
            });
            let mut group = if copy == 0 { json!({}) } else { other };
            group["children"] = json!(children);
            nodes.push(group);
            roots.push(json!(nodes.len() - 1));
        }
        let group = nodes.len() - 1;
        document["scenes"][0]["nodes"] = roots.into();
        if storage == Storage::Moving {
            move_up(&mut document, group, folder.path());
        }
        let path = folder.path().join("scene.gltf");
        std::fs::write(&path, document.to_string()).expect("a document");
        let copies = if storage == Storage::Once { 0 } else { u64::MAX };
        let options = LoadOptions { copies, ..LoadOptions::default() };
        let mut scene = Scene::load_with(&path, &options).expect("the scene loads");
        scene.pose(0.5).expect("a pose");
        scene
    })
}

fn shown_by(node: &Value, meshes: &[usize]) -> bool {
    node["mesh"].as_u64().is_some_and(|mesh| meshes.contains(&(mesh as usize)))
}

/// Moves a node up by 0.1 m within a second.
fn move_up(document: &mut Value, node: usize, folder: &std::path::Path) {
    let values: Vec<u8> =
        [0.0f32, 1.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0].into_iter().flat_map(f32::to_le_bytes).collect();
    std::fs::write(folder.join("keys.bin"), values).expect("keys");
    let mut push = |list: &str, value: Value| {
        let list = document[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    };
    let buffer = push("buffers", json!({ "byteLength": 32, "uri": "keys.bin" }));
    let times = push("bufferViews", json!({ "buffer": buffer, "byteLength": 8 }));
    let translations = push("bufferViews", json!({ "buffer": buffer, "byteOffset": 8, "byteLength": 24 }));
    let input = json!({
        "bufferView": times, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0.0], "max": [1.0],
    });
    let input = push("accessors", input);
    let output = json!({ "bufferView": translations, "componentType": 5126, "count": 2, "type": "VEC3" });
    let output = push("accessors", output);
    document["animations"] = json!([{
        "channels": [{ "sampler": 0, "target": { "node": node, "path": "translation" } }],
        "samplers": [{ "input": input, "output": output }],
    }]);
}

#[test]
fn holes_and_glass_in_one_mesh_look_as_in_two() {
    for storage in STORAGES {
        let rooms = rooms(storage);
        let [features, other] = rooms.each_ref().map(|scene| scene.features(0.25));
        assert_eq!(features, other);
        assert!(features.has(Features::CUT_OUTS) && features.has(Features::DIELECTRIC));
        assert_eq!(features.has(Features::INSTANCES), storage != Storage::Copied);
        assert_eq!(rooms[0].warnings, rooms[1].warnings);
        assert_eq!(rooms[0].materials, rooms[1].materials);
        let config = RenderConfig {
            width: 96,
            height: 60,
            light_paths: Paths::Count(20_000),
            ..RenderConfig::default()
        };
        let [apart, merged] =
            rooms.map(|scene| render(&scene, &config, "photons-grid", None, 0, 2).remove(1).0);
        let differs = |a: &[Vec3], b: &[Vec3]| {
            a.iter().zip(b).filter(|(a, b)| (**a - **b).length() > 1e-3 * a.length()).count()
        };
        let (path, caustics) =
            (differs(&apart.path, &merged.path), differs(&apart.caustics, &merged.caustics));
        let lit = apart.caustics.iter().filter(|light| light.length() > 0.0).count();
        println!(
            "{storage:?}: {path} and {caustics} of {} pixels differ, {lit} have caustics",
            apart.path.len()
        );
        assert!(lit > 100);
        if storage == Storage::Copied {
            assert_eq!([path, caustics], [0, 0]);
        }
        // A mesh's own space is around its middle, so that coordinates round differently: as between runners, 2 % of
        // whole paths.
        assert!(path < 96 * 60 / 50, "{storage:?}: {path}");
    }
}

/// Every tracer of a device hits a mesh with holes and glass where the CPU does.
#[test]
fn runners_agree_on_holes_and_glass_in_one_mesh() {
    let Some(gpu) = gpu() else { return };
    let config =
        RenderConfig { width: 32, height: 32, light_paths: Paths::Count(1024), ..RenderConfig::default() };
    let [_, scene] = rooms(Storage::Once);
    let features = scene.features(config.specular_roughness);
    let mut tracer = scene.tracer(features);
    let rays: Vec<Ray> = rays::through(&scene, 20_000);
    let hits: Vec<Hit> = rays.iter().map(|ray| tracer.closest(ray)).collect();
    // Rays that continue from their hits pass holes and glass from both sides.
    let rays = [rays.clone(), rays::from_surfaces(&scene, &rays, &hits)].concat();
    for &hardware in gpu.tracers() {
        let mut runners = RunnerPair::open(&gpu, hardware, &scene, &config);
        runners.write("rays", &rays);
        runners.step(&STEP_HIT, rays.len());
        let (cpu, device) = runners.head::<Hit>("hits", rays.len());
        let material = |hit: &Hit| scene.surfaces[hit.triangle as usize].material;
        let hit_count =
            |wanted: u32| cpu.iter().filter(|hit| !hit.is_miss() && material(hit) == wanted).count();
        let same = |a: &Hit, b: &Hit| {
            (a.instance, a.triangle) == (b.instance, b.triangle)
                && (a.is_miss() || (a.distance - b.distance).abs() <= 1e-4 * a.distance.max(1.0))
        };
        let others = cpu.iter().zip(&device).filter(|(a, b)| !same(a, b)).count();
        let (leaves, ball) = (hit_count(LEAVES as u32), hit_count(BALL as u32));
        println!("hardware {hardware}: {leaves} hit leaves, {ball} the ball, {others} differ");
        // The parity rule: 0.2 % on edges and slivers.
        assert!(leaves > 300 && ball > 300 && others <= rays.len() / 500, "{leaves} {ball} {others}");
    }
}
