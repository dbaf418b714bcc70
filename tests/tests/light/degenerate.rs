//! Degenerate input: too small, too far, too flat, too few, or absent.
//!
//! Other tests of this kind:
//!
//! - NaN, infinite and zero-area geometry of files: `host/scene/src/gltf/tests.rs`
//! - a million photons at one position: `gathers.rs`, `million_photons_at_one_position_sum_exactly`
//! - gathers without photons or points: `gathers.rs`,
//!   `gathers_agree_without_photons_without_points_and_with_one_photon`
//! - gathers with a tenth of the points: `gathers.rs`,
//!   `every_gather_matches_brute_force_with_nine_points_in_ten_missing`
//! - files moved by 1e5 m: `invariances.rs`, `scene_moved_by_1e5_m_keeps_its_image_means`

use caustics::counters::Counters;
use caustics::render_config::{Paths, Radius, RenderConfig};
use caustics::rendered_image::RenderedImage;
use caustics::scene::{LightShape, PunctualLight, Scene, SceneError, SceneParts};
use caustics_kernels::interface::choice::Caustics;
use caustics_kernels::interface::counters::Counter;
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};
use std::f32::consts::PI;

fn frame(scene: &Scene, config: &RenderConfig) -> (RenderedImage, Counters) {
    render(scene, config, "photons-grid", None, 0, 1).remove(0)
}

fn assert_sound(image: &RenderedImage, counters: &Counters) {
    let layers = image.path.iter().chain(&image.caustics);
    assert!(layers.clone().all(|value| value.is_finite() && value.min_element() >= 0.0));
    assert!(image.radius.iter().all(|radius| radius.is_finite() && *radius >= 0.0));
    assert_eq!(counters.get(Counter::NonFinite), 0);
    assert!(counters.warnings().is_empty(), "{:?}", counters.warnings());
}

/// A floor of 100 x 100 m under a mirror and a spot light that shines at it. All of it is `away` m along every axis and
/// not recentred, like a part of a scene far from its middle. The camera sees 3 mm of it.
fn far_away(away: f64) -> Scene {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z) + away;
    let mut b = Builder::default();
    let floor = b.material(lambert(0.6));
    let mirror = b.material(metal(1.0, 0.0));
    b.panel(floor, at(0.0, 0.0, 0.0), 50.0 * DVec3::Z, 50.0 * DVec3::X);
    b.panel(mirror, at(0.0, 40.0, 0.0), 40.0 * DVec3::X, 40.0 * DVec3::Z);
    b.spot(at(0.0, 20.0, 0.0), DVec3::Y, 0.04, 0.05, 1000.0);
    b.camera(at(0.0, 10.0, 0.0), at(0.0, 0.0, 0.0), 0.000_32);
    b.build()
}

/// A radius below an ulp of the position would take no photon, or all photons of one position. It is kept at 4 ulp, and
/// the light is that near the origin. Positions are steps of 1/12 of that disc's width, which moves its area by a few
/// per cent.
#[test]
fn radius_at_100_km_is_at_least_4_ulp_and_keeps_the_light() {
    let config =
        RenderConfig { width: 4, height: 4, light_paths: Paths::Count(200_000), ..RenderConfig::default() };
    // The virtual light is 60 m away, and the floor is seen in its inner cone.
    let expected = f64::from(0.6 / PI) * 1000.0 / 3600.0;
    for away in [0.0, 1e5] {
        let scene = far_away(away);
        // Near the origin the discs are widened to the smallest radius far away, 4 ulp of 1e5 m.
        let radius_px = if away == 0.0 { 105.6 } else { 1.0 };
        let config = RenderConfig { radius: Radius::Px(radius_px), ..config };
        let frames = render(&scene, &config, "photons-grid", None, 0, 20);
        let means: Vec<f64> = frames.iter().map(|(image, _)| mean_of(&image.caustics)).collect();
        let (mean, error) = mean_and_error(&means);
        let radius = frames[0].0.radius[0];
        println!(
            "{away:e} m away: radius {radius}, caustics {mean:.5} +- {error:.5}, expected {expected:.5}"
        );
        frames.iter().for_each(|(image, counters)| assert_sound(image, counters));
        if away > 0.0 {
            assert!((radius / (4.0 * 1e5 / 8_388_608.0) - 1.0).abs() < 1e-3, "{radius}");
        }
        assert!(error < 0.05 * expected, "the standard error is too large: {error}");
        assert!((mean - expected).abs() < 3.0 * error + 0.03 * expected);
    }
}

/// Builds a scene of parts, after `spoil` changed its floor's tables.
fn spoiled(
    spoil: impl Fn(&mut Vec<Triangle>, &mut Vec<TriangleSurface>, &mut Vec<PunctualLight>),
) -> Result<Scene, SceneError> {
    let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]].map(|[x, z]| Vec3::new(x, 0.0, z));
    let face = |a: usize, b: usize, c: usize| Triangle { a: corners[a], b: corners[b], c: corners[c] };
    let up = TriangleSurface {
        normal_a: Vec3::Y,
        normal_b: Vec3::Y,
        normal_c: Vec3::Y,
        ..TriangleSurface::default()
    };
    let (mut triangles, mut surfaces) = (vec![face(0, 1, 2), face(0, 2, 3)], vec![up; 2]);
    let mut lights = vec![PunctualLight::point(Vec3::Y, Vec3::ONE)];
    spoil(&mut triangles, &mut surfaces, &mut lights);
    let camera = caustics::scene::SceneCamera::look_at("eye", 2.0 * Vec3::Y, Vec3::ZERO, Vec3::Z, 0.8);
    let materials = vec![lambert(0.5)];
    let parts = SceneParts {
        name: "spoiled".into(),
        triangles,
        surfaces,
        materials,
        material_names: vec!["m".into()],
        lights,
        cameras: vec![camera],
        ..SceneParts::default()
    };
    parts.build()
}

/// Triangles without an area are dropped and counted; the image is the same to the bit. Values that are not finite are
/// refused, so that none reaches a kernel.
#[test]
fn zero_area_triangles_are_dropped_and_non_finite_values_refused() {
    let config = RenderConfig { width: 16, height: 16, ..RenderConfig::default() };
    let plain = spoiled(|_, _, _| ()).unwrap();
    let flat = spoiled(|triangles, surfaces, _| {
        let p = Vec3::new(0.3, 0.5, 0.1);
        for (b, c) in [(p, p), (p + Vec3::X, p), (p + Vec3::X, p + 2.0 * Vec3::X), (p + Vec3::X, p + 1e-9)] {
            triangles.insert(1, Triangle { a: p, b, c });
            surfaces.push(surfaces[0]);
        }
    })
    .unwrap();
    assert_eq!((plain.dropped_triangles, flat.dropped_triangles), (0, 4));
    assert_eq!(frame(&plain, &config).0, frame(&flat, &config).0);

    let direction = Vec3::new(f32::NAN, 0.0, 0.0);
    for bad in [f32::NAN, f32::INFINITY, 1e30] {
        assert!(spoiled(|triangles, _, _| triangles[1].b.z = bad).is_err(), "corner {bad}");
        assert!(spoiled(|_, surfaces, _| surfaces[0].normal_c.x = bad).is_err(), "normal {bad}");
        assert!(spoiled(|_, _, lights| lights[0].position.x = bad).is_err(), "light {bad}");
    }
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        assert!(spoiled(|_, _, lights| lights[0].intensity.y = bad).is_err(), "intensity {bad}");
    }
    assert!(spoiled(|_, _, lights| lights[0].shape = LightShape::Directional { direction }).is_err());
    let error = spoiled(|triangles, _, _| triangles[1].b.z = f32::NAN).unwrap_err().to_string();
    assert!(error.contains("triangle 1"), "{error}");
}

/// Images of any size hold the light of each pixel's own path.
#[test]
fn odd_sizes_render_every_pixel() {
    let scene = mixed_room().build();
    for (width, height) in [(1, 1), (1, 7), (7, 1), (1917, 1079)] {
        let config =
            RenderConfig { width, height, light_paths: Paths::Count(20_000), ..RenderConfig::default() };
        let (image, counters) = frame(&scene, &config);
        assert_sound(&image, &counters);
        let pixels = (width * height) as usize;
        assert_eq!((image.path.len(), image.caustics.len(), image.radius.len()), (pixels, pixels, pixels));
        assert!(mean_of(&image.path) > 0.01, "{width} x {height} is dark");

        // Trace path by path on this thread: all pixels of a small image and 500 of a large one.
        let world = World::new(&scene, &config);
        let (mut tracer, mut tally) = (world.tracer(), Tally::default());
        for pixel in (0..pixels).step_by((pixels / 500).max(1)).chain([pixels - 1]) {
            let own = caustics_tests::collected::camera_path(
                pixel as u32,
                &world.params,
                world.features,
                world.tables(),
                &mut tracer,
                &mut tally,
            );
            assert_eq!(own.light.radiance, image.path[pixel], "{width} x {height}, pixel {pixel}");
            assert_eq!(own.point.geometry.radius, image.radius[pixel]);
        }
    }
}

/// One light path carries all flux: its sum is huge or zero, and fits into the accumulator.
#[test]
fn one_light_path_per_frame_has_the_mean_of_many() {
    let scene = far_away(0.0);
    let with = |light_paths, frames| {
        let config = RenderConfig {
            width: 16,
            height: 16,
            light_paths: Paths::Count(light_paths),
            radius: Radius::Px(40_000.0),
            ..RenderConfig::default()
        };
        let frames = render(&scene, &config, "photons-grid", None, 0, frames);
        frames.iter().for_each(|(image, counters)| {
            assert_sound(image, counters);
            assert_eq!(counters.get(Counter::LightPaths), u64::from(light_paths));
        });
        let means: Vec<f64> = frames.iter().map(|(image, _)| mean_of(&image.caustics)).collect();
        mean_and_error(&means)
    };
    let ((one, error), (many, error_many)) = (with(1, 4000), with(4000, 16));
    println!("4000 frames of one path: {one:.5} +- {error:.5}; 16 of 4000: {many:.5} +- {error_many:.5}");
    assert!(error < 0.05 * many, "the standard error is too large");
    assert!((one - many).abs() < 3.0 * error.hypot(error_many));
}

/// Seen at 89.9 degrees, a footprint grows without bound; the smallest cosine, 0.05, bounds the disc.
#[test]
fn grazing_footprints_are_finite_and_bounded() {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.5));
    let mirror = b.material(metal(1.0, 0.0));
    b.panel(floor, DVec3::ZERO, 1000.0 * DVec3::Z, 1000.0 * DVec3::X);
    b.panel(mirror, DVec3::new(0.0, 5.0, -30.0), 20.0 * DVec3::X, 4.0 * DVec3::Y);
    b.light(DVec3::new(0.0, 6.0, -10.0), 100.0);
    b.camera(DVec3::new(0.0, 0.01, 0.0), DVec3::new(0.0, 0.0, -5.0), 0.01);
    let scene = b.build();
    let radius_px = 30.0;
    let config = RenderConfig {
        width: 32,
        height: 32,
        light_paths: Paths::Count(100_000),
        radius: Radius::Px(radius_px),
        ..RenderConfig::default()
    };
    let (image, counters) = frame(&scene, &config);
    assert_sound(&image, &counters);
    assert!(mean_of(&image.caustics) > 0.0, "the test scene has no caustics");
    let world = World::new(&scene, &config);
    let mut grazing = 0;
    for collected in world.collect().iter().filter(|c| c.point.geometry.depth == 1) {
        let geometry = collected.point.geometry;
        let distance = (geometry.position - world.params.camera.position).length();
        let cos = collected.point.shading.to_viewer.dot(geometry.normal);
        let bound = radius_px * distance * world.params.pixel_spread * (1.0 / (0.05 * PI)).sqrt() * 1.0001;
        let ulps = geometry.position.abs().max_element() * (4.0 / 8_388_608.0);
        assert!(geometry.radius <= bound.max(ulps), "{geometry:?}: {bound}");
        grazing += u32::from(cos < 0.002);
    }
    println!("{grazing} points are seen at less than 0.12 degrees; caustics {:.4}", mean_of(&image.caustics));
    assert!(grazing > 100, "the test has nothing to check");
}

/// Without a light, caster, receiver, object in sight or light path, the layer is black to the bit.
#[test]
fn missing_light_caster_or_receiver_leaves_its_layer_black() {
    let black = |layer: &[Vec3]| layer.iter().all(|value| *value == Vec3::ZERO);
    let config =
        RenderConfig { width: 32, height: 24, light_paths: Paths::Count(20_000), ..RenderConfig::default() };
    let scene = |lit: bool, caster: Material, wall: Material, eye: DVec3| {
        let mut b = Builder::default();
        let (wall, caster) = (b.material(wall), b.material(caster));
        b.panel(wall, DVec3::ZERO, 2.0 * DVec3::Z, 2.0 * DVec3::X);
        b.panel(caster, DVec3::new(0.0, 1.0, -1.0), DVec3::X, DVec3::Y);
        if lit {
            b.light(DVec3::new(0.0, 1.5, 0.5), 3.0);
        }
        b.camera(eye, eye + DVec3::new(0.0, -1.0, -0.1), 0.7);
        b.build()
    };
    let (mirror, grey, above) = (metal(1.0, 0.0), lambert(0.5), DVec3::new(0.0, 3.0, 0.5));
    let whole = frame(&scene(true, mirror, grey, above), &config);
    assert!(mean_of(&whole.0.caustics) > 0.0 && mean_of(&whole.0.path) > 0.0);

    // Columns: the missing part; whether direct light is left; whether light paths are traced.
    let none = RenderConfig { light_paths: Paths::Count(0), ..config.clone() };
    let cases = [
        ("light", scene(false, mirror, grey, above), &config, false, false),
        ("caster", scene(true, grey, grey, above), &config, true, false),
        ("receiver", scene(true, mirror, mirror, above), &config, false, false),
        ("thing in sight", scene(true, mirror, grey, -above), &config, false, true),
        ("light path", scene(true, mirror, grey, above), &none, true, false),
    ];
    for (missing, scene, config, direct, shot) in cases {
        let (image, counters) = frame(&scene, config);
        assert_sound(&image, &counters);
        assert!(black(&image.caustics), "no {missing}");
        assert_eq!(black(&image.path), !direct, "no {missing}");
        assert_eq!(counters.get(Counter::LightPaths) > 0, shot, "no {missing}");
    }
}

/// A floor that fills a tenth of the image: its pixels have their usual brightness, the others are black.
#[test]
fn pixels_without_a_collection_point_stay_black() {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.5));
    let mirror = b.material(metal(1.0, 0.0));
    b.panel(floor, DVec3::ZERO, 0.25 * DVec3::Z, 0.25 * DVec3::X);
    b.panel(mirror, DVec3::new(0.0, 1.0, -1.0), DVec3::X, DVec3::Y);
    b.light(DVec3::new(0.0, 1.5, 0.5), 3.0);
    b.camera(DVec3::new(0.0, 2.0, 0.0), DVec3::ZERO, 0.76);
    let config =
        RenderConfig { width: 64, height: 64, light_paths: Paths::Count(400_000), ..RenderConfig::default() };
    let (image, counters) = frame(&b.build(), &config);
    assert_sound(&image, &counters);
    let there = image.depth.iter().filter(|depth| **depth > 0.0).count() as f64 / 4096.0;
    println!("{:.1} % of the pixels have a point", 100.0 * there);
    assert!(there > 0.05 && there < 0.11);
    for (pixel, depth) in image.depth.iter().enumerate() {
        if *depth == 0.0 {
            assert_eq!((image.caustics[pixel], image.radius[pixel]), (Vec3::ZERO, 0.0));
        }
    }
    assert!(mean_of(&image.caustics) / there > 1e-2);
}

/// A ball under a directional light on a floor of +- 300 m gets four in 10^6 of the light paths. On a floor of +- 3 m
/// it gets one in fifty. Light paths start over all of the floor. Only the first gives a warning, and no committed
/// scene does.
#[test]
fn caustics_of_too_few_photons_give_a_warning() {
    let on_floor = |half: f64| {
        let mut b = Builder::default();
        let (floor, ball) = (b.material(lambert(0.6)), b.material(glass(1.5)));
        b.panel(floor, DVec3::ZERO, half * DVec3::Z, half * DVec3::X);
        b.sphere(ball, 0.8 * DVec3::Y, 0.5, 32, 16);
        b.directional(DVec3::new(0.1, -1.0, 0.2), 1.0);
        b.camera(DVec3::new(0.0, 2.0, 3.0), DVec3::ZERO, 0.7);
        b.build()
    };
    let config =
        RenderConfig { width: 16, height: 9, light_paths: Paths::Count(1 << 16), ..RenderConfig::default() };
    let warnings = frame(&on_floor(300.0), &config).1.warnings();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(
        ["starve", "of 65536 light paths", "--light-paths", "bounds"]
            .iter()
            .all(|word| warnings[0].contains(word))
    );
    assert_eq!(frame(&on_floor(3.0), &config).1.warnings(), [""; 0]);
    // Few light paths may all miss at random.
    let few = RenderConfig { light_paths: Paths::Count(1000), ..config.clone() };
    assert_eq!(frame(&on_floor(300.0), &few).1.warnings(), [""; 0]);

    for name in caustics_scenes::NAMES {
        let counters = frame(&committed(name), &config).1;
        let (paths, photons) = (counters.get(Counter::LightPaths), counters.get(Counter::Photons));
        println!("{name}: {photons} photons of {paths} light paths");
        if name == "uplight" {
            // The first surface that its light meets is matte.
            assert!(counters.warnings()[0].contains("--caustics any"));
            let any = RenderConfig { caustics: Caustics::Any, ..config.clone() };
            assert_eq!(frame(&committed(name), &any).1.warnings(), [""; 0]);
            continue;
        }
        // Ten times the share that gives a warning.
        assert!(photons * 1000 >= paths, "{name}");
        assert_eq!(counters.warnings(), [""; 0], "{name}");
    }
}
