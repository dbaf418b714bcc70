//! Inspection of pixels: it finds the values of the frame again, to the bit, and its paths are consistent.

use caustics::inspect::{CameraPath, Event, Inspection, LightPath, SharedLight, Vertex};
use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::scene::texture::Role;
use caustics::session::{Session, SessionError};
use caustics::{history, method};
use caustics_kernels::emission::{AIMED, Emission, GUIDED, POWER};
use caustics_kernels::interface::choice::{Caustics, IndirectShare, PixelFilter, ThinWalls};
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::point::PointGeometry;
use caustics_kernels::interface::texture::MaterialTextures;
use caustics_kernels::method::Method;
use caustics_tests::moving::Moving;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};

const WIDTH: u32 = 64;
const HEIGHT: u32 = 36;

fn config(emission: &'static Emission, caustics: Caustics) -> RenderConfig {
    RenderConfig {
        width: WIDTH,
        height: HEIGHT,
        light_paths: Paths::Count(12_000),
        emission,
        caustics,
        pixel_filter: PixelFilter::Box,
        ..RenderConfig::default()
    }
}

fn open(scene: &Scene, config: RenderConfig, method: &'static Method) -> Session {
    let mut session = Session::builder(scene).config(config).method(method).build().expect("a session opens");
    session.keep_starts(true);
    session
}

/// Vertices of a path, without the faces that it only passes.
fn scatterings(vertices: &[Vertex]) -> Vec<&Vertex> {
    vertices.iter().filter(|vertex| vertex.event.is_vertex()).collect()
}

/// Pixels with the most photons, with a few, with none, and some that are seen by a specular surface.
fn pixels(photons: &[f32], depth: &[f32]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..photons.len() as u32).collect();
    order.sort_by_key(|&pixel| (-photons[pixel as usize] as i64, pixel));
    let any = photons.iter().filter(|photons| **photons > 0.0).count();
    assert!(any > 20, "{any} pixels with photons");
    let specular: Vec<u32> =
        order.iter().copied().filter(|&pixel| depth[pixel as usize] > 1.0).take(2).collect();
    assert!(!specular.is_empty(), "no point is seen by a specular surface");
    [vec![order[0], order[1], order[any / 2], order[any - 1], order[order.len() - 1]], specular].concat()
}

/// Compares an inspected pixel with the image of the frame.
#[track_caller]
fn holds(session: &mut Session, scene: &Scene, pixel: u32) -> Inspection {
    let image = session.image().expect("an image");
    let geometry: Vec<PointGeometry> = session.read("point_geometry").expect("points");
    let point = geometry[pixel as usize];
    let found = session.inspect(scene, pixel % WIDTH, pixel / WIDTH, 6).expect("a pixel");
    let photons = found.photons.as_ref().expect("photons");
    assert_eq!((photons.count, photons.gathered), (photons.gathered, image.photons[pixel as usize] as u32));
    assert_eq!(photons.skipped, 0);
    assert_eq!(photons.radiance, image.caustics[pixel as usize].to_array());
    assert_eq!(found.point.is_some(), point.exists());

    // The prefix ends at the point.
    let met = scatterings(&found.camera_path.vertices);
    if let Some(reported) = found.point {
        let position = (point.position.as_dvec3() + scene.origin).to_array();
        let last = met.last().expect("a vertex");
        assert_eq!((last.position, reported.position), (position, position));
        assert_eq!(
            (last.event, reported.depth, met.len()),
            (Event::CollectionPoint, point.depth, point.depth as usize)
        );
        assert_eq!((reported.radius, reported.normal), (point.radius, point.normal.to_array()));
        assert!(!last.specular && met[..met.len() - 1].iter().all(|vertex| vertex.specular));
    }

    // Each light path ends at its photon, on the disc.
    assert_eq!(found.light_paths.len(), photons.some.len());
    let (some, expected) = (photons.some.len(), (photons.count as usize).min(6));
    assert!(
        some <= expected && some >= expected.min(1) && (some == expected || photons.count > 6),
        "{some} of {expected}"
    );
    for (path, photon) in found.light_paths.iter().zip(&photons.some) {
        let met = scatterings(&path.vertices);
        let last = met.last().expect("a vertex");
        assert_eq!((last.event, last.position, path.path), (Event::Photon, photon.position, photon.path));
        assert_eq!(met.len() as u32, photon.scatterings + 1);
        assert!(met[..met.len() - 1].iter().any(|vertex| vertex.specular));
        assert!(path.light.is_some(), "{path:?}");
        let away = DVec3::from_array(photon.position) - (point.position.as_dvec3() + scene.origin);
        assert!(away.length() <= f64::from(point.radius) * 1.001);
    }
    assert_straight(&found);
    found
}

/// Asserts that a path that is not turned at a face goes straight on, and that a mirror reflects.
#[track_caller]
fn assert_straight(found: &Inspection) {
    let CameraPath { eye, direction, vertices, .. } = &found.camera_path;
    let of_lights = found
        .light_paths
        .iter()
        .map(|LightPath { start, direction, vertices, .. }| (start, direction, vertices));
    for (start, direction, vertices) in of_lights.chain([(eye, direction, vertices)]) {
        let position = |position: &[f64; 3]| DVec3::from_array(*position);
        let Some(first) = vertices.first() else { continue };
        let along = (position(&first.position) - position(start)).normalize();
        assert!(
            along.dot(Vec3::from_array(*direction).as_dvec3()) > 0.999,
            "{start:?} {direction:?} {first:?}"
        );
        for three in vertices.windows(3) {
            let [a, b, c] = three else { unreachable!() };
            let (to, from) = (
                position(&b.position) - position(&a.position),
                position(&c.position) - position(&b.position),
            );
            // Short segments are mostly rounding and the step off a face.
            if to.length() < 0.01 || from.length() < 0.01 {
                continue;
            }
            let (to, from) = (to.normalize(), from.normalize());
            let side = Vec3::from_array(b.normal).as_dvec3();
            assert!(to.dot(side) < 1.0e-3, "{b:?}");
            let fits = match b.event {
                Event::Reflected | Event::TotallyReflected | Event::Scattered => from.dot(side) > -1.0e-3,
                Event::Entered | Event::Left => from.dot(side) < 1.0e-3,
                Event::Passed | Event::Hole | Event::Blended | Event::Covered => from.dot(to) > 0.99,
                // No segment follows the other events.
                _ => false,
            };
            assert!(fits, "{b:?}");
        }
    }
}

#[test]
fn inspected_photons_sum_to_the_pixel_for_every_emission_and_caustics_setting() {
    for name in ["mirror-room", "prism"] {
        let scene = committed(name);
        for method in [&method::BASIC, &method::PROGRESSIVE] {
            for caustics in [Caustics::First, Caustics::Any] {
                for emission in [&POWER, &AIMED, &GUIDED] {
                    let mut session = open(&scene, config(emission, caustics), method);
                    // Where the emission learns, the first frame has training paths, and the second a pilot.
                    for frame in 0..2 {
                        session.jump();
                        session.frame(frame).expect("a frame");
                        let image = session.image().expect("an image");
                        for pixel in pixels(&image.photons, &image.depth) {
                            let found = holds(&mut session, &scene, pixel);
                            let is_first = |path: &LightPath| scatterings(&path.vertices)[0].specular;
                            assert!(caustics == Caustics::Any || found.light_paths.iter().all(is_first));
                        }
                    }
                }
            }
        }
    }
}

/// A room in which a glass ball stands half in a block of water; the water's top inside the ball has no effect.
fn nested_room() -> Scene {
    let mut b = Builder::default();
    let (wall, light) = (b.material(lambert(0.6)), b.material(emitter(10.0)));
    let water = b.material(Material { priority: 1, ..glass(1.33) });
    let ball = b.material(Material { priority: 2, ..glass(1.5) });
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.panel(light, DVec3::new(0.1, 0.95, 0.0), 0.4 * DVec3::X, 0.4 * DVec3::Z);
    b.block(water, DVec3::new(-0.6, -0.9, -0.6), DVec3::new(0.6, -0.4, 0.6), false);
    b.sphere(ball, DVec3::new(0.0, -0.4, 0.0), 0.3, 48, 24);
    b.camera(DVec3::new(0.1, 0.2, 0.95), DVec3::new(0.0, -0.5, 0.0), 1.0);
    b.build()
}

/// A glass ball before a mirror, under a light behind a screen with holes.
fn holed_room() -> Scene {
    let mut b = Builder::default();
    let (wall, light) = (b.material(lambert(0.6)), b.material(emitter(40.0)));
    let (ball, mirror) = (b.material(glass(1.5)), b.material(metal(0.9, 0.0)));
    let alpha = |x: u32, y: u32| [255, 255, 255, if (x + y).is_multiple_of(2) { 255 } else { 0 }];
    let base_color = b.texture(Role::Color, 16, 16, alpha);
    let holes = MaterialTextures { base_color, alpha_cutoff: 0.5, ..MaterialTextures::default() };
    let screen = b.textured(lambert(0.2), holes);
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.panel(light, DVec3::new(0.1, 0.95, 0.0), 0.4 * DVec3::X, 0.4 * DVec3::Z);
    b.panel(screen, DVec3::new(0.0, 0.5, 0.0), 0.9 * DVec3::Z, 0.9 * DVec3::X);
    b.panel(mirror, DVec3::new(0.0, -0.3, -0.95), 0.8 * DVec3::X, 0.5 * DVec3::Y);
    b.sphere(ball, DVec3::new(0.0, -0.6, 0.0), 0.35, 48, 24);
    b.camera(DVec3::new(0.1, 0.2, 0.95), DVec3::new(0.0, -0.4, 0.0), 1.0);
    b.build()
}

#[test]
fn inspected_paths_report_their_events_in_every_kind_of_scene() {
    let scenes = [
        ("mixed", mixed_room().build()),
        ("blended", blended_room().build()),
        ("dispersive", dispersive_room()),
        ("pool", pool(DVec3::new(0.1, 0.4, 0.95), DVec3::new(0.0, -0.4, 0.0)).build()),
        ("air", open_air().build()),
        ("moving", Moving::GlassCaster.scene()),
        ("nested", nested_room()),
        ("holed", holed_room()),
    ];
    for (name, scene) in scenes {
        let mut session = open(&scene, config(&AIMED, Caustics::Any), &method::BASIC);
        session.frame(3).expect("a frame");
        let image = session.image().expect("an image");
        let (mut events, mut of_one_channel) = (Vec::new(), false);
        let middle = (HEIGHT / 2) * WIDTH + WIDTH / 2;
        for pixel in pixels(&image.photons, &image.depth).into_iter().chain([middle]) {
            let found = holds(&mut session, &scene, pixel);
            let paths =
                found.light_paths.iter().map(|path| &path.vertices).chain([&found.camera_path.vertices]);
            events.extend(paths.flatten().map(|vertex| vertex.event));
            // A path has a channel once it entered dispersive glass, or met the block, which is rough.
            for LightPath { vertices, .. } in &found.light_paths {
                let has_channel = vertices.last().is_some_and(|last| last.channel.is_some());
                let expected = vertices
                    .iter()
                    .any(|vertex| vertex.event == Event::Entered || vertex.material == "material 3");
                assert_eq!(has_channel, name == "dispersive" && expected, "{name}: {vertices:?}");
                of_one_channel |= has_channel;
            }
        }
        assert_eq!(of_one_channel, name == "dispersive", "{name}");
        let has = |event| events.contains(&event);
        assert_eq!(
            [has(Event::Blended), has(Event::Hole), has(Event::Covered)],
            ["blended", "holed", "nested"].map(|other| other == name),
            "{name}"
        );
        assert!(has(Event::Entered), "{name}: {events:?}");
        // The pool's water goes down to its walls.
        assert_eq!(has(Event::Left), name != "pool", "{name}: {events:?}");
    }
}

#[test]
fn inspected_pixel_in_a_mirror_reports_a_light_path_through_a_pane() {
    let mut b = Builder::default();
    let (floor, mirror) = (b.material(lambert(0.7)), b.material(metal(1.0, 0.0)));
    let pane = b.material(pane(1.5));
    b.panel(floor, DVec3::ZERO, 2.0 * DVec3::Z, 2.0 * DVec3::X);
    b.panel(mirror, DVec3::new(0.0, 1.0, -1.0), 2.0 * DVec3::X, 0.9 * DVec3::Y);
    b.panel(pane, DVec3::new(0.0, 1.0, 0.5), 1.5 * DVec3::Z, 1.5 * DVec3::X);
    b.light(DVec3::new(0.0, 3.0, 0.5), 5.0);
    b.camera(DVec3::new(0.0, 0.5, 1.0), DVec3::new(0.0, 0.3, -1.0), 0.2);
    let scene = Scene { origin: DVec3::new(10.0, 20.0, 30.0), ..b.build() };
    let config = RenderConfig {
        light_paths: Paths::Count(200_000),
        pixel_filter: PixelFilter::Centre,
        thin_walls: ThinWalls::Event,
        ..config(&POWER, Caustics::First)
    };
    let mut session = open(&scene, config, &method::BASIC);
    session.frame(0).expect("a frame");
    let pixel = (HEIGHT / 2) * WIDTH + WIDTH / 2;
    let found = holds(&mut session, &scene, pixel);
    let reported = |vertices: &[Vertex]| -> Vec<(Event, Vec<&'static str>, String)> {
        vertices.iter().map(|vertex| (vertex.event, vertex.lobes.clone(), vertex.material.clone())).collect()
    };
    assert_eq!(
        reported(&found.camera_path.vertices),
        [
            (Event::Reflected, vec!["metal"], "material 1".into()),
            (Event::CollectionPoint, vec!["lambert"], "material 0".into())
        ]
    );
    assert_eq!(found.camera_path.eye, [10.0, 20.5, 31.0]);
    assert!((found.camera_path.vertices[0].position[2] - 29.0).abs() < 1e-5);
    assert!((found.point.expect("a point").position[1] - 20.0).abs() < 1e-5);
    assert!(!found.light_paths.is_empty());
    for path in &found.light_paths {
        assert_eq!(
            reported(&path.vertices),
            [
                (Event::Passed, vec!["glass"], "material 2".into()),
                (Event::Photon, vec![], "material 0".into())
            ]
        );
        assert_eq!((path.start, path.light.expect("a light").kind), ([10.0, 23.0, 30.5], "point"));
    }
    // Asked for all photons, the inspection returns all.
    let all = session.inspect(&scene, WIDTH / 2, HEIGHT / 2, usize::MAX).expect("a pixel");
    let photons = all.photons.expect("photons");
    let sum: Vec3 = photons.some.iter().map(|photon| Vec3::from_array(photon.radiance)).sum();
    let whole = Vec3::from_array(photons.radiance);
    assert!((sum - whole).abs().max_element() <= 1e-4 * whole.max_element(), "{sum} {whole}");
    assert_eq!(photons.some.len(), photons.count as usize);
}

#[test]
fn inspection_skips_and_counts_pilot_paths_whose_maps_are_gone() {
    let scene = committed("mirror-room");
    let mut session = open(&scene, config(&GUIDED, Caustics::First), &method::BASIC);
    session.keep_starts(false);
    for (frame, moves, skipped) in [(0, false, 0), (1, false, 0), (2, true, 12_000 / 8)] {
        if moves {
            session.jump();
        }
        session.frame(frame).expect("a frame");
        let found = session.inspect(&scene, WIDTH / 2, HEIGHT / 2, 0).expect("a pixel");
        let photons = found.photons.expect("photons");
        assert_eq!((photons.skipped, photons.light_paths), (skipped, 12_000 - skipped));
    }
}

#[test]
fn keeping_emission_maps_for_inspection_changes_no_bit() {
    let scene = committed("mirror-room");
    let images = [false, true].map(|keeps| {
        let mut session = open(&scene, config(&GUIDED, Caustics::First), &method::BASIC);
        session.keep_starts(keeps);
        [0, 1].map(|frame| {
            session.jump();
            session.frame(frame).expect("a frame");
            session.image().expect("an image")
        })
    });
    assert_eq!(images[0], images[1]);
}

#[test]
fn inspection_reports_points_and_photons_of_methods_that_have_them() {
    let scene = committed("mirror-room");
    for (method, has_point, has_photons) in
        [(&method::PATH, false, false), (&method::KIM2019, true, false), (&method::YANG2021, true, false)]
    {
        let mut session = open(&scene, config(&POWER, Caustics::First), method);
        session.frame(0).expect("a frame");
        let found = session.inspect(&scene, WIDTH / 2, HEIGHT / 2, 4).expect("a pixel");
        assert!(!found.camera_path.vertices.is_empty());
        assert_eq!(
            (found.point.is_some(), found.photons.is_some()),
            (has_point, has_photons),
            "{}",
            method.name
        );
        assert!(found.light_paths.is_empty());
    }
}

#[test]
fn inspected_photons_exclude_those_reused_by_a_history() {
    let scene = committed("mirror-room");
    let config = RenderConfig { history: &history::VALIDATED, ..config(&POWER, Caustics::First) };
    let mut session = open(&scene, config, &method::BASIC);
    for frame in 0..2 {
        session.frame(frame).expect("a frame");
    }
    let image = session.image().expect("an image");
    for pixel in pixels(&image.photons, &image.depth) {
        let found = session.inspect(&scene, pixel % WIDTH, pixel / WIDTH, 1).expect("a pixel");
        assert_eq!(found.photons.expect("photons").count, image.photons[pixel as usize] as u32);
    }
}

#[test]
fn inspection_is_refused_before_a_frame_and_after_a_pose() {
    let mut scene = committed("moving-caster");
    let camera = scene.cameras[0].clone();
    let mut session = open(&scene, config(&POWER, Caustics::First), &method::BASIC);
    let no_frame = |session: &mut Session, scene: &Scene| {
        matches!(session.inspect(scene, 0, 0, 1), Err(SessionError::NoFrame))
    };
    assert!(no_frame(&mut session, &scene));
    session.frame(0).expect("a frame");
    assert!(!no_frame(&mut session, &scene));
    assert!(matches!(session.inspect(&scene, WIDTH, 0, 1), Err(SessionError::NoPixel { .. })));
    assert!(matches!(session.inspect(&scene, 0, HEIGHT, 1), Err(SessionError::NoPixel { .. })));
    scene.pose(1.0).expect("a time");
    session.pose(&scene, &camera).expect("a pose");
    assert!(no_frame(&mut session, &scene));
    session.frame(1).expect("a frame");
    let image = session.image().expect("an image");
    for pixel in pixels(&image.photons, &image.depth) {
        holds(&mut session, &scene, pixel);
    }
}

/// In the dark no light path is traced.
#[test]
fn inspection_of_a_dark_scene_reports_the_camera_path_alone() {
    let scene = Scene { lights: Vec::new(), ..committed("mirror-room") };
    let mut session = open(&scene, config(&POWER, Caustics::First), &method::BASIC);
    session.frame(0).expect("a frame");
    let found = session.inspect(&scene, WIDTH / 2, HEIGHT / 2, 4).expect("a pixel");
    let photons = found.photons.expect("photons");
    assert_eq!((photons.count, photons.light_paths, photons.skipped), (0, 0, 0));
}

#[test]
fn inspection_finds_the_points_that_share_their_indirect_light() {
    let scene = committed("mirror-room");
    let config = RenderConfig { width: 80, height: 45, ..config(&GUIDED, Caustics::First) };
    let mut sessions = [IndirectShare::None, IndirectShare::Points].map(|share| {
        let config = RenderConfig { indirect_share: Some(share), ..config.clone() };
        open(&scene, config, &method::PROGRESSIVE)
    });
    let [none, points] = sessions.each_mut().map(|session| {
        session.frame(0).expect("a frame runs");
        session.image().expect("an image").path
    });
    let geometry: Vec<PointGeometry> = sessions[1].read("point_geometry").expect("points");
    let (mut shared, mut takes_itself, mut deeper) = (0, 0, 0);
    for pixel in (0..80 * 45).step_by(37) {
        let (x, y) = (pixel % 80, pixel / 80);
        assert_eq!(sessions[0].inspect(&scene, x, y, 0).expect("a pixel").shared_light, None);
        let change = points[pixel as usize] - none[pixel as usize];
        let found = sessions[1].inspect(&scene, x, y, 0).expect("a pixel").shared_light;
        let Some(SharedLight { radius, own, mean, change: told, points: givers }) = found else {
            assert_eq!(change, Vec3::ZERO, "pixel {pixel}");
            continue;
        };
        shared += 1;
        let light = |light: [f32; 3]| Vec3::from_array(light);
        let scale = none[pixel as usize].max_element().max(points[pixel as usize].max_element());
        assert!((change - light(told)).abs().max_element() <= 1.0e-6 * scale, "{change} {told:?}");
        let average = givers.iter().map(|giver| light(giver.light)).sum::<Vec3>() / givers.len() as f32;
        assert!((average - light(mean)).abs().max_element() <= 1.0e-4 * average.max_element());
        if let Some(itself) = givers.iter().find(|giver| giver.pixel == [x, y]) {
            assert_eq!(itself.light, own);
            takes_itself += 1;
        }
        for giver in &givers {
            let point = geometry[(giver.pixel[1] * 80 + giver.pixel[0]) as usize];
            let away = point.position - geometry[pixel as usize].position;
            assert!(away.length() <= radius && giver.depth == point.depth);
            deeper += u32::from(giver.depth < geometry[pixel as usize].depth);
        }
    }
    // Points of crowded cells may be left out.
    assert!(
        shared > 40 && takes_itself > shared / 2,
        "{shared} points share, {takes_itself} with themselves"
    );
    assert!(deeper > 0, "no sample of a less deep point");
}
