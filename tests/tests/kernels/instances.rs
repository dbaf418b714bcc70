//! Meshes that are stored once against copies of them in world space, at positions of their own. They have textures,
//! normal maps, holes and curved glass; some are mirrored or stretched.

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::{LoadOptions, Scene};
use caustics::session::RunnerChoice;
use caustics_kernels::gather::variant::PHOTONS_GRID;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::ray::{Hit, Ray};
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::pass::step::STEP_HIT;
use caustics_kernels::surface::turn::normal_changes;
use caustics_kernels::surface::vertex::vertex;
use caustics_kernels::trace::Tracer;
use caustics_tests::blocks::Blocks;
use caustics_tests::gpu::gpu;
use caustics_tests::parity::RunnerPair;
use caustics_tests::rays;
use caustics_tests::scenes::copied;
use glam::Vec3;
use serde_json::{Value, json};

/// `textured-room` with three small copies of all non-emissive meshes, stored as copies or once.
fn rooms() -> [Scene; 2] {
    let (folder, mut document) = copied("textured-room");
    let path = folder.path().join("scene.gltf");
    let nodes = document["nodes"].as_array().unwrap().clone();
    let copies = nodes.iter().filter(|node| node["mesh"].is_u64() && node["name"] != "lamp");
    let copy = |node: &Value, at: usize| {
        let below =
            json!({ "mesh": node["mesh"], "translation": node["translation"], "scale": node["scale"] });
        let mut below = below.as_object().unwrap().clone();
        below.retain(|_, value| !value.is_null());
        let (scale, rotation, translation) = [
            ([0.2, -0.25, 0.15], [0.0, 0.6, 0.0, 0.8], [-0.6, 0.8, 0.3]),
            ([0.3, 0.2, 0.25], [0.48, 0.0, 0.36, 0.8], [0.6, 0.7, 0.2]),
            ([-0.2, 0.2, 0.2], [0.0, 0.0, 0.6, 0.8], [0.1, 1.1, -0.5]),
        ][at];
        let above = json!({ "scale": scale, "rotation": rotation, "translation": translation });
        (Value::Object(below), above)
    };
    let mut all = nodes.clone();
    let copies: Vec<_> = copies.flat_map(|node| (0..3).map(move |at| copy(node, at))).collect();
    for (below, mut above) in copies {
        all.push(below);
        above["children"] = json!([all.len() - 1]);
        all.push(above);
        document["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(all.len() - 1));
    }
    document["nodes"] = all.into();
    std::fs::write(&path, document.to_string()).unwrap();
    [u64::MAX, 0]
        .map(|copies| Scene::load_with(&path, &LoadOptions { copies, ..LoadOptions::default() }).unwrap())
}

/// Middle of the triangle of a hit, in world space.
fn middle(scene: &Scene, hit: &Hit) -> Vec3 {
    let t = scene.world_triangle(hit.instance, hit.triangle);
    (t.a + t.b + t.c) / 3.0
}

#[test]
fn mesh_of_four_nodes_is_stored_once() {
    let [copied, stored] = rooms();
    assert!(copied.instanced.instances.is_empty());
    assert_eq!(stored.instanced.instances.len(), 4 * stored.instanced.meshes.len());
    let once = stored.triangles.len() - stored.instanced.still;
    assert_eq!(copied.triangles.len(), stored.instanced.still + 4 * once);
    assert_eq!(copied.materials, stored.materials);
    assert!(!stored.is_animated() && stored.warnings == copied.warnings);
    let features = copied.features(0.25);
    assert_eq!(stored.features(0.25), features | Features::INSTANCES);
    assert!(features.has(Features::CUT_OUTS) && features.has(Features::NORMAL_MAPS));
}

#[test]
fn hits_and_vertices_of_instances_match_those_of_copies() {
    let [copied, stored] = rooms();
    let shift = (stored.origin - copied.origin).as_vec3();
    let (mut copies, mut instances) =
        (copied.tracer(copied.features(0.25)), stored.tracer(stored.features(0.25)));
    let rays = rays::through(&copied, 40_000);
    let first: Vec<Hit> = rays.iter().map(|ray| copies.closest(ray)).collect();
    let rays = [rays.clone(), rays::from_surfaces(&copied, &rays, &first)].concat();
    let (mut others, mut met, mut mirrored) = (0, 0, 0);
    for ray in rays {
        let there = Ray { origin: ray.origin - shift, ..ray };
        let (a, b) = (copies.closest(&ray), instances.closest(&there));
        if a.is_miss() && b.is_miss() {
            continue;
        }
        let same = a.is_miss() == b.is_miss()
            && (a.distance - b.distance).abs() <= 1e-4
            && (middle(&copied, &a) - middle(&stored, &b) - shift).length() < 1e-4;
        others += u32::from(!same);
        if !same {
            continue;
        }
        met += u32::from(b.instance != 0);
        mirrored += u32::from(stored.instances[b.instance as usize].orientation < 0.0);
        let (v, w) = (
            vertex(copied.tables(), Features::ALL, &ray, &a, 1e-3),
            vertex(stored.tables(), Features::ALL, &there, &b, 1e-3),
        );
        assert_eq!((v.material, v.front, v.instance, v.light == w.light), (w.material, w.front, 0, true));
        assert!((v.position - w.position - shift).length() < 1e-4, "{v:?} {w:?}");
        assert!((v.face_normal - w.face_normal).length() < 1e-4, "{v:?} {w:?}");
        assert!((v.uv - w.uv).length() < 1e-3, "{v:?} {w:?}");
        let near = |a: f32, b: f32| (a - b).abs() <= 1e-3 * a.abs().max(b.abs()) + 1e-6;
        assert!(near(v.curvature, w.curvature), "{v:?} {w:?}");
        assert!(near(v.uv_footprint, w.uv_footprint), "{v:?} {w:?}");
        assert!((0.5..2.0).contains(&(w.clearance / v.clearance)), "{v:?} {w:?}");
        // The normal map's texels amplify the remaining difference.
        let bend = (v.shading_normal - w.shading_normal).length();
        assert!(bend < 2e-2, "{bend}: {v:?} {w:?}");
        let step = 0.01 * v.face_normal.any_orthonormal_vector();
        let steps = (step, Vec3::ZERO);
        let (turn, still) = normal_changes(copied.tables(), Features::ALL, &a, v.front, steps);
        let (other, _) = normal_changes(stored.tables(), Features::ALL, &b, w.front, steps);
        assert_eq!(still, Vec3::ZERO);
        assert!((turn - other).length() < 1e-3 * (1.0 + turn.length()), "{turn} {other}");
    }
    println!("{met} met an instance, {mirrored} a mirrored one, {others} differ");
    assert!(met > 8000 && mirrored > 2000 && others < 40, "{met} {mirrored} {others}");
}

#[test]
fn images_of_instances_match_those_of_copies() {
    let mut seed = 0;
    let [copied, stored] = rooms().map(|scene| {
        seed += 1;
        let config = RenderConfig {
            width: 64,
            height: 40,
            light_paths: Paths::Count(30_000),
            seed,
            ..RenderConfig::default()
        };
        let choice = RunnerChoice::Cpu { threads: 0 };
        Blocks::render(&choice, &scene, &config, &BASIC, &PHOTONS_GRID, 24)
    });
    let scores = stored.scores(&copied);
    println!("{scores:?}, caustics {} and {}", copied.caustic_share, stored.caustic_share);
    assert_eq!(stored.failure(&copied), None);
    assert!(copied.caustic_share > 1e-3);
}

/// On a device one bottom-level structure serves several instances.
#[test]
fn runners_agree_on_instances() {
    let Some(gpu) = gpu() else { return };
    let config =
        RenderConfig { width: 32, height: 32, light_paths: Paths::Count(1024), ..RenderConfig::default() };
    let [_, stored] = rooms();
    for &hardware in gpu.tracers() {
        let mut runners = RunnerPair::open(&gpu, hardware, &stored, &config);
        let rays = rays::through(&stored, 10_000);
        runners.write("rays", &rays);
        runners.step(&STEP_HIT, rays.len());
        let (cpu, device) = runners.head::<Hit>("hits", rays.len());
        let same = |a: &Hit, b: &Hit| {
            (a.instance, a.triangle) == (b.instance, b.triangle)
                && (a.is_miss() || (a.distance - b.distance).abs() <= 1e-4 * a.distance.max(1.0))
        };
        let others = cpu.iter().zip(&device).filter(|(a, b)| !same(a, b)).count();
        let met = cpu.iter().filter(|hit| hit.instance != 0).count();
        println!("hardware {hardware}: {met} met an instance, {others} differ");
        // The parity rule: 0.2 % on edges and slivers.
        assert!(met > 2000 && others <= 20, "hardware {hardware}: {met} {others}");
    }
}
