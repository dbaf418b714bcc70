//! Solids of one material that overlap solids of another have priorities of their own. They may share a mesh, be nodes
//! of one mesh, be instances, or move. Each scene is compared with one in which the small solid has a material of its
//! own.

use std::collections::BTreeSet;

use caustics::render_config::RenderConfig;
use caustics::scene::{Edits, LoadOptions, NodeEdit, Scene};
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::interface::choice::PixelFilter;
use caustics_kernels::interface::features::Features;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::method::path::PATH;
use caustics_kernels::surface::dispersion::Channel;
use caustics_kernels::trace::initial_media::initial_media_stack;
use caustics_tests::statistics::Mean;
use glam::{DVec3, Vec3};
use serde_json::{Value, json};

/// Materials by index. Both kinds of glass are the same glass.
const WALL: usize = 0;
const LIGHT: usize = 1;
const WATER: usize = 2;
const GLASS: usize = 3;
const OWN_GLASS: usize = 4;

/// A cube in a mesh: its material, centre, half side (m), and whether its fronts look inwards.
type Cube = (usize, [f64; 3], f64, bool);
/// A node: its mesh, translation (m) and scale.
type Node = (usize, [f64; 3], [f64; 3]);

/// Meshes and their nodes; the solid under test is around the origin.
struct Shape {
    name: &'static str,
    meshes: Vec<Vec<Cube>>,
    nodes: Vec<Node>,
}

/// A marble of glass in water, and larger glass elsewhere. `glass` is the marble's material.
fn shapes(glass: usize) -> Vec<Shape> {
    let at = [0.0; 3];
    let water = vec![(WATER, at, 0.5, false)];
    let one = [1.0; 3];
    vec![
        Shape {
            name: "a marble above a plate, two nodes of one mesh where materials are shared",
            meshes: vec![vec![(glass, at, 1.0, false)], vec![(GLASS, at, 1.0, false)], water.clone()],
            nodes: vec![
                (if glass == GLASS { 1 } else { 0 }, at, [0.2; 3]),
                (1, [0.0, -0.6, 0.0], [1.6, 0.2, 1.6]),
                (2, at, one),
            ],
        },
        Shape {
            name: "a marble and a far block in one mesh",
            meshes: vec![vec![(glass, at, 0.2, false), (GLASS, [3.0, 0.0, -3.0], 1.0, false)], water.clone()],
            nodes: vec![(0, at, one), (1, at, one)],
        },
        Shape {
            name: "a cup with a hole full of water, a marble in it",
            meshes: vec![vec![
                (GLASS, at, 0.6, false),
                (GLASS, at, 0.5, true),
                (WATER, at, 0.51, false),
                (glass, at, 0.2, false),
            ]],
            nodes: vec![(0, at, one)],
        },
        Shape {
            name: "cups of two sizes by two nodes of one mesh of three solids",
            meshes: vec![vec![(GLASS, at, 0.6, false), (WATER, at, 0.5, false), (glass, at, 0.2, false)]],
            nodes: vec![(0, at, one), (0, [1.5, 0.0, -1.0], [0.3; 3])],
        },
        Shape {
            name: "a mirrored, stretched marble in water in a block of glass",
            meshes: vec![vec![(glass, at, 1.0, false)], water, vec![(GLASS, at, 0.55, false)]],
            nodes: vec![(0, at, [-0.3, 0.2, 0.1]), (1, at, one), (2, at, one)],
        },
    ]
}

/// The glTF document of a shape with a floor, a light and a camera, and its buffer.
fn document(shape: &Shape) -> (Value, Vec<u8>) {
    let (mut binary, mut views, mut accessors, mut meshes) = (Vec::new(), vec![], vec![], vec![]);
    let room: Vec<Cube> = vec![(WALL, [0.0, -4.0, 0.0], 3.0, false), (LIGHT, [0.5, 2.5, 0.8], 0.3, false)];
    for cubes in shape.meshes.iter().chain([&room]) {
        let mut primitives: Vec<Value> = Vec::new();
        // Write one primitive for all cubes of a material.
        for material in cubes.iter().map(|cube| cube.0).collect::<BTreeSet<_>>() {
            let own: Vec<&Cube> = cubes.iter().filter(|cube| cube.0 == material).collect();
            let (mut positions, mut indices) = (Vec::new(), Vec::new());
            for &&(_, centre, half, inwards) in &own {
                let first = positions.len() as u16;
                positions.extend((0..8).map(|id| {
                    let side = |bit: u32| if id & bit == 0 { -half } else { half };
                    (DVec3::from(centre) + DVec3::new(side(1), side(2), side(4))).as_vec3()
                }));
                for [a, b, c, d] in
                    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
                {
                    for [a, b, c] in [[a, b, c], [a, c, d]] {
                        indices.extend((if inwards { [a, c, b] } else { [a, b, c] }).map(|id| first + id));
                    }
                }
            }
            let mut view = |bytes: Vec<u8>, mut accessor: Value| {
                views.push(json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len() }));
                binary.extend(bytes);
                accessor["bufferView"] = json!(views.len() - 1);
                accessors.push(accessor);
                accessors.len() - 1
            };
            let bound =
                |pick: fn(Vec3, Vec3) -> Vec3| positions.iter().copied().reduce(pick).unwrap().to_array();
            let (min, max) = (bound(Vec3::min), bound(Vec3::max));
            let bytes = positions.iter().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes).collect();
            let accessor = json!({ "componentType": 5126, "count": positions.len(), "type": "VEC3", "min": min, "max": max });
            let position = view(bytes, accessor);
            let accessor = json!({ "componentType": 5123, "count": indices.len(), "type": "SCALAR" });
            let indices = view(indices.iter().flat_map(|id| id.to_le_bytes()).collect(), accessor);
            let attributes = json!({ "POSITION": position });
            primitives.push(json!({ "attributes": attributes, "indices": indices, "material": material }));
        }
        meshes.push(json!({ "primitives": primitives }));
    }
    let glass = |ior: f64| {
        json!({
            "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.0 },
            "extensions": {
                "KHR_materials_ior": { "ior": ior },
                "KHR_materials_transmission": { "transmissionFactor": 1.0 },
                "KHR_materials_volume": {
                    "thicknessFactor": 1.0, "attenuationDistance": 0.5, "attenuationColor": [0.5, 0.7 * ior / 1.5, 0.9],
                },
            },
        })
    };
    let lambert =
        json!({ "pbrMetallicRoughness": { "metallicFactor": 0.0, "baseColorFactor": [0.6, 0.6, 0.6, 1.0] } });
    let emissive = json!({ "emissiveFactor": [1, 1, 1] });
    let nodes = shape.nodes.iter().copied().chain([(shape.meshes.len(), [0.0; 3], [1.0; 3])]);
    let nodes = nodes.map(
        |(mesh, translation, scale)| json!({ "mesh": mesh, "translation": translation, "scale": scale }),
    );
    let mut nodes: Vec<Value> = nodes.collect();
    nodes.push(json!({ "camera": 0, "translation": [0.0, 0.0, 3.0] }));
    let document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{
            "nodes": (0..nodes.len()).collect::<Vec<_>>(), "extras": { "environment": { "color": [0.6, 0.8, 1.0] } },
        }],
        "nodes": nodes,
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.6, "znear": 0.1 } }],
        "meshes": meshes,
        "materials": [lambert, emissive, glass(1.33), glass(1.5), glass(1.5)],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": binary.len(), "uri": "scene.bin" }],
        "extensionsUsed": ["KHR_materials_ior", "KHR_materials_transmission", "KHR_materials_volume"],
    });
    (document, binary)
}

/// Storage of meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kept {
    /// Copies in world space.
    Copies,
    /// Once for several nodes.
    Once,
    /// Instances that may move.
    Grabbed,
}

fn load(shape: &Shape, kept: Kept) -> Scene {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.gltf");
    let (document, binary) = document(shape);
    std::fs::write(&path, document.to_string()).unwrap();
    std::fs::write(folder.path().join("scene.bin"), binary).unwrap();
    let grabbed = (0..shape.nodes.len()).filter(|_| kept == Kept::Grabbed).collect();
    let copies = if kept == Kept::Once { 0 } else { u64::MAX };
    Scene::load_with(&path, &LoadOptions { grabbed, copies, ..LoadOptions::default() }).expect("it loads")
}

/// Index of refraction at positions around the origin (m from it).
fn indices(scene: &Scene, positions: &[Vec3]) -> Vec<f32> {
    let features = scene.features(0.25) | Features::STARTS_IN_MEDIUM;
    let mut tracer = scene.tracer(features);
    let at = |position: &Vec3| {
        let position = *position - scene.origin.as_vec3();
        let media = initial_media_stack(position, features, scene.tables(), &mut tracer);
        media.ior(Channel::GREEN, Features(0), &scene.materials)
    };
    positions.iter().map(at).collect()
}

/// Positions around the solid at the origin, and in it.
fn positions() -> Vec<Vec3> {
    let position = |index| 2.4 * (Rng::new(Stream::Camera, 13, index, 0).next4().truncate() - 0.5);
    [Vec3::ZERO].into_iter().chain((0..300).map(position)).collect()
}

const SIZE: [u32; 2] = [32, 32];
const FRAMES: u32 = 24;

/// Sums over the middle of an image, where the marble is seen, and over all of it, frame by frame.
fn rendered(scene: &Scene, seed: u32) -> [Mean; 2] {
    let [width, height] = SIZE;
    let config = RenderConfig {
        width,
        height,
        seed,
        max_bounces: 10,
        pixel_filter: PixelFilter::Box,
        ..RenderConfig::default()
    };
    let (runner, features) = (RunnerChoice::Cpu { threads: 0 }, scene.features(0.25));
    let camera = &scene.cameras[0];
    let mut session =
        Session::new(&runner, scene, camera, &RenderConfig { method: &PATH, ..config.clone() }, features)
            .expect("a session opens");
    let mut sums = [const { Vec::new() }; 2];
    for frame in 0..FRAMES {
        session.frame(frame).expect("a frame runs");
        let beauty = session.image().expect("an image").beauty();
        let is_middle = |id: usize| {
            let (x, y) = (id as u32 % width, id as u32 / width);
            (12..20).contains(&x) && (12..20).contains(&y)
        };
        let sum = |ids: &dyn Fn(usize) -> bool| {
            let values = beauty.iter().enumerate().filter(|&(id, _)| ids(id));
            values.map(|(_, v)| f64::from(v.element_sum())).sum::<f64>()
        };
        sums[0].push(sum(&is_middle));
        sums[1].push(sum(&|_| true));
    }
    sums.map(|sums| Mean::from_samples(&sums))
}

#[test]
fn solids_sharing_a_material_have_the_media_of_solids_with_their_own() {
    let positions = positions();
    for (shared, own) in shapes(GLASS).iter().zip(shapes(OWN_GLASS)) {
        for kept in [Kept::Copies, Kept::Once, Kept::Grabbed] {
            let (scene, other) = (load(shared, kept), load(&own, kept));
            assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
            let found = indices(&scene, &positions);
            assert_eq!(found[0], 1.5, "{}, {kept:?}: the marble", shared.name);
            assert_eq!(found, indices(&other, &positions), "{}, {kept:?}", shared.name);
            assert!([1.0, 1.33, 1.5].iter().all(|ior| found.contains(ior)));
            // The names of materials stay those of the file.
            assert_eq!(scene.material_names.len(), 6);
        }
    }
}

#[test]
fn solids_sharing_a_material_look_like_solids_with_their_own() {
    for (shared, own) in shapes(GLASS).iter().zip(shapes(OWN_GLASS)) {
        for kept in [Kept::Copies, Kept::Once] {
            let [middle, all] = rendered(&load(shared, kept), 1);
            let [middle_of_own, all_of_own] = rendered(&load(&own, kept), 2);
            let off = (middle.value / middle_of_own.value, all.value / all_of_own.value);
            println!("{}, {kept:?}: middle {:.4}, all {:.4}", shared.name, off.0, off.1);
            assert!(middle.agrees(&middle_of_own, 3.5), "{}: {middle:?} {middle_of_own:?}", shared.name);
            assert!(all.agrees(&all_of_own, 3.5), "{}: {all:?} {all_of_own:?}", shared.name);
            // Losing the marble would change the middle by more than a tenth.
            assert!(middle.error < 0.03 * middle.value, "the test is noisy: {middle:?}");
        }
    }
}

/// A grabbed marble keeps the priority of its size in the file, although it is moved and made larger than the block.
#[test]
fn moved_and_scaled_solid_keeps_its_priority() {
    let shape = &shapes(GLASS)[0];
    let mut scene = load(shape, Kept::Grabbed);
    let translation = Some([0.2, 0.1, 0.0]);
    let node = NodeEdit { node: 0, translation, scale: Some([0.25; 3]), ..NodeEdit::default() };
    scene.play(&Edits { nodes: vec![node], ..Edits::default() }).expect("the edit plays");
    scene.pose(0.0).expect("a pose");
    let at = [Vec3::new(0.4, 0.3, 0.1), Vec3::new(-0.1, 0.0, 0.0), Vec3::new(0.0, -0.45, 0.0)];
    assert_eq!(indices(&scene, &at), [1.5, 1.33, 1.33]);
}

/// Overlapping solids of one material are one solid without a face between them, although the smaller has a record of
/// its own. A path through both is refracted twice.
#[test]
fn overlapping_solids_of_one_material_have_no_face_between_them() {
    let at = [0.0; 3];
    let shape = Shape {
        name: "a cup whose marble reaches into its wall",
        meshes: vec![vec![
            (GLASS, at, 0.6, false),
            (WATER, at, 0.5, false),
            (GLASS, [0.0, 0.0, 0.4], 0.3, false),
        ]],
        nodes: vec![(0, at, [1.0; 3])],
    };
    let scene = load(&shape, Kept::Copies);
    assert!(scene.materials.len() > scene.material_names.len(), "the marble has a record of its own");
    let config = RenderConfig { width: 8, height: 8, max_bounces: 8, ..RenderConfig::default() };
    let world = caustics_tests::direct::World::new(&scene, &config);
    let at = [Vec3::new(0.0, 0.0, 0.55), Vec3::new(0.0, 0.0, 0.3), Vec3::new(0.45, 0.45, 0.45)];
    assert_eq!(indices(&scene, &at), [1.5, 1.5, 1.33]);
    // Follow the view: into the marble's front outside of the cup, out of it into water, into the wall, and out of the
    // cup.
    let features = scene.features(0.25);
    let mut tracer = world.tracer();
    let mut media = caustics_kernels::surface::media::MediaStack::VACUUM;
    let direction = Vec3::NEG_Z;
    let mut ray = caustics_kernels::interface::ray::Ray::endless(
        Vec3::new(0.01, 0.02, 2.0) - scene.origin.as_vec3(),
        direction,
    );
    let mut met = Vec::new();
    loop {
        let traced = caustics_kernels::trace::through_media::trace_through_media(
            &ray,
            media,
            features,
            scene.tables(),
            &mut tracer,
        );
        if traced.hit.is_miss() {
            break;
        }
        let here =
            caustics_kernels::surface::vertex::vertex(scene.tables(), features, &ray, &traced.hit, 0.0);
        met.push((
            here.position.z + scene.origin.z as f32,
            traced.media.ior(Channel::GREEN, Features(0), &scene.materials),
        ));
        media = traced.media.at_face(here.material, here.front, features, &scene.materials).behind;
        ray.origin =
            caustics_kernels::math::offset::leave(here.position, here.face_normal, direction, here.clearance);
    }
    let expected = [(0.7, 1.0), (0.1, 1.5), (-0.5, 1.33), (-0.6, 1.5)];
    assert_eq!(met.len(), expected.len(), "{met:?}");
    for ((z, ior), (expected_z, expected_ior)) in met.into_iter().zip(expected) {
        assert!((z - expected_z).abs() < 1e-5 && ior == expected_ior, "{z} {ior}");
    }
}
