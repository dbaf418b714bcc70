//! Edits of a scene: against files of these transforms, by formulas, and by the node of a hit.

use caustics::render_config::Paths;
use std::collections::BTreeSet;

use caustics::render_config::RenderConfig;
use caustics::scene::{CameraChoice, CameraEdit, Edits, Keyframe, LoadOptions, NodeEdit, Scene, SceneError};
use caustics::scene::{DefaultLight, Recorded, Staging};
use caustics::session::RunnerChoice;
use caustics_kernels::gather::variant::PHOTONS_GRID;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::instance::Transform;
use caustics_kernels::interface::light::Light;
use caustics_kernels::interface::ray::Ray;
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::surface::vertex::vertex;
use caustics_kernels::trace::Tracer;
use caustics_tests::blocks::Blocks;
use caustics_tests::rays;
use caustics_tests::scenes::copied;
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use serde_json::{Value, json};

use super::animation::{File, aimed, deforming, square, triangles};

/// Loads a scene whose given nodes may be edited.
fn grabbed(name: &str, nodes: &[usize]) -> Scene {
    let options = LoadOptions { grabbed: nodes.iter().copied().collect(), ..LoadOptions::default() };
    let (folder, _) = copied(name);
    Scene::load_with(&folder.path().join("scene.gltf"), &options).unwrap()
}

/// Loads a scene after a change of its document.
fn changed(name: &str, change: impl FnOnce(&mut Value)) -> Scene {
    let (folder, mut document) = copied(name);
    change(&mut document);
    let path = folder.path().join("scene.gltf");
    std::fs::write(&path, document.to_string()).unwrap();
    Scene::load(&path).unwrap()
}

/// An edit of translation, rotation and scale.
fn edit(node: usize, translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> NodeEdit {
    let (translation, rotation, scale) = (Some(translation), Some(rotation), Some(scale));
    NodeEdit { node, translation, rotation, scale, ..NodeEdit::default() }
}

/// Writes edits into the nodes of a document.
fn write(document: &mut Value, edits: &[NodeEdit]) {
    for edit in edits {
        let node = document["nodes"][edit.node].as_object_mut().unwrap();
        for (part, value) in [
            ("translation", json!(edit.translation)),
            ("rotation", json!(edit.rotation)),
            ("scale", json!(edit.scale)),
        ] {
            if !value.is_null() {
                node.insert(part.into(), value);
            }
        }
    }
}

/// Asserts that two scenes show the same: hits of rays, lights and cameras. Returns the number of rays that met an
/// instance.
fn shows_the_same(edited: &Scene, written: &Scene) -> u32 {
    let shift = (written.origin - edited.origin).as_vec3();
    let features = edited.features(0.25);
    let (mut a, mut b) = (edited.tracer(features), written.tracer(written.features(0.25)));
    let (mut met, mut others) = (0, 0);
    for here in rays::through(edited, 10_000).into_iter().chain(aimed(edited, 10_000)) {
        let ray = Ray { origin: here.origin - shift, ..here };
        let (hit, expected) = (a.closest(&here), b.closest(&ray));
        if hit.is_miss() && expected.is_miss() {
            continue;
        }
        let same = hit.is_miss() == expected.is_miss() && (hit.distance - expected.distance).abs() <= 1e-4;
        others += u32::from(!same);
        if !same {
            continue;
        }
        met += u32::from(hit.instance != 0);
        let v = vertex(edited.tables(), Features::ALL, &here, &hit, 0.0);
        let w = vertex(written.tables(), Features::ALL, &ray, &expected, 0.0);
        assert!((v.position - w.position - shift).length() < 1e-4, "{v:?} {w:?}");
        let (v, w) = ((v.material, v.front, v.face_normal), (w.material, w.front, w.face_normal));
        assert_eq!((v.0, v.1), (w.0, w.1));
        assert!((v.2 - w.2).length() < 1e-3, "{v:?} {w:?}");
    }
    // A ray meets either of two faces that coincide.
    assert!(others < 20, "{others} of 20,000 differ");

    let lights = |scene: &Scene| -> Vec<(Vec3, Light)> {
        let middle = |light: &Light| {
            let t = scene.world_triangle(light.instance, light.triangle);
            (t.a + t.b + t.c) / 3.0
        };
        let is_area = |light: &Light| light.kind == Features::AREA_LIGHTS.0;
        let position = |light: &Light| if is_area(light) { middle(light) } else { light.position };
        scene.lights.iter().map(|light| (position(light), *light)).collect()
    };
    let (ours, theirs) = (lights(edited), lights(written));
    assert_eq!(ours.len(), theirs.len());
    // Instances come after the world, so that the order differs.
    let nearest = |(position, light): &(Vec3, Light)| {
        let off = |(at, other): &(Vec3, Light)| {
            let size = (other.area - light.area).abs() / light.area.max(1e-9);
            let probability = (other.pdf_light_choice / light.pdf_light_choice - 1.0).abs();
            let turn = (other.direction - light.direction).length();
            (*at - *position - shift).length().max(turn).max(size).max(probability)
        };
        ours.iter().map(off).fold(f32::MAX, f32::min)
    };
    let worst = theirs.iter().map(nearest).fold(0.0, f32::max);
    assert!(worst < 1e-4, "a light is off by {worst}");
    assert!(((edited.flux - written.flux) / written.flux).abs().max_element() < 1e-5);
    for (a, b) in edited.cameras.iter().zip(&written.cameras) {
        assert!((a.position - b.position - shift).length() < 1e-5);
        assert!((a.forward - b.forward).length() < 1e-6 && (a.right - b.right).length() < 1e-6);
    }
    met
}

#[test]
fn edited_scene_matches_a_file_with_these_transforms() {
    let turn = [0.0, 0.6, 0.0, 0.8];
    for (name, edits) in [
        // A glass ball, a ring that is mirrored, a spot, the camera.
        (
            "still-life",
            vec![
                edit(14, [0.2, 0.25, 0.1], turn, [1.0, 0.7, 1.2]),
                edit(16, [-0.1, 0.3, 0.2], [0.48, 0.0, 0.36, 0.8], [-1.0, 1.0, 1.0]),
                NodeEdit { node: 20, translation: Some([0.3, 1.9, 0.4]), ..NodeEdit::default() },
                NodeEdit { node: 22, rotation: Some([0.0, 0.1, 0.0, 0.99]), ..NodeEdit::default() },
            ],
        ),
        // An area light, and a ring.
        (
            "mirror-room",
            vec![
                edit(8, [0.3, -0.5, 0.2], [0.1, 0.0, 0.0, 0.995], [1.5, 1.0, 0.5]),
                NodeEdit { node: 12, scale: Some([1.2, 1.4, 1.1]), ..NodeEdit::default() },
            ],
        ),
    ] {
        let nodes: Vec<usize> = edits.iter().map(|edit| edit.node).collect();
        let mut edited = grabbed(name, &nodes);
        assert!(edited.is_animated() && edited.duration() == 0.0);
        edited.edit(&edits).unwrap();
        edited.pose(0.0).unwrap();
        let written = changed(name, |document| write(document, &edits));
        let met = shows_the_same(&edited, &written);
        assert!(met > 300, "{name}: {met}");
        for node in edited.node_tree() {
            let there = written.node_to_world(node.index, 0.0).unwrap();
            let here = edited.node_to_world(node.index, 0.0).unwrap();
            // The file's numbers have 32 bits.
            assert!(here.abs_diff_eq(there, 1e-6), "{name}: {node:?}");
        }
        // Undone, all is as in the file.
        edited.edit(&[]).unwrap();
        edited.pose(0.0).unwrap();
        shows_the_same(&edited, &changed(name, |_| ()));
    }
}

#[test]
fn edit_without_a_change_keeps_the_image() {
    let nodes = [6, 8, 11, 12];
    let mut scene = grabbed("mirror-room", &nodes);
    let rest = scene.node_tree();
    let edits: Vec<NodeEdit> = nodes
        .iter()
        .map(|&index| {
            let node = rest.iter().find(|node| node.index == index).unwrap();
            assert!(node.has_mesh && node.moves && node.parent.is_none());
            edit(index, node.translation.into(), node.rotation.into(), node.scale.into())
        })
        .collect();
    scene.edit(&edits).unwrap();
    scene.pose(0.0).unwrap();
    assert_eq!(scene.instanced.instances.len(), 4);
    let mut seed = 0;
    let [baked, edited] = [changed("mirror-room", |_| ()), scene].map(|scene| {
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
    let scores = edited.scores(&baked);
    println!("{scores:?}, caustics {} and {}", baked.caustic_share, edited.caustic_share);
    assert_eq!(edited.failure(&baked), None);
    assert!(scores.whole.abs() < 3.0 && baked.caustic_share > 1e-3);
}

/// Middles of all triangles in the file's coordinates (m), with instance and id, sorted by x.
fn middles(scene: &Scene) -> Vec<(DVec3, u32, u32)> {
    let middle = |(instance, id, t): (u32, u32, caustics_kernels::interface::triangle::Triangle)| {
        (scene.origin + (t.a + t.b + t.c).as_dvec3() / 3.0, instance, id)
    };
    let mut all: Vec<_> = triangles(scene).into_iter().map(middle).collect();
    all.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
    all
}

#[test]
fn hit_triangle_belongs_to_the_node_of_its_mesh() {
    let (folder, document) = copied("still-life");
    let path = folder.path().join("scene.gltf");
    let options = |nodes: &[usize]| LoadOptions {
        grabbed: nodes.iter().copied().collect(),
        floor: true,
        ..LoadOptions::default()
    };
    // Find the triangles of each mesh by itself.
    let nodes: Vec<usize> = (0..19).collect();
    let alone = |node: &usize| {
        let mut document = document.clone();
        document["scenes"][0]["nodes"] = json!([node]);
        let path = folder.path().join("alone.gltf");
        std::fs::write(&path, document.to_string()).unwrap();
        middles(&Scene::load(&path).unwrap())
    };
    let alone: Vec<_> = nodes.iter().map(alone).collect();
    for grabbed in [&[][..], &[14, 16, 3]] {
        let scene = Scene::load_with(&path, &options(grabbed)).unwrap();
        let mut counts = vec![0; nodes.len()];
        let mut of_none = 0;
        for (middle, instance, triangle) in middles(&scene) {
            let Some(node) = scene.node_of(instance, triangle) else {
                of_none += 1;
                continue;
            };
            assert_eq!(instance != 0, grabbed.contains(&node));
            counts[node] += 1;
            let near = &alone[node][alone[node].partition_point(|other| other.0.x < middle.x - 1e-5)..];
            let mut near = near.iter().take_while(|other| other.0.x <= middle.x + 1e-5);
            assert!(
                near.any(|other| other.0.distance(middle) < 1e-5),
                "node {node} has no triangle at {middle}"
            );
        }
        // The floor under the scene belongs to no node.
        assert_eq!(of_none, 2);
        assert_eq!(counts, alone.iter().map(Vec::len).collect::<Vec<_>>());
        assert_eq!((scene.node_of(99, 0), scene.node_of(0, u32::MAX)), (None, None));
    }
}

#[test]
fn gpu_instances_belong_to_their_node_and_move_with_it() {
    let file = || {
        let mut file = still();
        let translations = file.accessor("VEC3", 3, &[0.0, 0.0, 1.0, 0.5, 0.0, 1.0, 0.0, 0.5, 1.0]);
        let instancing = json!({ "attributes": { "TRANSLATION": translations } });
        let mesh = file.mesh(&square(0.1), 2);
        let node = json!({ "mesh": mesh, "extensions": { "EXT_mesh_gpu_instancing": instancing } });
        file.document["extensionsUsed"] = json!(["KHR_lights_punctual", "EXT_mesh_gpu_instancing"]);
        assert_eq!(file.root(node), 5);
        file
    };
    for grabbed in [&[][..], &[5]] {
        let mut scene = load(file(), grabbed).unwrap();
        let count = |scene: &Scene, node| {
            let all = triangles(scene).into_iter();
            all.filter(|(instance, id, _)| scene.node_of(*instance, *id) == Some(node)).count()
        };
        assert_eq!([0, MIRROR, 5].map(|node| count(&scene, node)), [2, 2, 6]);
        assert_eq!(scene.node_tree().len(), 6);
        if grabbed.is_empty() {
            continue;
        }
        // They move with it.
        let before = middles(&scene);
        scene
            .edit(&[NodeEdit { node: 5, translation: Some([0.0, 0.0, 2.0]), ..NodeEdit::default() }])
            .unwrap();
        scene.pose(0.0).unwrap();
        for (middle, instance, triangle) in middles(&scene) {
            let (was, ..) = *before.iter().find(|other| (other.1, other.2) == (instance, triangle)).unwrap();
            let up = if instance == 0 { 0.0 } else { 2.0 };
            assert!((middle - was - DVec3::Z * up).length() < 1e-6);
        }
    }
}

/// A scene at rest: a floor, a camera, a spot below a node, a mirror that a matrix shears.
fn still() -> File {
    let mut file = File::new();
    let floor = file.mesh(&square(3.0), 0);
    file.root(json!({ "name": "floor", "mesh": floor }));
    file.root(json!({ "camera": 0, "translation": [0, 0, 6] }));
    let spot = file
        .push("nodes", json!({ "name": "spot", "extensions": { "KHR_lights_punctual": { "light": 1 } } }));
    file.root(json!({ "name": "arm", "children": [spot], "translation": [1, 0, 2] }));
    let mirror = file.mesh(&square(0.5), 2);
    let sheared = [1.0, 0.0, 0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0, 1.0];
    file.root(json!({ "name": "mirror", "mesh": mirror, "matrix": sheared }));
    file
}

const SPOT: usize = 2;
const ARM: usize = 3;
const MIRROR: usize = 4;

fn load(mut file: File, nodes: &[usize]) -> Result<Scene, SceneError> {
    let grabbed: BTreeSet<usize> = nodes.iter().copied().collect();
    file.write_and_load(&LoadOptions { grabbed, ..LoadOptions::default() })
}

#[test]
fn node_tree_reports_nodes_at_rest() {
    let scene = load(still(), &[ARM]).unwrap();
    let tree = scene.node_tree();
    let node = |index| tree.iter().find(|node| node.index == index).unwrap();
    assert_eq!(tree.len(), 5);
    let (arm, spot, mirror) = (node(ARM), node(SPOT), node(MIRROR));
    assert_eq!(
        (arm.name.as_deref(), arm.parent, arm.translation),
        (Some("arm"), None, DVec3::new(1.0, 0.0, 2.0))
    );
    assert_eq!((arm.has_mesh, arm.has_light, arm.has_camera, arm.moves), (false, false, false, true));
    // Nodes below a grabbed node move too.
    assert_eq!((spot.parent, spot.has_light, spot.moves), (Some(ARM), true, true));
    assert_eq!((mirror.has_mesh, mirror.moves, node(1).has_camera), (true, false, true));
    assert_eq!(scene.node_to_world(SPOT, 0.0).unwrap().translation, DVec3::new(1.0, 0.0, 2.0));
    assert_eq!(scene.node_to_world(9, 0.0), None);
}

#[test]
fn matrix_of_a_node_keeps_its_unedited_parts() {
    let mut scene = load(still(), &[MIRROR]).unwrap();
    let sheared = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::Z * 2.0);
    let to_world = |scene: &Scene| scene.node_to_world(MIRROR, 0.0).unwrap();
    assert_eq!(to_world(&scene), DAffine3 { matrix3: sheared, translation: DVec3::new(0.0, 0.0, 1.0) });
    let there = NodeEdit { node: MIRROR, translation: Some([1.0, 2.0, 3.0]), ..NodeEdit::default() };
    scene.edit(&[there]).unwrap();
    assert_eq!(to_world(&scene), DAffine3 { matrix3: sheared, translation: DVec3::new(1.0, 2.0, 3.0) });
    // Given all three parts, the edit replaces the matrix.
    scene.edit(&[edit(MIRROR, [0.0, 1.0, 0.0], [0.0, 0.0, 1.0, 0.0], [1.0, 2.0, 3.0])]).unwrap();
    let given = DAffine3::from_scale_rotation_translation(
        DVec3::new(1.0, 2.0, 3.0),
        DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0),
        DVec3::Y,
    );
    assert_eq!(to_world(&scene), given);
}

#[test]
fn keys_move_nodes_and_the_camera() {
    let mut scene = load(still(), &[ARM, MIRROR]).unwrap();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let camera = |x: f64, fov: f64| CameraEdit { from: [x, 0.0, 5.0], look_at: [0.0, x, 0.0], fov };
    let key = |time: f64, nodes, camera| Keyframe { time, camera, nodes };
    let arm = |rotation| NodeEdit { node: ARM, rotation: Some(rotation), ..NodeEdit::default() };
    let mirror = |x| NodeEdit { node: MIRROR, translation: Some([x, 0.0, 1.0]), ..NodeEdit::default() };
    let edits = Edits {
        camera: None,
        // Keys take precedence over constant parts, which set what keys leave.
        nodes: vec![edit(ARM, [2.0, 0.0, 2.0], [1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0])],
        keys: vec![
            key(1.0, vec![arm([0.0, 0.0, 0.0, 1.0]), mirror(0.0)], Some(camera(1.0, 30.0))),
            key(2.0, vec![mirror(1.0)], None),
            key(3.0, vec![arm([0.0, half, 0.0, half])], Some(camera(3.0, 50.0))),
        ],
    };
    let before = scene.fingerprint();
    scene.play(&edits).unwrap();
    assert_ne!(scene.fingerprint(), before, "the fingerprint lacks the keys");
    assert_eq!(scene.duration(), 3.0);
    for (time, angle, x, at) in
        [(0.0, 0.0, 0.0, 1.0), (1.5, 22.5_f64, 0.5, 1.5), (2.5, 67.5, 1.0, 2.5), (9.0, 90.0, 1.0, 3.0)]
    {
        scene.pose(time).unwrap();
        let to_world = scene.node_to_world(SPOT, time).unwrap();
        let expected = DAffine3::from_rotation_translation(
            DQuat::from_rotation_y(angle.to_radians()),
            DVec3::new(2.0, 0.0, 2.0),
        );
        assert!(to_world.abs_diff_eq(expected, 1e-12), "at {time} s: {to_world}");
        // The tables follow: the spot shines along -z of its node.
        let spot = &scene.lights[0];
        assert!((spot.direction.as_dvec3() - expected.matrix3 * DVec3::NEG_Z).length() < 1e-6);
        assert!((spot.position.as_dvec3() + scene.origin - expected.translation).length() < 1e-6);
        let instance = scene.instanced.instance_transforms()[0].to_world.unwrap();
        assert!((f64::from(instance.offset.x) + scene.origin.x - x).abs() < 1e-6, "at {time} s");
        let seen = scene.camera(Some(Recorded::NAME)).unwrap();
        let (eye, target) = (DVec3::new(at, 0.0, 5.0), DVec3::new(0.0, at, 0.0));
        assert!((seen.position.as_dvec3() + scene.origin - eye).length() < 1e-6, "at {time} s: {seen:?}");
        assert!((seen.forward.as_dvec3() - (target - eye).normalize()).length() < 1e-6);
        assert!((f64::from(seen.fov_y).to_degrees() - (20.0 + 10.0 * at)).abs() < 1e-4);
    }
    // In a scene in which nothing else moves, the camera alone does.
    let mut scene = load(still(), &[]).unwrap();
    let keys = vec![key(0.0, vec![], Some(camera(0.0, 40.0))), key(1.0, vec![], Some(camera(1.0, 40.0)))];
    scene.play(&Edits { keys, ..Edits::default() }).unwrap();
    assert!(scene.is_animated() && scene.motion.is_none() && scene.duration() == 1.0);
    scene.pose(0.5).unwrap();
    assert!(
        (scene.camera(Some(Recorded::NAME)).unwrap().position.as_dvec3().x + scene.origin.x - 0.5).abs()
            < 1e-6
    );
}

#[test]
fn edited_joint_deforms_its_mesh() {
    const ELBOW: usize = 3;
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mut file = deforming();
    file.document["animations"] = json!([]);
    let mut edited = load(file, &[ELBOW]).unwrap();
    let rotation = Some([0.0, 0.0, half, half]);
    edited.edit(&[NodeEdit { node: ELBOW, rotation, ..NodeEdit::default() }]).unwrap();
    edited.pose(0.0).unwrap();
    let mut animated = deforming().write_and_load(&LoadOptions::default()).unwrap();
    animated.pose(2.0).unwrap();
    let tube = |scene: &Scene| -> Vec<DVec3> {
        let of_tube = middles(scene).into_iter().filter(|(_, instance, _)| *instance == 1);
        of_tube.map(|(middle, ..)| middle).collect()
    };
    let (ours, theirs) = (tube(&edited), tube(&animated));
    assert_eq!((ours.len(), theirs.len()), (240, 240));
    for middle in ours {
        let off = theirs.iter().map(|other| other.distance(middle)).fold(f64::MAX, f64::min);
        assert!(off < 2e-6, "{middle} is {off} m away");
    }
    assert_eq!(
        edited.node_of(1, edited.instanced.triangle_ids(1).start as u32),
        Some(5),
        "the tube's own node"
    );
}

#[test]
fn invalid_edits_are_refused_and_change_nothing() {
    let node_edit = |node, name: Option<&str>, x| NodeEdit {
        node,
        name: name.map(Into::into),
        translation: Some([x, 0.0, 1.0]),
        ..NodeEdit::default()
    };
    let error = load(still(), &[7]).unwrap_err().to_string();
    assert!(error.contains("moving.gltf: its scene has no node 7"), "{error}");

    let mut scene = load(still(), &[MIRROR]).unwrap();
    scene.edit(&[node_edit(MIRROR, Some("mirror"), 0.25)]).unwrap();
    scene.pose(0.0).unwrap();
    let tables = |scene: &Scene| {
        (scene.instances.clone(), scene.nodes.clone(), scene.lights.clone(), scene.cameras.clone())
    };
    let (before, stands) = (tables(&scene), scene.node_to_world(MIRROR, 0.0));
    for (edit, words) in [
        (node_edit(MIRROR, Some("spot"), 0.0), "node 4 is called \"mirror\", but the edits are of \"spot\""),
        (node_edit(1, Some("eye"), 0.0), "node 1 has no name"),
        (node_edit(0, None, 0.0), "stands still"),
        (node_edit(7, None, 0.0), "has no node 7"),
        (node_edit(MIRROR, None, f64::NAN), "not finite"),
    ] {
        let error = scene.edit(&[edit]).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
        assert_eq!(scene.node_to_world(MIRROR, 0.0), stands);
    }
    // The pose refuses an edit that is valid and cannot be shown.
    scene.edit(&[node_edit(MIRROR, None, 1e10)]).unwrap();
    let error = scene.pose(0.0).unwrap_err().to_string();
    assert!(error.contains("as it is edited, cannot be shown: at 0 s its mesh reaches beyond"), "{error}");
    assert_eq!(tables(&scene), before);
    scene.edit(&[node_edit(MIRROR, None, 0.25)]).unwrap();
    scene.pose(0.0).unwrap();
    let transforms = |scene: &Scene| {
        scene.instances.iter().map(|instance| (instance.to_world, instance.to_object)).collect::<Vec<_>>()
    };
    assert_eq!(
        transforms(&scene),
        before.0.iter().map(|instance| (instance.to_world, instance.to_object)).collect::<Vec<_>>()
    );
}

/// Dragging nodes, and rendering the file that is kept of it, give the same tables.
#[test]
fn edits_loaded_from_a_file_give_the_dragged_scene() {
    let (folder, _) = copied("mirror-room");
    let path = folder.path().join("scene.gltf");
    let staged = |edits: Option<Edits>, grabbed: &[usize]| {
        let load = LoadOptions { grabbed: grabbed.iter().copied().collect(), ..LoadOptions::default() };
        let camera = CameraChoice::First;
        let (environment, default_light, aspect) = (None, DefaultLight::Always, 1.5);
        Staging { camera, load, edits, environment, default_light, aspect }.load(&path).unwrap()
    };
    let edits = Edits {
        camera: Some(CameraEdit { from: [0.3, 1.1, 2.0], look_at: [0.0, 0.9, -1.0], fov: 47.5 }),
        nodes: vec![edit(12, [0.1, 0.02, 0.1], [0.0, 0.3, 0.0, 0.95], [1.1, 1.1, 1.1])],
        keys: vec![],
    };
    let mut dragged = staged(None, &[12]).scene;
    for share in [0.2, 0.7, 1.0] {
        let translation = Some([0.1 * share, 0.02 * share, 0.1 * share]);
        dragged.edit(&[NodeEdit { translation, ..edits.nodes[0].clone() }]).unwrap();
        dragged.pose(0.0).unwrap();
    }
    let camera = dragged.place_camera(&edits.camera.unwrap().viewpoint(), 1.5).unwrap().clone();
    let kept = staged(Some(Edits::parse(&edits.to_toml().unwrap()).unwrap()), &[]);
    let mut scene = kept.scene;
    assert_eq!(scene.camera(Some(&kept.camera)).unwrap(), &camera);
    assert!(
        scene.instances.iter().all(|instance| instance.to_previous == Transform::IDENTITY),
        "nothing moved yet"
    );
    scene.pose(0.0).unwrap();
    // Compare all but the previous transforms.
    for instance in dragged.instances.iter_mut().chain(&mut scene.instances) {
        instance.to_previous = Transform::IDENTITY;
    }
    assert_eq!(scene.fingerprint(), dragged.fingerprint());
    assert!(scene.additions.contains_key("edits"));
}
