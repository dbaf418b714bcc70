//! Light through thin smooth walls: light samples and paths pass them by their closed form, and no light is lost or counted twice.

use caustics::render_config::{Paths, Radius, RenderConfig};
use caustics::scene::{EnvironmentMap, Scene};
use caustics::session::RunnerChoice;
use caustics_kernels::emission::{GUIDED, POWER};
use caustics_kernels::gather::variant::PHOTONS_GRID;
use caustics_kernels::interface::choice::{PixelFilter, ThinWalls};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::material::{FLAG_EMIT_BOTH_SIDES, FLAG_THIN, Material};
use caustics_kernels::method::Method;
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::method::path::PATH;
use caustics_kernels::method::progressive::PROGRESSIVE;
use caustics_tests::blocks::Blocks;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};

/// Transmittance of a pane of index 1.5 at normal incidence: (1 - r) / (1 + r) with r = 0.04.
const PASSED: f64 = 0.96 / 1.04;

fn config(max_bounces: u32, seed: u32) -> RenderConfig {
    RenderConfig {
        width: 48,
        height: 32,
        max_bounces,
        seed,
        light_paths: Paths::Count(30_000),
        radius: Radius::Px(1.0),
        emission: &GUIDED,
        pixel_filter: PixelFilter::Box,
        ..RenderConfig::default()
    }
}

fn blocks(scene: &Scene, config: &RenderConfig, method: &'static Method, frames: u32) -> Blocks {
    // Path tracing has no emission of light paths to choose.
    let emission = if method.chooses_emission { config.emission } else { &POWER };
    let config = RenderConfig { emission, ..config.clone() };
    Blocks::render(&RunnerChoice::Cpu { threads: 0 }, scene, &config, method, &PHOTONS_GRID, frames)
}

fn horizontal(builder: &mut Builder, material: Material, height: f64, half: f64, down: bool) {
    let material = builder.material(material);
    let side = if down { -1.0 } else { 1.0 };
    builder.panel(material, height * DVec3::Y, side * half * DVec3::X, -half * DVec3::Z);
}

/// A floor that is seen from below the walls over it.
fn floor() -> Builder {
    let mut builder = Builder::default();
    horizontal(&mut builder, lambert(0.5), 0.0, 0.4, false);
    builder.camera(DVec3::new(0.0, 0.5, 0.6), DVec3::ZERO, 0.6);
    builder
}

/// Adds a light; all its rays to the floor are within 2 degrees of the normals of walls.
type AddLight = fn(&mut Builder);

const LIGHTS: [(&str, AddLight); 3] = [
    ("emitter", |builder| horizontal(builder, emitter(1e4), 40.0, 0.2, true)),
    ("point light", |builder| builder.light(DVec3::new(0.0, 40.0, 0.0), 1e3)),
    ("sun", |builder| builder.directional(-DVec3::Y, 1.0)),
];

/// With one bounce, the floor shows direct light alone: what walls reflect takes two.
#[test]
fn direct_light_through_walls_has_its_closed_form() {
    let tinted = Material { base_color: Vec3::splat(0.5), ..pane(1.5) };
    let half_glass = Material { transmission: 0.5, ..pane(1.5) };
    let walls: [(&str, &[Material], f64); 4] = [
        ("one pane", &[pane(1.5)], PASSED),
        ("two panes", &[pane(1.5), pane(1.5)], PASSED * PASSED),
        ("a tinted pane", &[tinted], 0.5 * PASSED),
        ("half a pane", &[half_glass], 0.5 * PASSED),
    ];
    for (light, add_light) in LIGHTS {
        let scene = |walls: &[Material]| {
            let mut builder = floor();
            add_light(&mut builder);
            for (index, wall) in walls.iter().enumerate() {
                horizontal(&mut builder, *wall, 1.0 + 0.2 * index as f64, 4.0, false);
            }
            builder.build()
        };
        for method in [&PATH, &BASIC] {
            let open = blocks(&scene(&[]), &config(1, 1), method, 16).whole();
            for (name, walls, expected) in walls {
                let passed = blocks(&scene(walls), &config(1, 1), method, 16).whole();
                let ratio = passed.value / open.value;
                assert!((ratio / expected - 1.0).abs() < 0.002, "{light}, {name}, {}: {ratio}", method.name);
            }
        }
    }
}

/// Transmittance of a pane of index 1.5 at a cosine of incidence [Fresnel].
fn transmittance(cos: f64) -> f64 {
    let inside = (1.0 - (1.0 - cos * cos) / 2.25).sqrt();
    let (s, p) = ((cos - 1.5 * inside) / (cos + 1.5 * inside), (inside - 1.5 * cos) / (inside + 1.5 * cos));
    let r = 0.5 * (s * s + p * p);
    (1.0 - r) / (1.0 + r)
}

/// A wide wall has large coordinates, and so a large clearance. Light from behind it must not be lost where a small emitter lies
/// closer than the wall's clearance moves a ray.
#[test]
fn light_close_behind_a_wide_wall_has_its_closed_form() {
    for degrees in [0.0f64, 40.0, 70.0] {
        let scene = |with_wall: bool| {
            let mut builder = floor();
            let center = DVec3::new(40.0 * degrees.to_radians().tan(), 40.0, 0.0);
            let light = builder.material(emitter(1e4));
            builder.panel(light, center, -0.2 * DVec3::X, -0.2 * DVec3::Z);
            if with_wall {
                horizontal(&mut builder, pane(1.5), 39.99, 2000.0, false);
            }
            builder.build()
        };
        let open = blocks(&scene(false), &config(1, 1), &PATH, 16).whole();
        let passed = blocks(&scene(true), &config(1, 1), &PATH, 16).whole();
        let (ratio, expected) = (passed.value / open.value, transmittance(degrees.to_radians().cos()));
        assert!((ratio / expected - 1.0).abs() < 0.002, "{degrees}: {ratio}, expected {expected}");
    }
}

/// Under a sky of one radiance, walls pass the mean of their transmittance over the cosine of incidence.
#[test]
fn sky_light_through_walls_has_its_closed_form() {
    // Integrate over the cosine by midpoints
    let mean = |walls: i32| {
        let steps = 10_000;
        let cosines = (0..steps).map(|step| (f64::from(step) + 0.5) / f64::from(steps));
        cosines.map(|cos| 2.0 * cos * transmittance(cos).powi(walls)).sum::<f64>() / f64::from(steps)
    };
    let scene = |walls: &[Material]| {
        let mut builder = floor();
        // Fill the image: the sky is seen directly beside a floor.
        horizontal(&mut builder, lambert(0.5), -0.01, 50.0, false);
        for (index, wall) in walls.iter().enumerate() {
            // As good as endless: the floor sees a thousandth of the sky beside them.
            horizontal(&mut builder, *wall, 1.0 + 0.01 * index as f64, 1000.0, false);
        }
        let mut scene = builder.build();
        scene.set_environment(EnvironmentMap::new(1, 1, vec![Vec3::ONE])).expect("a sky");
        scene
    };
    let tinted = Material { base_color: Vec3::splat(0.5), ..pane(1.5) };
    let cases: [(&str, &[Material], f64); 3] = [
        ("one pane", &[pane(1.5)], mean(1)),
        ("two panes", &[pane(1.5), pane(1.5)], mean(2)),
        ("a tinted pane", &[tinted], 0.5 * mean(1)),
    ];
    for method in [&PATH, &BASIC] {
        let open = blocks(&scene(&[]), &config(1, 1), method, 128).whole();
        for (name, walls, expected) in cases {
            let passed = blocks(&scene(walls), &config(1, 1), method, 128).whole();
            let ratio = passed.value / open.value;
            let error = passed.error.hypot(open.error * ratio) / open.value;
            println!("{name}, {}: {ratio:.5} +- {error:.5}, expected {expected:.5}", method.name);
            let is_close = (ratio - expected).abs() < 3.0 * error + 0.001;
            assert!(error < 0.002 && is_close, "{name}, {}", method.name);
        }
    }
}

/// A lamp behind a pane, a glass ball between two panes, and a mirror that shows the floor.
fn window() -> Scene {
    let mut builder = Builder::default();
    horizontal(&mut builder, lambert(0.4), 0.0, 3.0, false);
    horizontal(&mut builder, emitter(10.0), 2.4, 0.9, true);
    horizontal(&mut builder, pane(1.5), 1.8, 2.0, false);
    let ball = builder.material(glass(1.5));
    builder.sphere(ball, DVec3::new(0.0, 1.2, 0.0), 0.35, 32, 16);
    horizontal(&mut builder, Material { base_color: Vec3::new(0.9, 0.6, 0.3), ..pane(1.5) }, 0.6, 2.0, false);
    let mirror = builder.material(metal(0.9, 0.0));
    builder.panel(mirror, DVec3::new(0.0, 0.3, -0.9), 0.9 * DVec3::X, 0.28 * DVec3::Y);
    builder.camera(DVec3::new(0.3, 0.4, 1.6), DVec3::new(0.0, 0.1, -0.3), 0.8);
    builder.build()
}

/// A bulb: a small lamp in a thin globe with smooth normals, over a floor, with a block that casts a shadow.
fn bulb() -> Scene {
    let mut builder = Builder::default();
    horizontal(&mut builder, lambert(0.5), 0.0, 3.0, false);
    let lamp = builder.material(emitter_both(40.0));
    builder.panel(lamp, DVec3::new(0.0, 1.0, 0.0), 0.15 * DVec3::X, -0.15 * DVec3::Z);
    let globe = builder.material(pane(1.5));
    builder.sphere(globe, DVec3::new(0.0, 1.0, 0.0), 0.3, 24, 12);
    let block = builder.material(lambert(0.7));
    builder.block(block, DVec3::new(0.3, 0.0, -0.2), DVec3::new(0.5, 0.4, 0.2), false);
    builder.camera(DVec3::new(0.5, 1.2, 2.2), DVec3::new(0.0, 0.4, 0.0), 0.9);
    builder.build()
}

/// Light that meets panes before and behind a ball is found once, directly and in a mirror: the split is that of path tracing.
#[test]
fn the_split_through_walls_is_the_reference_at_any_number_of_bounces() {
    let scene = window();
    assert!(scene.features(0.25).has(Features::THIN_WALLS));
    for max_bounces in [3, 6] {
        let reference = blocks(&scene, &config(max_bounces, 1), &PATH, 3000);
        let split = blocks(&scene, &config(max_bounces, 2), &PROGRESSIVE, 1500);
        let scores = split.scores(&reference);
        println!("{max_bounces} bounces: {scores:?}, caustics {:.3}", split.caustic_share);
        assert!(scores.ratio_error < 0.005, "the test is too noisy");
        assert!(split.caustic_share > 0.15);
        assert_eq!(split.failure(&reference), None, "{max_bounces} bounces");
    }
}

/// Where paths are long enough for all light, walls as specular events give the same image. Their estimator shares no code with
/// light samples through walls.
#[test]
fn passed_walls_and_events_show_the_same_light() {
    let scene = bulb();
    // A small radius blurs no shadow of the block.
    let radius = Radius::Px(0.4);
    let event = RenderConfig {
        radius,
        thin_walls: ThinWalls::Event,
        emission: &POWER,
        light_paths: Paths::Count(40_000),
        ..config(16, 3)
    };
    let events = blocks(&scene, &event, &PROGRESSIVE, 1600);
    let passed = blocks(&scene, &RenderConfig { radius, ..config(16, 4) }, &PROGRESSIVE, 800);
    let scores = passed.scores(&events);
    println!("{scores:?}, caustics {:.3} and {:.3}", passed.caustic_share, events.caustic_share);
    assert!(events.caustic_share > 0.5 && passed.caustic_share < 0.3);
    assert!(scores.ratio_error < 0.015, "the test is too noisy");
    assert_eq!(passed.failure(&events), None);
    // A count of bounces that is too small for events must be noticed.
    let short = RenderConfig { max_bounces: 2, ..event };
    assert!(blocks(&scene, &short, &PROGRESSIVE, 200).failure(&passed).is_some());
}

/// A shade that glows on both sides and lets light through has no light on itself: it is flat.
#[test]
fn a_flat_wall_that_emits_does_not_light_itself() {
    let mut builder = Builder::default();
    let shade = Material {
        emission: Vec3::splat(2.0),
        transmission: 0.5,
        flags: FLAG_THIN | FLAG_EMIT_BOTH_SIDES,
        ..lambert(0.8)
    };
    let shade = builder.material(shade);
    // Off the axes, so that positions on it are rounded out of its plane.
    let (right, up) = (DVec3::new(0.8, 0.3, -0.5), DVec3::new(-0.1, 0.9, 0.3));
    builder.panel(shade, DVec3::new(0.3, 0.2, 0.1), right, up);
    builder.camera(DVec3::new(0.3, 0.2, 0.1) - 0.5 * right.cross(up), DVec3::new(0.3, 0.2, 0.1), 0.6);
    let found = blocks(&builder.build(), &config(5, 1), &BASIC, 4).whole();
    println!("{found:?}");
    assert!((found.value - 2.0).abs() < 1e-3, "{found:?}");
}
