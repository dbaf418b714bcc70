//! Animated scenes: poses against static files and formulas, instances against every triangle, lights that go out.

use caustics::render_config::Paths;
use std::f64::consts::PI;

use caustics::render_config::RenderConfig;
use caustics::scene::{LoadOptions, Scene, SceneError};
use caustics::session::{RunnerChoice, Session};
use caustics::upload::Upload;
use caustics_kernels::interface::NONE;
use caustics_kernels::interface::choice::LightSampler;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::ray::{Hit, Ray};
use caustics_kernels::interface::triangle::Triangle;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::math::warp::uniform_sphere;
use caustics_kernels::method::path::PATH;
use caustics_kernels::pass::step::STEP_HIT;
use caustics_kernels::trace::Tracer;
use caustics_tests::gpu::gpu;
use caustics_tests::parity::RunnerPair;
use caustics_tests::rays;
use glam::{DQuat, DVec3, Vec3};
use serde_json::{Value, json};

/// A glTF file under construction.
pub(super) struct File {
    pub(super) document: Value,
    bytes: Vec<u8>,
}

impl File {
    pub(super) fn new() -> File {
        let document = json!({
            "asset": { "version": "2.0" },
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": { "KHR_lights_punctual": { "lights": [
                { "type": "point", "intensity": 5.0 },
                { "type": "spot", "intensity": 7.0, "spot": { "outerConeAngle": 0.6 } },
            ] } },
            "scene": 0, "scenes": [{ "nodes": [] }], "nodes": [],
            "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.9, "znear": 0.1 } }],
            "materials": [
                { "name": "white", "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 } },
                { "name": "lamp", "emissiveFactor": [1, 1, 1] },
                { "name": "mirror", "pbrMetallicRoughness": { "metallicFactor": 1.0, "roughnessFactor": 0.0 } },
            ],
            "meshes": [], "accessors": [], "bufferViews": [], "buffers": [{}],
            "animations": [{ "name": "all", "channels": [], "samplers": [] }],
        });
        File { document, bytes: Vec::new() }
    }

    pub(super) fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.document[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub(super) fn accessor(&mut self, kind: &str, width: usize, values: &[f32]) -> usize {
        let (offset, length) = (self.bytes.len(), 4 * values.len());
        self.bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        let view =
            self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": length }));
        let count = values.len() / width;
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind }),
        )
    }

    /// Joints of vertices, four each, as bytes.
    fn joints(&mut self, joints: &[[u8; 4]]) -> usize {
        let (offset, length) = (self.bytes.len(), 4 * joints.len());
        self.bytes.extend(joints.as_flattened());
        let view =
            self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": length }));
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": 5121, "count": joints.len(), "type": "VEC4" }),
        )
    }

    pub(super) fn mesh(&mut self, positions: &[f32], material: usize) -> usize {
        let positions = self.accessor("VEC3", 3, positions);
        let primitive = json!({ "attributes": { "POSITION": positions }, "material": material });
        self.push("meshes", json!({ "primitives": [primitive] }))
    }

    pub(super) fn root(&mut self, node: Value) -> usize {
        let node = self.push("nodes", node);
        self.document["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(node));
        node
    }

    fn channel(&mut self, node: usize, path: &str, how: &str, times: &[f32], values: &[f32]) {
        let input = self.accessor("SCALAR", 1, times);
        let (kind, width) = match path {
            "rotation" => ("VEC4", 4),
            "weights" => ("SCALAR", 1),
            _ => ("VEC3", 3),
        };
        let output = self.accessor(kind, width, values);
        let animation = &mut self.document["animations"][0];
        let samplers = animation["samplers"].as_array_mut().unwrap();
        samplers.push(json!({ "input": input, "output": output, "interpolation": how }));
        let sampler = samplers.len() - 1;
        let channel = json!({ "sampler": sampler, "target": { "node": node, "path": path } });
        animation["channels"].as_array_mut().unwrap().push(channel);
    }

    fn load(mut self) -> Result<Scene, SceneError> {
        self.write_and_load(&LoadOptions::default())
    }

    pub(super) fn write_and_load(&mut self, options: &LoadOptions) -> Result<Scene, SceneError> {
        let folder = tempfile::tempdir().unwrap();
        self.document["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": "scene.bin" }]);
        std::fs::write(folder.path().join("scene.bin"), &self.bytes).unwrap();
        let path = folder.path().join("moving.gltf");
        std::fs::write(&path, serde_json::to_vec(&self.document).unwrap()).unwrap();
        Scene::load_with(&path, options)
    }
}

/// A square of this half width in the plane z = 0 that faces +z.
pub(super) fn square(half: f32) -> Vec<f32> {
    let (a, b) = (-half, half);
    [[a, a], [b, a], [b, b], [a, a], [b, b], [a, b]].iter().flat_map(|[x, y]| [*x, *y, 0.0]).collect()
}

/// Random triangles in a cube of half width 1.
fn soup(seed: u32, count: u32) -> Vec<f32> {
    let corner = |index| {
        let u = Rng::new(Stream::Light, seed, index, 0).next4();
        [2.0 * u.x - 1.0, 2.0 * u.y - 1.0, 2.0 * u.z - 1.0]
    };
    (0..3 * count).flat_map(corner).collect()
}

/// A floor, a camera, and soups that turn, stretch and are mirrored, each in its own way.
fn soups() -> File {
    let mut file = File::new();
    let floor = file.mesh(&square(6.0), 0);
    file.root(json!({ "mesh": floor, "translation": [0, 0, -3] }));
    file.root(json!({ "camera": 0, "translation": [0, 0, 9] }));
    let light = file
        .root(json!({ "translation": [0, 0, 8], "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
    file.channel(light, "translation", "LINEAR", &[0.0, 2.0], &[0.0, 0.0, 8.0, 4.0, 2.0, 8.0]);
    for id in 0..6u32 {
        let mesh = file.mesh(&soup(id, 60), 0);
        let node = file.root(json!({ "name": format!("soup {id}"), "mesh": mesh }));
        let (x, y) = ((id % 3) as f32 * 2.0 - 2.0, (id / 3) as f32 * 2.0 - 1.0);
        file.channel(node, "translation", "LINEAR", &[0.0, 2.0], &[x, y, 0.0, x + 1.0, y, 1.5]);
        let turn = if id % 2 == 0 { [0.6, 0.0, 0.8, 0.0] } else { [0.0, 0.8, 0.0, 0.6] };
        let rotations = [[0.0, 0.0, 0.0, 1.0], turn].concat();
        file.channel(node, "rotation", "LINEAR", &[0.0, 2.0], &rotations);
        // The third and the sixth turn inside out during the animation.
        let end = if id % 3 == 2 { [-1.0, 0.5, 2.0] } else { [0.3, 1.5, 1.0] };
        file.channel(node, "scale", "LINEAR", &[0.0, 2.0], &[[1.0, 1.0, 1.0], end].concat());
    }
    file
}

/// A tube from the origin along y, 2 m long, with its normals: corners of triangles.
fn tube() -> Vec<([f32; 3], [f32; 3])> {
    let at = |turn: u32, step: u32| {
        let (sine, cosine) = (std::f32::consts::TAU * (turn % 12) as f32 / 12.0).sin_cos();
        ([0.4 * cosine, step as f32 / 5.0, 0.4 * sine], [cosine, 0.0, sine])
    };
    let quad = |(turn, step): (u32, u32)| {
        let [a, b] = [at(turn, step), at(turn + 1, step)];
        let [c, d] = [at(turn + 1, step + 1), at(turn, step + 1)];
        [a, c, b, a, d, c]
    };
    (0..12).flat_map(|turn| (0..10).map(move |step| (turn, step))).flat_map(quad).collect()
}

/// Weight of the upper joint at a vertex of the tube.
fn upper(position: [f32; 3]) -> f32 {
    ((position[1] - 0.5) / 1.0).clamp(0.0, 1.0)
}

/// Number of morph targets of the soup: more than the four that a channel holds.
const TARGETS: usize = 5;

/// Displacement of a corner of the soup by a target.
fn displacement(target: usize, corner: usize) -> [f32; 3] {
    let u = Rng::new(Stream::Light, 90 + target as u32, corner as u32, 0).next4();
    [u.x - 0.5, u.y - 0.5, u.z - 0.5]
}

/// A floor, a camera and a light; a tube; and a soup that moves while five morph targets come and go. The tube's upper
/// half turns a quarter about z in 2 s, on a node whose transform does not count.
pub(super) fn deforming() -> File {
    let mut file = File::new();
    let floor = file.mesh(&square(6.0), 0);
    file.root(json!({ "mesh": floor, "translation": [0, 0, -3] }));
    file.root(json!({ "camera": 0, "translation": [0, 0, 9] }));
    file.root(json!({ "translation": [0, 0, 8], "extensions": { "KHR_lights_punctual": { "light": 0 } } }));

    let tube = tube();
    let positions: Vec<f32> = tube.iter().flat_map(|(position, _)| *position).collect();
    let normals: Vec<f32> = tube.iter().flat_map(|(_, normal)| *normal).collect();
    let weights: Vec<f32> =
        tube.iter().flat_map(|(at, _)| [1.0 - upper(*at), upper(*at), 0.0, 0.0]).collect();
    // The lower joint stands still at (1, 0, 0), the upper one below it 1 m higher; both are bound there.
    let elbow = file.push("nodes", json!({ "translation": [0, 1, 0] }));
    let shoulder = file.root(json!({ "translation": [1, 0, 0], "children": [elbow] }));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    file.channel(elbow, "rotation", "LINEAR", &[0.0, 2.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]);
    let bound = |y: f32| {
        let mut matrix = [0.0; 16];
        (matrix[0], matrix[5], matrix[10], matrix[15], matrix[13]) = (1.0, 1.0, 1.0, 1.0, -y);
        matrix
    };
    let matrices = file.accessor("MAT4", 16, &[bound(0.0), bound(1.0)].concat());
    let attributes = json!({
        "POSITION": file.accessor("VEC3", 3, &positions),
        "NORMAL": file.accessor("VEC3", 3, &normals),
        "JOINTS_0": file.joints(&vec![[0, 1, 7, 7]; tube.len()]),
        "WEIGHTS_0": file.accessor("VEC4", 4, &weights),
    });
    let mesh = file.push("meshes", json!({ "primitives": [{ "attributes": attributes, "material": 0 }] }));
    file.document["skins"] = json!([{ "joints": [shoulder, elbow], "inverseBindMatrices": matrices }]);
    file.root(json!({ "name": "tube", "mesh": mesh, "skin": 0, "translation": [50, 0, 0] }));

    let corners = soup(3, 40);
    let rest = file.accessor("VEC3", 3, &corners);
    let targets: Vec<_> = (0..TARGETS)
        .map(|target| {
            let all: Vec<f32> =
                (0..corners.len() / 3).flat_map(|corner| displacement(target, corner)).collect();
            json!({ "POSITION": file.accessor("VEC3", 3, &all) })
        })
        .collect();
    let primitive = json!({ "attributes": { "POSITION": rest }, "targets": targets, "material": 0 });
    let mesh = file.push("meshes", json!({ "primitives": [primitive] }));
    let node = file.root(json!({ "name": "soup", "mesh": mesh }));
    file.channel(node, "translation", "LINEAR", &[0.0, 2.0], &[-2.0, 0.0, 0.0, -2.0, 0.5, 1.0]);
    let weights: Vec<f32> = (0..2 * TARGETS).map(|at| at as f32 / 4.0).collect();
    file.channel(node, "weights", "LINEAR", &[0.0, 2.0], &weights);
    file
}

/// Every triangle at its pose, with its instance and its id.
pub(super) fn triangles(scene: &Scene) -> Vec<(u32, u32, Triangle)> {
    let of_instance = |instance: usize| {
        let triangle_ids = scene.instanced.triangle_ids(instance);
        let (instance, ids) = (instance as u32, triangle_ids.map(|id| id as u32));
        ids.map(move |id| (instance, id, scene.world_triangle(instance, id)))
    };
    (0..scene.instances.len()).flat_map(of_instance).collect()
}

/// Rays from random positions in the scene's bounds to near the moving meshes.
pub(super) fn aimed(scene: &Scene, count: usize) -> Vec<Ray> {
    let moving: Vec<_> =
        triangles(scene).into_iter().filter(|(instance, ..)| *instance != 0).map(|(.., t)| t).collect();
    let aim = |(index, ray): (usize, Ray)| {
        let u = Rng::new(Stream::Camera, 31, index as u32, 0).next4();
        let triangle = moving[(u.x * moving.len() as f32) as usize];
        let target = (triangle.a + triangle.b + triangle.c) / 3.0 + 0.3 * uniform_sphere(u.y, u.z);
        Ray::endless(ray.origin, (target - ray.origin).normalize())
    };
    rays::through(scene, count).into_iter().enumerate().map(aim).collect()
}

/// Distance and weights of b and c by Moeller and Trumbore, in double precision.
fn meet(ray: &Ray, triangle: &Triangle) -> Option<(f64, f64, f64)> {
    let (o, d): (DVec3, DVec3) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(|p| p.as_dvec3());
    let p = d.cross(c - a);
    let determinant = (b - a).dot(p);
    let s = o - a;
    let u = s.dot(p) / determinant;
    let q = s.cross(b - a);
    let (v, t) = (d.dot(q) / determinant, (c - a).dot(q) / determinant);
    (determinant != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some((t, u, v))
}

#[test]
fn hits_on_instances_match_a_search_of_all_triangles() {
    for (file, times) in [soups(), deforming()].into_iter().zip([[0.0, 0.7, 1.9, 1.2], [0.0, 1.9, 0.7, 1.2]])
    {
        let mut scene = file.load().unwrap();
        assert_eq!(scene.warnings, [""; 0]);
        are_hit_where_their_triangles_are(&mut scene, times);
    }
}

fn are_hit_where_their_triangles_are(scene: &mut Scene, times: [f64; 4]) {
    let features = scene.features(0.25);
    assert!(features.has(Features::INSTANCES) && scene.is_animated());
    for time in times {
        scene.pose(time).unwrap();
        let scene = &*scene;
        let mut tracer = scene.tracer(features);
        let (mut hits, mut others) = (0, 0);
        let all = triangles(scene);
        for ray in aimed(scene, 4000) {
            let hit = tracer.closest(&ray);
            let oracle = all.iter().filter_map(|at| Some((meet(&ray, &at.2)?, at)));
            let Some(((t, u, v), &(instance, id, _))) = oracle.min_by(|a, b| a.0.0.total_cmp(&b.0.0)) else {
                others += u32::from(!hit.is_miss());
                continue;
            };
            // A few ulp of coordinates up to 10 m, over a grazing cosine of a percent.
            let same = (hit.instance, hit.triangle) == (instance, id)
                && (f64::from(hit.distance) - t).abs() <= 1e-4 * t.max(1.0);
            others += u32::from(!same);
            if same {
                // A mirrored instance has its front on the other side: b and c are swapped.
                let (u, v) =
                    if scene.instances[instance as usize].orientation < 0.0 { (v, u) } else { (u, v) };
                hits += u32::from(instance != 0);
                // Slivers amplify an ulp: these soups have triangles a hundred times as long as wide.
                let off = (f64::from(hit.u) - u).abs().max((f64::from(hit.v) - v).abs());
                assert!(off < 1e-2, "{hit:?} should be at {u} {v}");
                assert!(tracer.occluded(&Ray { length: hit.distance * 1.001, ..ray }));
                assert!(!tracer.occluded(&Ray { length: hit.distance * 0.999, ..ray }));
            }
        }
        assert!(hits > 1000, "only {hits} rays met a mesh that moves");
        assert!(others <= 8, "at {time} s {others} of 4000 rays met something else");
    }
}

#[test]
fn pose_does_not_depend_on_earlier_poses() {
    for file in [soups, deforming] {
        poses_are_their_own(file);
    }
}

fn poses_are_their_own(file: fn() -> File) {
    let (mut there, mut back) = (file().load().unwrap(), file().load().unwrap());
    there.pose(1.3).unwrap();
    for time in [2.0, 0.1, 1.9, 1.3] {
        back.pose(time).unwrap();
    }
    assert_eq!(there.triangles, back.triangles);
    assert_eq!(there.surfaces, back.surfaces);
    assert_eq!((&there.nodes, &there.blocks), (&back.nodes, &back.blocks));
    assert_eq!((&there.lights, there.flux), (&back.lights, back.flux));
    assert_eq!(there.cameras, back.cameras);
    let to_world = |scene: &Scene| {
        scene
            .instances
            .iter()
            .map(|instance| (instance.to_object, instance.to_world, instance.orientation))
            .collect::<Vec<_>>()
    };
    assert_eq!(to_world(&there), to_world(&back));
    assert_ne!(to_world(&there), to_world(&file().load().unwrap()));
    assert_ne!(there.fingerprint(), file().load().unwrap().fingerprint());
}

#[test]
fn previous_positions_are_those_of_the_last_pose() {
    let mut scene = soups().load().unwrap();
    let identity = caustics_kernels::interface::instance::Transform::IDENTITY;
    assert!(scene.instances.iter().all(|instance| instance.to_previous == identity));
    scene.pose(0.4).unwrap();
    let before = triangles(&scene);
    scene.pose(0.8).unwrap();
    let mut moved = 0;
    for ((instance, _, triangle), (.., old)) in triangles(&scene).iter().zip(&before) {
        let back = scene.instances[*instance as usize].to_previous.point(triangle.a);
        // f32 of a dozen operations on coordinates up to 10 m.
        assert!((back - old.a).length() <= 1e-6 * 10.0, "{back} should be {}", old.a);
        moved += u32::from((triangle.a - old.a).length() > 0.05);
    }
    assert!(moved > 200);
}

/// Compares the tube with linear blend skinning, and the soup with the formula of morph targets.
#[test]
fn skins_and_morph_targets_deform_by_their_formulas() {
    let mut scene = deforming().load().unwrap();
    assert_eq!(scene.instanced.instances.len(), 2);
    for time in [0.0_f64, 0.5, 2.0, 1.3] {
        scene.pose(time).unwrap();
        let all = triangles(&scene);
        let near = |instance: u32, expected: [DVec3; 3]| {
            let expected = expected.map(|p| p - scene.origin);
            let middle = (expected[0] + expected[1] + expected[2]) / 3.0;
            let off = |t: &Triangle| ((t.a + t.b + t.c).as_dvec3() / 3.0 - middle).length();
            let found = all.iter().filter(|(at, ..)| *at == instance);
            let (_, id, t) = found.min_by(|a, b| off(&a.2).total_cmp(&off(&b.2))).unwrap();
            let corners = [t.a, t.b, t.c].map(|p| p.as_dvec3());
            for p in expected {
                let off = corners.iter().map(|corner| corner.distance(p)).fold(f64::MAX, f64::min);
                assert!(off < 2e-6, "at {time} s {p} is {off} m away");
            }
            *id
        };
        let angle = PI / 2.0 * time / 2.0;
        let turn = DQuat::from_rotation_z(angle);
        let skinned = |at: [f32; 3]| {
            let (p, upper) = (DVec3::from(at.map(f64::from)), f64::from(upper(at)));
            let pulled = DVec3::Y + turn * (p - DVec3::Y);
            DVec3::X + p * (1.0 - upper) + pulled * upper
        };
        for corners in tube().as_chunks::<3>().0 {
            let id = near(1, corners.map(|(at, _)| skinned(at)));
            // Where one joint alone acts, normals turn with it.
            if corners.iter().all(|(at, _)| upper(*at) == 1.0) {
                let normals = scene.surfaces[id as usize];
                let expected = corners.map(|(_, normal)| turn * DVec3::from(normal.map(f64::from)));
                for normal in [normals.normal_a, normals.normal_b, normals.normal_c] {
                    let off = expected.iter().map(|n| n.distance(normal.as_dvec3())).fold(f64::MAX, f64::min);
                    assert!(off < 1e-6, "{normal}");
                }
            }
        }
        let share = time / 2.0;
        let rest_position = DVec3::new(-2.0, 0.5 * share, share);
        let morphed = |corner: usize, at: &[f32; 3]| {
            let delta = |target: usize| {
                let weight = (target as f64 + share * TARGETS as f64) / 4.0;
                weight * DVec3::from(displacement(target, corner).map(f64::from))
            };
            rest_position + DVec3::from(at.map(f64::from)) + (0..TARGETS).map(delta).sum::<DVec3>()
        };
        let corners = soup(3, 40);
        let corners: Vec<_> =
            corners.as_chunks::<3>().0.iter().enumerate().map(|(id, at)| morphed(id, at)).collect();
        for corners in corners.as_chunks::<3>().0 {
            near(2, *corners);
        }
    }
}

/// A skin without animation is baked: its triangles are those of an animation that reaches its pose.
#[test]
fn skin_without_animation_is_baked() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let mut file = deforming();
    file.document["animations"] = json!([]);
    file.document["nodes"][3]["rotation"] = json!([0.0, 0.0, half, half]);
    let still = file.load().unwrap();
    assert!(!still.is_animated() && still.instanced.instances.is_empty());
    let mut moving = deforming().load().unwrap();
    moving.pose(2.0).unwrap();
    let middle = |scene: &Scene, t: &Triangle| (t.a + t.b + t.c).as_dvec3() / 3.0 + scene.origin;
    let baked: Vec<DVec3> = triangles(&still).iter().map(|(.., t)| middle(&still, t)).collect();
    let tube = triangles(&moving).into_iter().filter(|(instance, ..)| *instance == 1);
    let off = tube.map(|(.., t)| {
        let there = middle(&moving, &t);
        baked.iter().map(|p| p.distance(there)).fold(f64::MAX, f64::min)
    });
    let off: Vec<f64> = off.collect();
    assert!(off.len() == 240 && off.iter().all(|&off| off < 2e-6), "{off:?}");
    // An unusable skin is named.
    let mut broken = deforming();
    broken.document["skins"][0]["joints"] = json!([0, 99]);
    let scene = broken.load().unwrap();
    assert!(
        scene.warnings.iter().any(|warning| warning.contains("no node of the scene")),
        "{:?}",
        scene.warnings
    );
}

#[test]
fn posed_scene_matches_a_static_scene_of_that_pose() {
    // At 1 s, where every value is exact in f32: a camera, a spot and a mesh below a parent.
    let build = |animated: bool| {
        let mut file = File::new();
        let floor = file.mesh(&square(4.0), 0);
        file.root(json!({ "mesh": floor, "translation": [0, 0, -2] }));
        let mesh = file.mesh(&square(0.5), 0);
        let child = file.push("nodes", json!({ "mesh": mesh, "translation": [0.5, 0, 0.25] }));
        let turn = [0.0, 0.6, 0.0, 0.8];
        let spot = json!({ "KHR_lights_punctual": { "light": 1 } });
        let translations = [
            (json!({ "camera": 0 }), [0.5, 0.25, 6.0]),
            (json!({ "extensions": spot }), [1.0, 0.5, 5.0]),
            (json!({ "children": [child], "scale": [1.0, 2.0, -1.5] }), [0.25, -0.5, 1.0]),
        ];
        for (mut node, translation) in translations {
            if animated {
                let node = file.root(node);
                let ahead = translation.map(|x: f32| x + 1.0);
                let behind = translation.map(|x: f32| x - 1.0);
                file.channel(node, "translation", "LINEAR", &[0.0, 2.0], &[behind, ahead].concat());
                let other = [0.8, 0.0, 0.6, 0.0];
                file.channel(node, "rotation", "LINEAR", &[0.0, 1.0, 2.0], &[other, turn, other].concat());
            } else {
                (node["translation"], node["rotation"]) = (json!(translation), json!(turn));
                file.root(node);
            }
        }
        file.load().unwrap()
    };
    let (mut moving, still) = (build(true), build(false));
    moving.pose(1.0).unwrap();
    let shift = (still.origin - moving.origin).as_vec3();
    // Both are recentred, each on its own bounds.
    let (a, b) = (&moving.cameras[0], &still.cameras[0]);
    assert_eq!((a.right, a.up, a.forward, a.fov_y), (b.right, b.up, b.forward, b.fov_y));
    assert!((a.position - b.position - shift).length() < 1e-6);
    assert_eq!(moving.lights[0].direction, still.lights[0].direction);
    assert_eq!((moving.lights.len(), moving.flux), (1, still.flux));
    assert!((moving.lights[0].position - still.lights[0].position - shift).length() < 1e-6);
    let (features, still_needs) = (moving.features(0.25), still.features(0.25));
    let (mut tracer_a, mut tracer_b) = (moving.tracer(features), still.tracer(still_needs));
    let (mut met, mut others) = (0, 0);
    for ray in aimed(&moving, 4000) {
        let (a, b) = (tracer_a.closest(&ray), tracer_b.closest(&Ray { origin: ray.origin - shift, ..ray }));
        // 1e-5 of a scene of 10 m.
        let same = a.is_miss() == b.is_miss() && (a.is_miss() || (a.distance - b.distance).abs() < 1e-4);
        others += u32::from(!same);
        met += u32::from(!a.is_miss() && a.instance != 0);
        if same && !a.is_miss() {
            let normal = |scene: &Scene, hit: &Hit| {
                let t = scene.world_triangle(hit.instance, hit.triangle);
                (t.b - t.a).cross(t.c - t.a).normalize()
            };
            assert!((normal(&moving, &a) - normal(&still, &b)).length() < 1e-4, "fronts agree");
        }
    }
    assert!(met > 50 && others <= 2, "{met} met the mesh, {others} of 4000 differ");
}

/// A light over a floor with a mirror; the light grows from nothing to twice its size.
fn light() -> File {
    let mut file = File::new();
    let floor = file.mesh(&square(2.0), 0);
    file.root(json!({ "mesh": floor }));
    let mirror = file.mesh(&square(1.0), 2);
    file.root(json!({ "mesh": mirror, "translation": [0, 1.5, 1], "rotation": [0.6, 0, 0, 0.8] }));
    file.root(json!({ "camera": 0, "translation": [0, -1, 5] }));
    let light = file.mesh(&square(0.5), 1);
    let node = file.root(json!({ "mesh": light, "translation": [0, 0, 3], "rotation": [1, 0, 0, 0] }));
    file.channel(node, "scale", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 2.0, 2.0, 2.0]);
    file
}

#[test]
fn flux_of_a_growing_light_follows_its_area_from_zero() {
    let mut scene = light().load().unwrap();
    assert_eq!((scene.lights.len(), scene.flux), (0, Vec3::ZERO));
    assert!(scene.features(0.25).has(Features::AREA_LIGHTS));
    for time in [0.25, 0.5, 1.0, 3.0] {
        scene.pose(time).unwrap();
        // Radiance 1 over pi sr and the area of a square of side 2 t.
        let expected = PI * (2.0 * time.min(1.0)).powi(2);
        assert!((f64::from(scene.flux.x) / expected - 1.0).abs() < 1e-6, "at {time} s: {}", scene.flux.x);
        for (id, light) in scene.lights.iter().enumerate() {
            assert_eq!(scene.surfaces[light.triangle as usize].light, id as u32);
        }
    }
    let ids = |scene: &Scene| scene.surfaces.iter().filter(|surface| surface.light != NONE).count();
    assert_eq!((scene.lights.len(), ids(&scene)), (2, 2));
    scene.pose(0.0).unwrap();
    assert_eq!((scene.lights.len(), ids(&scene)), (0, 0));
    let instances = scene.instances.iter();
    assert!(
        instances
            .flat_map(|instance| [instance.to_previous.x, instance.to_previous.offset])
            .all(Vec3::is_finite)
    );
    // A light that appears again was nowhere before.
    scene.pose(0.5).unwrap();
    assert_eq!(scene.instances.iter().filter(|instance| instance.to_previous.is_nowhere()).count(), 1);
    scene.pose(0.0).unwrap();
    let mut tracer = scene.tracer(scene.features(0.25));
    let through = Ray::endless(Vec3::new(0.0, 0.0, 9.0), Vec3::NEG_Z);
    let hit = tracer.closest(&through);
    assert_eq!(hit.instance, 0, "the light has no area");
}

#[test]
fn frames_are_black_exactly_while_the_light_has_no_area() {
    let mut scene = light().load().unwrap();
    let config =
        RenderConfig { width: 48, height: 32, light_paths: Paths::Count(20_000), ..RenderConfig::default() };
    let camera = |scene: &Scene| scene.cameras[0].clone();
    let open = |scene: &Scene| {
        let features = scene.features(config.specular_roughness);
        let choice = RunnerChoice::Cpu { threads: 0 };
        Session::new(&choice, scene, &camera(scene), &config, features).unwrap()
    };
    let mut session = open(&scene);
    for (time, is_lit) in [(0.0, false), (0.8, true), (0.0, false), (0.4, true)] {
        scene.pose(time).unwrap();
        session.pose(&scene, &camera(&scene)).unwrap();
        session.frame(0).unwrap();
        let image = session.image().unwrap();
        let sum = |pixels: &[Vec3]| pixels.iter().map(|p| f64::from(p.element_sum())).sum::<f64>();
        assert_eq!((sum(&image.path) > 0.0, sum(&image.caustics) > 0.0), (is_lit, is_lit), "at {time} s");
        // The uploaded tables equal those of a session opened at this time.
        let mut fresh = open(&scene);
        fresh.frame(0).unwrap();
        let fresh = fresh.image().unwrap();
        assert_eq!((fresh.path, fresh.caustics), (image.path, image.caustics), "at {time} s");
    }
}

/// Three lamps of two triangles; one moves, and one grows from nothing. The light BVH follows them.
#[test]
fn the_light_bvh_follows_moving_lights() {
    let mut file = light();
    let lamp = file.mesh(&square(0.3), 1);
    file.root(json!({ "mesh": lamp, "translation": [-1.5, 1, 2.5], "rotation": [1, 0, 0, 0] }));
    let moving = file.root(json!({ "mesh": lamp, "translation": [1, 1, 1], "rotation": [1, 0, 0, 0] }));
    file.channel(moving, "translation", "LINEAR", &[0.0, 1.0], &[1.0, 1.0, 1.0, -1.0, -1.0, 1.5]);
    let mut scene = file.load().unwrap();
    let config = RenderConfig {
        width: 48,
        height: 32,
        method: &PATH,
        light_sampler: LightSampler::Bvh,
        ..RenderConfig::default()
    };
    let open = |scene: &Scene| {
        let features = scene.features(config.specular_roughness);
        let choice = RunnerChoice::Cpu { threads: 0 };
        Session::new(&choice, scene, &scene.cameras[0], &config, features).unwrap()
    };
    let mut session = open(&scene);
    let (mut nodes, mut resampled) = (vec![], 0);
    for time in [0.0, 0.8, 1.0, 0.4] {
        scene.pose(time).unwrap();
        // Four lights are all sampled.
        assert_eq!(scene.light_bvh.is_empty(), time == 0.0);
        assert!(scene.light_bvh.is_empty() || nodes != scene.light_bvh, "{time} s");
        nodes.clone_from(&scene.light_bvh);
        session.pose(&scene, &scene.cameras[0]).unwrap();
        session.frame(0).unwrap();
        let image = session.image().unwrap();
        // The uploaded tables equal those of a session opened at this time.
        let mut fresh = open(&scene);
        fresh.frame(0).unwrap();
        assert_eq!(fresh.image().unwrap().path, image.path, "at {time} s");
        let config = RenderConfig { light_sampler: LightSampler::Resampled, ..config.clone() };
        let choice = RunnerChoice::Cpu { threads: 0 };
        let mut other =
            Session::new(&choice, &scene, &scene.cameras[0], &config, scene.features(0.25)).unwrap();
        other.frame(0).unwrap();
        resampled += u32::from(other.image().unwrap().path == image.path);
    }
    assert_eq!(resampled, 1, "the light BVH samples more than four lights");
}

#[test]
fn runners_agree_after_every_pose() {
    let Some(gpu) = gpu() else { return };
    let config =
        RenderConfig { width: 32, height: 32, light_paths: Paths::Count(1024), ..RenderConfig::default() };
    for (&hardware, file) in gpu.tracers().iter().flat_map(|at| [(at, soups()), (at, deforming())]) {
        let mut scene = file.load().unwrap();
        let mut runners = RunnerPair::open(&gpu, hardware, &scene, &config);
        let (mut cpu, mut device) = (Upload::new(&scene), Upload::new(&scene));
        for time in [0.0, 1.9, 0.6] {
            scene.pose(time).unwrap();
            cpu.run(&mut *runners.cpu, &scene).unwrap();
            device.run(&mut *runners.gpu, &scene).unwrap();
            let rays = aimed(&scene, 20_000);
            runners.write("rays", &rays);
            runners.step(&STEP_HIT, rays.len());
            let (cpu, gpu) = runners.head::<Hit>("hits", rays.len());
            let same = |a: &Hit, b: &Hit| {
                (a.instance, a.triangle) == (b.instance, b.triangle)
                    && (a.is_miss()
                        || ((a.distance - b.distance).abs() <= 1e-4 * a.distance.max(1.0)
                            && (a.u - b.u).abs().max((a.v - b.v).abs()) < 1e-2))
            };
            let others = cpu.iter().zip(&gpu).filter(|(a, b)| !same(a, b)).count();
            let moving = cpu.iter().filter(|hit| hit.instance != 0).count();
            assert!(moving > 4000, "{moving}");
            // The parity rule: 0.2 % on edges and slivers.
            assert!(others <= 40, "hardware {hardware}, {time} s: {others} of 20000 differ");
        }
    }
}

#[test]
fn damaged_animations_are_named_and_left_out() {
    type Damage = fn(&mut File);
    let strict = LoadOptions { strict: true, ..LoadOptions::default() };
    let cases: [(&str, Damage); 8] = [
        ("ascend", |f| f.channel(3, "translation", "LINEAR", &[0.0, 1.0, 1.0], &[0.0; 9])),
        ("needed", |f| f.channel(3, "translation", "LINEAR", &[0.0, 1.0], &[0.0; 9])),
        ("needed", |f| f.channel(3, "translation", "CUBICSPLINE", &[0.0, 1.0], &[0.0; 6])),
        ("not finite", |f| f.channel(3, "translation", "STEP", &[0.0], &[f32::NAN, 0.0, 0.0])),
        ("not a number", |f| f.channel(3, "translation", "STEP", &[f32::NAN], &[0.0; 3])),
        ("no length", |f| f.channel(3, "rotation", "LINEAR", &[0.0], &[0.0; 4])),
        ("node 77", |f| f.channel(77, "rotation", "LINEAR", &[0.0], &[1.0; 4])),
        ("interpolation", |f| f.channel(3, "scale", "WILD", &[0.0], &[1.0; 3])),
    ];
    for (word, damage) in cases {
        let mut file = light();
        damage(&mut file);
        let scene = file.write_and_load(&LoadOptions::default()).expect(word);
        let is_named = |warning: &String| warning.contains(word) && warning.contains("left out");
        assert!(scene.warnings.iter().any(is_named), "{word}: {:?}", scene.warnings);
        let error = file.write_and_load(&strict).expect_err(word).to_string();
        for word in [word, "moving.gltf", "animation"] {
            assert!(error.contains(word), "{error} does not say {word}");
        }
    }
    // Missing accessors and samplers.
    for pointer in [
        "/animations/0/samplers/0/input",
        "/animations/0/samplers/0/output",
        "/animations/0/channels/0/sampler",
    ] {
        let mut file = light();
        *file.document.pointer_mut(pointer).unwrap() = json!(999);
        let error = file.write_and_load(&strict).expect_err(pointer).to_string();
        assert!(error.contains("moving.gltf"), "{error}");
    }
    // A camera that is singular at some time is an error at that time, and the scene stays as it was.
    let mut file = light();
    file.channel(2, "scale", "STEP", &[0.0, 1.0], &[1.0, 1.0, 1.0, 0.0, 1.0, 1.0]);
    let mut scene = file.load().unwrap();
    let camera = scene.cameras[0].clone();
    assert!(scene.pose(1.0).unwrap_err().to_string().contains("singular"));
    assert_eq!(scene.cameras[0], camera);
}

#[test]
fn buffers_have_room_for_lights_that_appear_later() {
    let scene = light().load().unwrap();
    let tables = scene.buffers();
    let length = |name: &str| tables.iter().find(|(table, _)| *table == name).unwrap().1.len();
    // A floor, a mirror and a light of two triangles each.
    assert_eq!((length("lights"), length("triangles")), (0, 6 * size_of::<Triangle>()));
    let config = RenderConfig::default();
    assert_eq!(config.params(&scene, &scene.cameras[0], 0).light_path_count, 0);
    assert_eq!(config.largest(&scene, &scene.cameras[0]).light_path_count, config.max_light_paths());
}
