//! Media: where solids overlap, the medium of the highest priority counts; where a surface is open, the light does not
//! depend on the viewer's position.

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::interface::choice::PixelFilter;
use caustics_kernels::interface::counters::Counter;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::material::{FLAG_HANGING, Material};
use caustics_kernels::interface::point::{PhotonGeometry, PhotonLight};
use caustics_kernels::interface::ray::Ray;
use caustics_kernels::light::emit::EmissionSample;
use caustics_kernels::math::cone::RayCone;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::method::path::PATH;
use caustics_kernels::pass::shoot;
use caustics_kernels::path::camera_path::CameraSuffix;
use caustics_kernels::path::camera_ray::CameraPathStart;
use caustics_kernels::path::photon_sink::PhotonSink;
use caustics_kernels::surface::media::MediaStack;
use caustics_kernels::trace::initial_media::initial_media_stack;
use caustics_tests::collected::collected;
use caustics_tests::direct::{Tally, World};
use caustics_tests::scenes::*;
use caustics_tests::statistics::Mean;
use glam::{DVec3, Vec3};

const CPU: RunnerChoice = RunnerChoice::Cpu { threads: 0 };

/// A medium of this index and priority.
fn medium(ior: f32, priority: i32) -> Material {
    Material { priority, ..glass(ior) }
}

/// A medium that absorbs red the least [1/m].
fn tinted(ior: f32, priority: i32, sigma: f32) -> Material {
    Material { absorption: sigma * Vec3::new(0.5, 1.0, 2.0), ..medium(ior, priority) }
}

/// Glass over water on y = -1 to 1. The glass reaches down to `bottom`, the water up to `top`.
fn plates(glass: Material, water: Material, bottom: f64, top: f64) -> Builder {
    let mut b = Builder::default();
    let (glass, water) = (b.material(glass), b.material(water));
    b.block(glass, DVec3::new(-20.0, bottom, -20.0), DVec3::new(20.0, 1.0, 20.0), false);
    b.block(water, DVec3::new(-21.0, -1.0, -21.0), DVec3::new(21.0, top, 21.0), false);
    b
}

/// A view ray at 45 degrees through overlapping plates meets the floor where a single interface of glass and water
/// would send it. This holds whichever medium has priority.
#[test]
fn overlapping_plates_refract_once() {
    for overlap in [0.001, 0.01, 0.1] {
        for (of_glass, of_water) in [(1, 0), (0, 1)] {
            let (bottom, top) = (-0.5 * overlap, 0.5 * overlap);
            let mut b = plates(medium(1.5, of_glass), medium(1.33, of_water), bottom, top);
            let floor = b.material(emitter(1.0));
            b.panel(floor, DVec3::new(0.0, -3.0, 0.0), 20.0 * DVec3::Z, 20.0 * DVec3::X);
            b.camera(DVec3::new(-2.0, 3.0, 0.0), DVec3::new(0.0, 1.0, 0.0), 1e-4);
            let scene = b.build();
            let config = RenderConfig { max_bounces: 5, ..config(8, 8) };
            let seen = World::new(&scene, &config).collect();
            let on_floor =
                seen.iter().map(|path| path.point.geometry.position).filter(|position| position.y < -2.9);
            let mut on_floor: Vec<_> = on_floor.map(|position| f64::from(position.x)).collect();
            assert!(on_floor.len() > 40, "{}", on_floor.len());
            // Most of 64 paths are refracted and end at one position; few are reflected.
            on_floor.sort_by(f64::total_cmp);
            let seen = on_floor[on_floor.len() / 2];
            let tan = |ior: f64| {
                let sin = 0.5f64.sqrt() / ior;
                sin / (1.0 - sin * sin).sqrt()
            };
            let split = if of_glass > of_water { bottom } else { top };
            let expected = (1.0 - split) * tan(1.5) + (split + 1.0) * tan(1.33) + 2.0;
            println!("overlap {overlap} m, of glass {of_glass}: {seen} m, by one interface {expected} m");
            // 1e-4 of view over 5 m.
            assert!((seen - expected).abs() < 1e-3);
        }
    }
}

/// White furnace: any stack of plates in a room of radiance 1 shows 1. Where faces coincide, rounding loses one of
/// them: no path gains light, and the loss is counted.
#[test]
fn stack_of_plates_in_a_furnace_of_radiance_1_shows_at_most_1() {
    for (bottom, top, coincide) in [(-0.05, 0.05, false), (-0.0005, 0.0005, false), (0.0, 0.0, true)] {
        let mut b = plates(medium(1.5, 0), medium(1.33, 0), bottom, top);
        let sky = b.material(emitter(1.0));
        b.block(sky, DVec3::splat(-30.0), DVec3::splat(30.0), true);
        b.camera(DVec3::new(-2.0, 4.0, 0.5), DVec3::new(0.0, 1.0, 0.0), 1.2);
        let scene = b.build();
        let config = RenderConfig { max_bounces: 60, ..config(48, 32) };
        let features = scene.features(0.25);
        let mut session = Session::new(
            &CPU,
            &scene,
            &scene.cameras[0],
            &RenderConfig { method: &PATH, ..config.clone() },
            features,
        )
        .expect("a session opens");
        session.frame(0).expect("a frame runs");
        let radiance: Vec<f32> = session.image().expect("an image").path.iter().map(|v| v.x).collect();
        let max_radiance = radiance.iter().copied().fold(0.0, f32::max);
        let mean = radiance.iter().sum::<f32>() / radiance.len() as f32;
        let unexpected = session.counters().expect("counters").get(Counter::UnexpectedFaces);
        println!("from {bottom} to {top}: mean {mean}, at most {max_radiance}, unexpected {unexpected}");
        // f32 through some ten interfaces.
        assert!(max_radiance < 1.0 + 1e-5, "{max_radiance}");
        assert_eq!(unexpected > 0, coincide);
        if !coincide {
            assert!(mean > 0.999, "{mean}");
        }
    }
}

/// A bottle is a glass shell full of water. Water that overlaps the glass looks like water that fills a hole of a
/// block, which needs no overlap.
#[test]
fn water_that_overlaps_a_bottle_looks_like_water_in_a_hole() {
    let cavity = DVec3::new(0.5, 0.7, 0.4);
    let build = |explicit: bool| {
        let mut b = Builder::default();
        // Priorities decide, not ids.
        let water = b.material(tinted(1.33, if explicit { 1 } else { 0 }, 0.5));
        let glass = b.material(tinted(1.5, if explicit { 0 } else { 1 }, 0.2));
        let wall = b.material(lambert(0.5));
        b.block(wall, DVec3::splat(-2.0), DVec3::splat(2.0), true);
        b.light(DVec3::new(0.3, 1.7, 0.4), 4.0);
        b.block(glass, -cavity - 0.1, cavity + 0.1, false);
        if explicit {
            b.block(water, -cavity, cavity, false);
        } else {
            b.block(glass, -cavity, cavity, true);
            b.block(water, -cavity - 0.04, cavity + 0.04, false);
        }
        b.camera(DVec3::new(0.3, 0.6, 1.9), DVec3::ZERO, 0.9);
        b.build()
    };
    let config = RenderConfig { max_bounces: 8, light_paths: Paths::Count(20_000), ..config(48, 36) };
    let frame = |scene: &Scene| {
        let features = scene.features(0.25);
        let mut session =
            Session::new(&CPU, scene, &scene.cameras[0], &config, features).expect("a session opens");
        session.frame(0).expect("a frame runs");
        let counters = session.counters().expect("counters");
        // At edges, by rounding: few of some 60,000 segments.
        assert!(counters.get(Counter::UnexpectedFaces) <= 3 && counters.get(Counter::MediaOverflow) == 0);
        session.image().expect("an image").beauty()
    };
    let (overlapping, explicit) = (frame(&build(false)), frame(&build(true)));
    let sum = |image: &[Vec3]| image.iter().map(|v| f64::from(v.element_sum())).sum::<f64>();
    let ratio = sum(&overlapping) / sum(&explicit);
    let close = |(a, b): (&Vec3, &Vec3)| (*a - *b).abs().max_element() <= 1e-2 * b.max_element();
    let same = overlapping.iter().zip(&explicit).filter(|&pair| close(pair)).count();
    let share = same as f64 / explicit.len() as f64;
    println!("overlapping / explicit {ratio:.5}, pixels within 1 %: {share:.4}");
    // Both sample the same numbers; rounding sends few paths elsewhere.
    assert!((ratio - 1.0).abs() < 2e-3 && share > 0.97);
}

/// Without a priority in the file the smaller solid wins; a priority in the file overrides that.
#[test]
fn smaller_solid_has_priority_unless_the_file_sets_one() {
    let half = |x: f64| DVec3::splat(x);
    let build = |ice_priority: i32| {
        let mut b = Builder::default();
        let bubble = b.material(glass(1.0));
        let cup = b.material(glass(1.5));
        let water = b.material(glass(1.33));
        let ice = b.material(medium(1.31, ice_priority));
        // A cup of five walls that the water overlaps, and many pieces of ice with as much volume as the cup in all.
        b.block(cup, half(-1.0), half(1.0), false);
        b.block(cup, half(-0.9), half(0.9), true);
        b.block(water, half(-0.91), DVec3::new(0.91, 0.5, 0.91), false);
        for piece in 0..9 {
            let at = DVec3::new(2.5 * f64::from(piece), 0.4, 0.0);
            b.block(ice, at - 0.45, at + 0.45, false);
        }
        b.sphere(bubble, DVec3::new(0.0, -0.95, 0.0), 0.02, 16, 8);
        let light = b.material(emitter(1.0));
        b.panel(light, 3.0 * DVec3::Y, DVec3::X, DVec3::Z);
        b.camera(4.0 * DVec3::Z, DVec3::ZERO, 0.5);
        b.build()
    };
    let order = |scene: &Scene| {
        let mut ids = [0, 1, 2, 3];
        ids.sort_by_key(|&id| scene.materials[id].priority);
        ids
    };
    let scene = build(0);
    assert_eq!(order(&scene), [1, 2, 3, 0], "cup < water < ice < bubble");
    assert!(scene.warnings.is_empty() && scene.features(0.25).has(Features::NESTED), "{:?}", scene.warnings);
    assert_eq!(order(&build(-1)), [3, 1, 2, 0]);
}

/// In a room with two overlapping absorbing blocks, a light path from one wall to another has the throughput of the
/// reversed camera path.
#[test]
fn light_path_and_reversed_camera_path_have_equal_throughput() {
    let mut b = Builder::default();
    let wall = b.material(lambert(0.5));
    let (one, other) = (b.material(tinted(1.5, 0, 1.0)), b.material(tinted(1.33, 0, 2.0)));
    b.block(wall, DVec3::splat(-2.0), DVec3::splat(2.0), true);
    b.block(one, DVec3::new(-0.8, -0.5, -0.6), DVec3::new(0.3, 0.6, 0.5), false);
    b.block(other, DVec3::new(-0.2, -0.7, -0.5), DVec3::new(0.7, 0.4, 0.6), false);
    b.light(DVec3::new(0.0, 1.9, 0.0), 1.0);
    b.camera(DVec3::new(0.0, 0.0, 1.9), DVec3::ZERO, 0.5);
    let scene = b.build();
    let world = World::new(&scene, &RenderConfig { max_bounces: 12, ..config(1, 1) });
    let mut compared = 0;
    for index in 0..400 {
        let mut rng = Rng::new(Stream::Camera, 5, index, 0);
        let u = rng.next4() - 0.5;
        let target = Vec3::new(u.x, 0.8 * u.y, 0.8 * u.z);
        let origin = Vec3::new(3.0 * u.w, 1.99, 2.0 * u.x);
        let ray = Ray::endless(origin, (target - origin).normalize());
        let mut last = Last::default();
        let params = caustics_kernels::interface::frame::FrameParams { light_path_count: 1, ..world.params };
        let mut tracer = world.tracer();
        let emit = Single(ray);
        shoot::shoot(
            index,
            &params,
            world.features,
            world.tables(),
            &emit,
            &mut tracer,
            &mut last,
            &mut Tally::default(),
        );
        let Some((at, light)) = last.0 else { continue };
        let forth = light.flux * light.to_light.dot(at.normal);
        // Trace back along the light; sample lobes anew until the path is the same.
        let back = Ray::endless(at.position + 1e-4 * light.to_light, light.to_light);
        let same = (0..64).find_map(|attempt| {
            let rng = Rng::new(Stream::Reference, 6, attempt, index);
            let cone = RayCone::at_eye(0.001);
            let path = collected(
                CameraPathStart { ray: back, cone, rng },
                CameraSuffix::new(&world.params),
                &world.params,
                world.features,
                world.tables(),
                &mut tracer,
                &mut Tally::default(),
            );
            let arrived = (path.point.geometry.position - origin).length() < 2e-2;
            (arrived && path.point.geometry.depth == at.scatterings + 1)
                .then_some(path.point.shading.throughput)
        });
        if let Some(back) = same {
            let off = ((forth - back) / back).abs().max_element();
            // f32 over some ten faces that are metres from the origin.
            assert!(off < 2e-3, "path {index}: {forth} there, {back} back over {}", at.scatterings);
            compared += 1;
        }
    }
    println!("{compared} paths");
    assert!(compared > 100, "{compared}");
}

/// Emission of one given ray.
struct Single(Ray);

impl caustics_kernels::light::emit::Emit for Single {
    fn sample(&self, _rng: &mut Rng) -> EmissionSample {
        EmissionSample { area: 1.0, ..EmissionSample::new(self.0, Vec3::ONE, 0.0) }
    }
}

/// Sink that keeps the first photon of a path.
#[derive(Default)]
struct Last(Option<(PhotonGeometry, PhotonLight)>);

impl PhotonSink for Last {
    type PathState = ();

    fn store_photon(&mut self, _path_state: &mut (), geometry: PhotonGeometry, light: PhotonLight) {
        self.0.get_or_insert((geometry, light));
    }
}

/// A light in water reaches the floor through glass that the water covers.
#[test]
fn direct_light_passes_glass_covered_by_water() {
    let seen = |covered: bool| {
        let mut b = Builder::default();
        let floor = b.material(lambert(0.5));
        let water = b.material(tinted(1.33, 1, 1.0));
        let glass = b.material(medium(1.5, 0));
        b.block(water, DVec3::new(-2.0, -0.5, -2.0), DVec3::new(2.0, 1.0, 2.0), false);
        if covered {
            b.block(glass, DVec3::new(-1.0, 0.2, -1.0), DVec3::new(1.0, 0.7, 1.0), false);
        }
        b.panel(floor, DVec3::ZERO, 1.5 * DVec3::Z, 1.5 * DVec3::X);
        b.light(DVec3::new(0.0, 0.8, 0.0), 1.0);
        b.camera(DVec3::new(0.0, 4.0, 0.0), DVec3::ZERO, 0.1);
        let scene = b.build();
        let config = RenderConfig { max_bounces: 3, ..config(16, 16) };
        World::new(&scene, &config).collect().iter().map(|path| path.light.radiance.as_dvec3()).sum::<DVec3>()
    };
    let (covered, open) = (seen(true), seen(false));
    // Clearances of 16 ulp at two faces, and their absorption.
    assert!(open.x > 0.0 && ((covered - open) / open).abs().max_element() < 1e-4, "{covered} {open}");
}

/// A position is inside a medium that winds around it by more than half. Around an open surface no position is,
/// whichever way it faces.
#[test]
fn no_position_around_an_open_surface_is_inside() {
    let mut open = 0;
    for index in 0..200 {
        let mut rng = Rng::new(Stream::Camera, 9, index, 0);
        let (u, v) = (rng.next4() - 0.5, rng.next4() - 0.5);
        let mut b = Builder::default();
        let water = b.material(medium(1.33, 0));
        let right = DVec3::new(u.x.into(), u.y.into(), u.z.into()).normalize();
        b.panel(water, DVec3::ZERO, right, right.any_orthonormal_vector());
        b.camera(DVec3::Z, DVec3::ZERO, 0.5);
        b.light(DVec3::Y, 1.0);
        let scene = b.build();
        open += scene.warnings.len();
        let features = scene.features(0.25) | Features::STARTS_IN_MEDIUM;
        let mut tracer = scene.tracer(features);
        let around = initial_media_stack(0.3 * v.truncate(), features, scene.tables(), &mut tracer);
        assert_eq!(around, MediaStack::VACUUM, "{index}");
    }
    assert_eq!(open, 200, "an open medium is named");
}

/// An aquarium without a lid holds its water; above it there is none.
#[test]
fn box_without_a_lid_has_an_inside() {
    let mut b = Builder::default();
    let water = b.material(medium(1.33, 0));
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            if (axis, sign) != (1, 1.0) {
                let unit = |axis: usize| DVec3::AXES[axis % 3];
                b.panel(water, sign * unit(axis), sign * unit(axis + 1), unit(axis + 2));
            }
        }
    }
    b.camera(4.0 * DVec3::Z, DVec3::ZERO, 0.5);
    b.light(4.0 * DVec3::Y, 1.0);
    let scene = b.build();
    let features = scene.features(0.25) | Features::STARTS_IN_MEDIUM;
    let mut tracer = scene.tracer(features);
    let mut is_inside =
        |position: Vec3| initial_media_stack(position, features, scene.tables(), &mut tracer).holds(water);
    for index in 0..200 {
        let u = Rng::new(Stream::Camera, 10, index, 0).next4() - 0.5;
        let position = Vec3::new(1.8 * u.x, 1.2 * u.y - 0.3, 1.8 * u.z);
        assert!(is_inside(position), "{position}");
        assert!(!is_inside(position + 2.5 * Vec3::Y) && !is_inside(position + 3.0 * Vec3::X), "{position}");
    }
}

/// Positions below the surface of a pool are in its water, and so is a camera there. An open surface that leaves a way
/// round its border hangs, and no position is in it.
#[test]
fn pool_has_an_inside_and_a_hanging_open_surface_has_none() {
    let scene = pool(DVec3::new(0.2, 0.5, 0.9), DVec3::NEG_Y).build();
    let hangs = |scene: &Scene| scene.materials[0].flags & FLAG_HANGING != 0;
    assert!(!hangs(&scene));
    let features = scene.features(0.25);
    assert!(!features.has(Features::STARTS_IN_MEDIUM));
    let mut tracer = scene.tracer(features);
    for index in 0..200 {
        let u = 1.9 * (Rng::new(Stream::Camera, 11, index, 0).next4() - 0.5);
        let inside =
            initial_media_stack(Vec3::new(u.x, u.y, u.z), features, scene.tables(), &mut tracer).holds(0);
        assert_eq!(inside, u.y < 0.0, "{u}");
    }
    let diver = pool(DVec3::new(0.2, -0.5, 0.9), DVec3::ZERO).build();
    assert!(diver.features(0.25).has(Features::STARTS_IN_MEDIUM));

    let mut b = Builder::default();
    let water = b.material(tinted(1.33, 0, 1.0));
    let concrete = b.material(lambert(0.5));
    b.block(concrete, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.panel(water, DVec3::ZERO, 0.6 * DVec3::Z, 0.6 * DVec3::X);
    b.light(0.9 * DVec3::Y, 1.0);
    b.camera(DVec3::new(0.0, -0.2, 0.0), DVec3::NEG_Y, 0.9);
    let scene = b.build();
    assert!(hangs(&scene) && scene.warnings[0].contains("round its border"), "{:?}", scene.warnings);
    assert!(!scene.features(0.25).has(Features::STARTS_IN_MEDIUM));
}

/// A block whose fronts look inwards does not fill the room around it.
#[test]
fn block_with_inward_fronts_has_no_inside() {
    let mut b = Builder::default();
    let (wall, turned) = (b.material(lambert(0.5)), b.material(tinted(1.5, 0, 1.0)));
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.block(turned, DVec3::splat(-0.3), DVec3::splat(0.3), true);
    b.light(0.9 * DVec3::Y, 1.0);
    b.camera(0.9 * DVec3::Z, DVec3::ZERO, 0.9);
    let scene = b.build();
    assert!(scene.warnings[0].contains("look inwards"), "{:?}", scene.warnings);
    let features = scene.features(0.25);
    let mut tracer = scene.tracer(features);
    for index in 0..100 {
        let u = 1.9 * (Rng::new(Stream::Camera, 12, index, 0).next4() - 0.5);
        let around = initial_media_stack(u.truncate(), features, scene.tables(), &mut tracer);
        assert_eq!(around, MediaStack::VACUUM, "{u}");
    }
}

/// A floor under an open surface of tinted water that hangs in the air, and a camera below the surface that looks at
/// the floor.
fn under_an_open_surface(eye: DVec3, view: f32) -> Scene {
    let mut b = Builder::default();
    let water = b.material(tinted(1.33, 0, 2.0));
    let floor = b.material(lambert(0.5));
    let light = b.material(emitter(20.0));
    b.panel(floor, DVec3::NEG_Y, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    b.panel(water, DVec3::new(0.1, 0.0, 0.2), 0.9 * DVec3::Z, 0.9 * DVec3::X);
    b.panel(light, DVec3::new(0.0, 2.0, 0.0), 0.5 * DVec3::X, 0.5 * DVec3::Z);
    b.camera(eye, DVec3::new(0.0, -1.0, 0.0), view);
    b.build()
}

/// Mean of all pixels, and its error over the frames.
fn mean_of(scene: &Scene, seed: u32, progressive: bool, frames: u32) -> [Mean; 3] {
    let config = RenderConfig {
        seed,
        light_paths: Paths::Count(8000),
        pixel_filter: PixelFilter::Box,
        ..config(24, 18)
    };
    let method = if progressive { &caustics_kernels::method::progressive::PROGRESSIVE } else { &PATH };
    let features = scene.features(0.25);
    let mut session =
        Session::new(&CPU, scene, &scene.cameras[0], &RenderConfig { method, ..config.clone() }, features)
            .expect("a session opens");
    let mut sums = [const { Vec::new() }; 3];
    for frame in 0..frames {
        session.frame(frame).expect("a frame runs");
        let beauty = session.image().expect("an image").beauty();
        for (channel, sums) in sums.iter_mut().enumerate() {
            sums.push(beauty.iter().map(|v| f64::from(v[channel])).sum::<f64>());
        }
    }
    sums.map(|sums| Mean::from_samples(&sums))
}

#[test]
fn hue_under_an_open_surface_is_equal_from_five_positions() {
    let hues: Vec<f64> = [-0.2, -0.1, 0.0, 0.1, 0.2]
        .map(|x| {
            // So narrow that no position in view sees the light past the open surface.
            let scene = under_an_open_surface(DVec3::new(x, -0.3, 0.6 + x), 0.4);
            let [red, _, blue] = mean_of(&scene, 1, false, 60);
            red.value / blue.value
        })
        .into();
    println!("red over blue: {hues:?}");
    let (low, high) = hues.iter().fold((f64::MAX, 0.0f64), |(low, high), &hue| (low.min(hue), high.max(hue)));
    // Noise of 60 frames is about 3 %.
    assert!(high / low < 1.2, "{hues:?}");
}

#[test]
fn progressive_and_reference_agree_under_an_open_surface() {
    let scene = under_an_open_surface(DVec3::new(0.1, -0.3, 0.7), 0.7);
    let (split, reference) = (mean_of(&scene, 2, true, 120), mean_of(&scene, 3, false, 900));
    for channel in 0..3 {
        let (split, reference) = (&split[channel], &reference[channel]);
        println!("{split:?} {reference:?}: {:.4}", split.value / reference.value);
        assert!(split.agrees(reference, 3.5), "channel {channel}");
        assert!(split.error.hypot(reference.error) < 0.02 * reference.value, "the test is noisy");
    }
}

fn config(width: u32, height: u32) -> RenderConfig {
    RenderConfig { width, height, light_paths: Paths::Count(1), ..RenderConfig::default() }
}
