//! Animated scenes: poses against static files and formulas, instances against every triangle, lights that go out.

use std::f64::consts::PI;

use caustics::scene::{LoadOptions, Scene, SceneError};
use caustics::session::{RunnerChoice, Session};
use caustics::settings::Settings;
use caustics::upload::Upload;
use caustics_kernels::gather::variant::PHOTONS_GRID;
use caustics_kernels::interface::NONE;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::ray::{Hit, Ray};
use caustics_kernels::interface::triangle::Triangle;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::math::warp::uniform_sphere;
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::pass::step::STEP_HIT;
use caustics_kernels::trace::Tracer;
use caustics_tests::gpu::gpu;
use caustics_tests::rays;
use caustics_tests::twin::Twin;
use glam::{DVec3, Vec3};
use serde_json::{Value, json};

/// A glTF file in the making.
struct File {
    document: Value,
    bytes: Vec<u8>,
}

impl File {
    fn new() -> File {
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

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.document[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    fn accessor(&mut self, kind: &str, width: usize, values: &[f32]) -> usize {
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

    fn mesh(&mut self, positions: &[f32], material: usize) -> usize {
        let positions = self.accessor("VEC3", 3, positions);
        let primitive = json!({ "attributes": { "POSITION": positions }, "material": material });
        self.push("meshes", json!({ "primitives": [primitive] }))
    }

    fn root(&mut self, node: Value) -> usize {
        let node = self.push("nodes", node);
        self.document["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(node));
        node
    }

    fn channel(&mut self, node: usize, path: &str, how: &str, times: &[f32], values: &[f32]) {
        let input = self.accessor("SCALAR", 1, times);
        let (kind, width) = if path == "rotation" { ("VEC4", 4) } else { ("VEC3", 3) };
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

    fn write_and_load(&mut self, options: &LoadOptions) -> Result<Scene, SceneError> {
        let folder = tempfile::tempdir().unwrap();
        self.document["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": "scene.bin" }]);
        std::fs::write(folder.path().join("scene.bin"), &self.bytes).unwrap();
        let path = folder.path().join("moving.gltf");
        std::fs::write(&path, serde_json::to_vec(&self.document).unwrap()).unwrap();
        Scene::load_with(&path, options)
    }
}

/// A square of this half width in the plane z = 0 that faces +z.
fn square(half: f32) -> Vec<f32> {
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
        // The third and the sixth turn inside out on the way.
        let end = if id % 3 == 2 { [-1.0, 0.5, 2.0] } else { [0.3, 1.5, 1.0] };
        file.channel(node, "scale", "LINEAR", &[0.0, 2.0], &[[1.0, 1.0, 1.0], end].concat());
    }
    file
}

/// Rays from anywhere in the scene's bounds to near the meshes that move.
fn aimed(scene: &Scene, count: usize) -> Vec<Ray> {
    let moving: Vec<_> = scene
        .triangles
        .iter()
        .zip(&scene.surfaces)
        .filter(|(_, s)| s.instance != 0)
        .map(|(t, _)| t)
        .collect();
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
fn instances_are_hit_where_their_triangles_are() {
    let mut scene = soups().load().unwrap();
    let features = scene.features(0.25);
    assert!(features.has(Features::INSTANCES) && scene.is_animated());
    for time in [0.0, 0.7, 1.9, 1.2] {
        scene.pose(time).unwrap();
        let mut tracer = scene.tracer(features);
        let (mut hits, mut others) = (0, 0);
        for ray in aimed(&scene, 4000) {
            let hit = tracer.closest(&ray);
            let all = scene.triangles.iter().enumerate();
            let oracle = all.filter_map(|(id, triangle)| Some((meet(&ray, triangle)?, id as u32)));
            let Some(((t, u, v), id)) = oracle.min_by(|a, b| a.0.0.total_cmp(&b.0.0)) else {
                others += u32::from(!hit.is_miss());
                continue;
            };
            // A few ulp of coordinates up to 10 m, over a grazing cosine of a percent.
            let same = hit.triangle == id && (f64::from(hit.distance) - t).abs() <= 1e-4 * t.max(1.0);
            others += u32::from(!same);
            if same {
                hits += u32::from(scene.surfaces[id as usize].instance != 0);
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
fn poses_do_not_depend_on_those_before() {
    let (mut there, mut back) = (soups().load().unwrap(), soups().load().unwrap());
    there.pose(1.3).unwrap();
    for time in [2.0, 0.1, 1.9, 1.3] {
        back.pose(time).unwrap();
    }
    assert_eq!(there.triangles, back.triangles);
    assert_eq!(there.surfaces, back.surfaces);
    assert_eq!((&there.nodes, &there.blocks), (&back.nodes, &back.blocks));
    assert_eq!((&there.lights, there.flux), (&back.lights, back.flux));
    assert_eq!((&there.cameras, &there.object_triangles), (&back.cameras, &back.object_triangles));
    let to_object = |scene: &Scene| scene.instances.iter().map(|row| row.to_object).collect::<Vec<_>>();
    assert_eq!(to_object(&there), to_object(&back));
    assert_ne!(there.triangles, soups().load().unwrap().triangles);
    assert_ne!(there.fingerprint(), soups().load().unwrap().fingerprint());
}

#[test]
fn previous_places_are_where_vertices_were() {
    let mut scene = soups().load().unwrap();
    let identity = caustics_kernels::interface::instance::Transform::IDENTITY;
    assert!(scene.instances.iter().all(|row| row.to_previous == identity));
    scene.pose(0.4).unwrap();
    let before = scene.triangles.clone();
    scene.pose(0.8).unwrap();
    let mut moved = 0;
    for ((triangle, old), surface) in scene.triangles.iter().zip(&before).zip(&scene.surfaces) {
        let back = scene.instances[surface.instance as usize].to_previous.point(triangle.a);
        // f32 of a dozen operations on coordinates up to 10 m.
        assert!((back - old.a).length() <= 1e-6 * 10.0, "{back} should be {}", old.a);
        moved += u32::from((triangle.a - old.a).length() > 0.05);
    }
    assert!(moved > 200);
}

#[test]
fn posed_scenes_are_static_scenes_with_the_same_places() {
    // At 1 s, where every value is exact in f32: a camera, a spot and a mesh below a parent.
    let build = |animated: bool| {
        let mut file = File::new();
        let floor = file.mesh(&square(4.0), 0);
        file.root(json!({ "mesh": floor, "translation": [0, 0, -2] }));
        let mesh = file.mesh(&square(0.5), 0);
        let child = file.push("nodes", json!({ "mesh": mesh, "translation": [0.5, 0, 0.25] }));
        let turn = [0.0, 0.6, 0.0, 0.8];
        let spot = json!({ "KHR_lights_punctual": { "light": 1 } });
        let places = [
            (json!({ "camera": 0 }), [0.5, 0.25, 6.0]),
            (json!({ "extensions": spot }), [1.0, 0.5, 5.0]),
            (json!({ "children": [child], "scale": [1.0, 2.0, -1.5] }), [0.25, -0.5, 1.0]),
        ];
        for (mut node, place) in places {
            if animated {
                let node = file.root(node);
                let ahead = place.map(|x: f32| x + 1.0);
                let behind = place.map(|x: f32| x - 1.0);
                file.channel(node, "translation", "LINEAR", &[0.0, 2.0], &[behind, ahead].concat());
                let other = [0.8, 0.0, 0.6, 0.0];
                file.channel(node, "rotation", "LINEAR", &[0.0, 1.0, 2.0], &[other, turn, other].concat());
            } else {
                (node["translation"], node["rotation"]) = (json!(place), json!(turn));
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
        met += u32::from(!a.is_miss() && moving.surfaces[a.triangle as usize].instance != 0);
        if same && !a.is_miss() {
            let normal = |scene: &Scene, hit: &Hit| {
                let t = scene.triangles[hit.triangle as usize];
                (t.b - t.a).cross(t.c - t.a).normalize()
            };
            assert!((normal(&moving, &a) - normal(&still, &b)).length() < 1e-4, "fronts agree");
        }
    }
    assert!(met > 50 && others <= 2, "{met} met the mesh, {others} of 4000 differ");
}

/// A lamp over a floor with a mirror; the lamp grows from nothing to twice its size.
fn lamp() -> File {
    let mut file = File::new();
    let floor = file.mesh(&square(2.0), 0);
    file.root(json!({ "mesh": floor }));
    let mirror = file.mesh(&square(1.0), 2);
    file.root(json!({ "mesh": mirror, "translation": [0, 1.5, 1], "rotation": [0.6, 0, 0, 0.8] }));
    file.root(json!({ "camera": 0, "translation": [0, -1, 5] }));
    let lamp = file.mesh(&square(0.5), 1);
    let node = file.root(json!({ "mesh": lamp, "translation": [0, 0, 3], "rotation": [1, 0, 0, 0] }));
    file.channel(node, "scale", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 2.0, 2.0, 2.0]);
    file
}

#[test]
fn flux_follows_the_area_and_a_lamp_of_no_size_is_out() {
    let mut scene = lamp().load().unwrap();
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
    let rows = scene.instances.iter();
    assert!(rows.flat_map(|row| [row.to_previous.x, row.to_previous.offset]).all(Vec3::is_finite));
    let mut tracer = scene.tracer(scene.features(0.25));
    let through = Ray::endless(Vec3::new(0.0, 0.0, 9.0), Vec3::NEG_Z);
    let hit = tracer.closest(&through);
    assert_eq!(scene.surfaces[hit.triangle as usize].instance, 0, "the lamp is not there");
}

#[test]
fn frames_go_dark_with_the_lamp_and_light_up_again() {
    let mut scene = lamp().load().unwrap();
    let settings = Settings { width: 48, height: 32, light_paths: 20_000, ..Settings::default() };
    let camera = |scene: &Scene| scene.cameras[0].clone();
    let open = |scene: &Scene| {
        let features = scene.features(settings.specular_roughness);
        let choice = RunnerChoice::Cpu { threads: 0 };
        Session::new(&choice, scene, &camera(scene), &settings, &BASIC, &PHOTONS_GRID, features).unwrap()
    };
    let mut session = open(&scene);
    for (time, is_lit) in [(0.0, false), (0.8, true), (0.0, false), (0.4, true)] {
        scene.pose(time).unwrap();
        session.pose(&scene, &camera(&scene)).unwrap();
        session.frame(0).unwrap();
        let picture = session.picture().unwrap();
        let sum = |pixels: &[Vec3]| pixels.iter().map(|p| f64::from(p.element_sum())).sum::<f64>();
        assert_eq!((sum(&picture.path) > 0.0, sum(&picture.caustics) > 0.0), (is_lit, is_lit), "at {time} s");
        // What is uploaded is all that a session opened at this time has.
        let mut fresh = open(&scene);
        fresh.frame(0).unwrap();
        let fresh = fresh.picture().unwrap();
        assert_eq!((fresh.path, fresh.caustics), (picture.path, picture.caustics), "at {time} s");
    }
}

#[test]
fn runners_agree_after_every_pose() {
    let Some(gpu) = gpu() else { return };
    let settings = Settings { width: 32, height: 32, light_paths: 1024, ..Settings::default() };
    for &hardware in gpu.tracers() {
        let mut scene = soups().load().unwrap();
        let mut twin = Twin::open(&gpu, hardware, &scene, &settings);
        let (mut cpu, mut device) = (Upload::new(&scene), Upload::new(&scene));
        for time in [0.0, 1.9, 0.6] {
            scene.pose(time).unwrap();
            cpu.run(&mut *twin.cpu, &scene).unwrap();
            device.run(&mut *twin.gpu, &scene).unwrap();
            let rays = aimed(&scene, 20_000);
            twin.write("rays", &rays);
            twin.step(&STEP_HIT, rays.len());
            let (cpu, gpu) = twin.head::<Hit>("hits", rays.len());
            let same = |a: &Hit, b: &Hit| {
                a.triangle == b.triangle
                    && (a.is_miss()
                        || ((a.distance - b.distance).abs() <= 1e-4 * a.distance.max(1.0)
                            && (a.u - b.u).abs().max((a.v - b.v).abs()) < 1e-2))
            };
            let others = cpu.iter().zip(&gpu).filter(|(a, b)| !same(a, b)).count();
            let moving = cpu.iter().filter(|hit| !hit.is_miss());
            let moving = moving.filter(|hit| scene.surfaces[hit.triangle as usize].instance != 0).count();
            assert!(moving > 4000, "{moving}");
            // The rule for twins: 0.2 % on edges and slivers.
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
        let mut file = lamp();
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
        let mut file = lamp();
        *file.document.pointer_mut(pointer).unwrap() = json!(999);
        let error = file.write_and_load(&strict).expect_err(pointer).to_string();
        assert!(error.contains("moving.gltf"), "{error}");
    }
    // A camera flattened at some time is an error then, and the scene stays as it was.
    let mut file = lamp();
    file.channel(2, "scale", "STEP", &[0.0, 1.0], &[1.0, 1.0, 1.0, 0.0, 1.0, 1.0]);
    let mut scene = file.load().unwrap();
    let camera = scene.cameras[0].clone();
    assert!(scene.pose(1.0).unwrap_err().to_string().contains("singular"));
    assert_eq!(scene.cameras[0], camera);
}

#[test]
fn sessions_take_their_buffers_for_all_times() {
    let scene = lamp().load().unwrap();
    let tables = scene.buffers();
    let of = |name: &str| tables.iter().find(|(table, _)| *table == name).unwrap().1.len();
    assert_eq!((of("lights"), of("object_triangles")), (0, 2 * size_of::<Triangle>()));
    let settings = Settings::default();
    assert_eq!(settings.params(&scene, &scene.cameras[0], 0).light_path_count, 0);
    assert_eq!(settings.largest(&scene, &scene.cameras[0]).light_path_count, settings.light_paths);
}
