//! Rooms whose light is known everywhere.

use caustics::counters::Counters;
use caustics::render_config::{Radius, RenderConfig};
use caustics_kernels::interface::counters::Counter;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::material::Material;
use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};

use super::{config, near};

/// No caster: the caustic layer is exactly zero and no light path is traced, with any features.
#[test]
fn room_without_casters_has_no_caustics_and_traces_no_light_path() {
    let scene = committed("plain-room");
    for features in [None, Some(Features::ALL)] {
        let (image, counters) =
            render(&scene, &config(96, 54, 100_000), "photons-grid", features, 0, 1).remove(0);
        assert!(image.caustics.iter().all(|&value| value == Vec3::ZERO));
        assert!(image.photons.iter().all(|&count| count == 0.0));
        for counter in [Counter::LightPaths, Counter::LightRays, Counter::Photons, Counter::Gathered] {
            assert_eq!(counters.get(counter), 0, "{counter:?}");
        }
        assert!(mean_of(&image.path) > 0.0);
    }
}

/// A closed room whose walls emit 1 and reflect a half has the radiance sum 0.5^k = 2 everywhere; lossless objects in
/// it are invisible. 1e-3 is for paths that glass makes longer than 20 bounces, and for discs that the room's edges
/// cut.
#[test]
fn lossless_objects_in_a_uniform_room_are_invisible() {
    let mut b = Builder::default();
    let wall = b.material(Material { emission: Vec3::ONE, ..lambert(0.5) });
    let ball = b.material(glass(1.5));
    let mirror = b.material(metal(1.0, 0.0));
    let thin = b.material(pane(1.5));
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.sphere(ball, DVec3::new(-0.4, -0.3, 0.0), 0.35, 128, 64);
    b.sphere(mirror, DVec3::new(0.4, -0.3, -0.3), 0.3, 64, 32);
    b.panel(thin, DVec3::new(0.3, 0.5, 0.2), 0.3 * DVec3::X, DVec3::new(0.0, 0.2, 0.2));
    b.camera(DVec3::new(0.0, 0.1, 0.95), DVec3::new(0.0, -0.1, 0.0), 1.0);
    let scene = b.build();
    let config = RenderConfig { max_bounces: 20, radius: Radius::Px(0.3), ..config(64, 48, 100_000) };
    let frames = render(&scene, &config, "photons-grid", None, 0, 10);
    let sums: Vec<f64> = frames.iter().map(|(p, _)| mean_of(&p.path) + mean_of(&p.caustics)).collect();
    let caustics: Vec<f64> = frames.iter().map(|(p, _)| mean_of(&p.caustics)).collect();
    println!("caustic part {:.4}", mean_and_error(&caustics).0);
    assert!(mean_and_error(&caustics).0 > 0.05, "the test has nothing to check");
    near("uniform room", mean_and_error(&sums), 2.0, 2e-3);
}

/// The walls of a closed room emit 1 and reflect a colour. The radiance is the sum of the colour's powers, up to the
/// number of bounces. Russian roulette ends paths whose throughput is below 0.3, half of that behind the first wall,
/// 0.6 in the brightest channel. They end at the third scattering with a probability of 1 - 0.6^3 / 0.3, and at each
/// later one with 1 - 0.6.
#[test]
fn russian_roulette_in_a_coloured_room_is_unbiased() {
    const BOUNCES: u32 = 12;
    let albedo = [0.6, 0.3, 0.1];
    let mut b = Builder::default();
    let base_color = DVec3::from(albedo).as_vec3();
    let wall = b.material(Material { emission: Vec3::ONE, base_color, ..lambert(1.0) });
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.camera(DVec3::new(0.0, 0.1, 0.95), DVec3::new(0.0, -0.1, 0.0), 1.0);
    let config = RenderConfig { max_bounces: BOUNCES, ..config(64, 48, 0) };
    let frames = render(&b.build(), &config, "photons-grid", None, 0, 20);

    for (channel, albedo) in albedo.into_iter().enumerate() {
        let mean = |path: &[Vec3]| {
            path.iter().map(|value| f64::from(value[channel])).sum::<f64>() / path.len() as f64
        };
        let means: Vec<f64> = frames.iter().map(|(image, _)| mean(&image.path)).collect();
        let expected = (0..=BOUNCES as i32).map(|bounce| albedo.powi(bounce)).sum();
        near("coloured room", mean_and_error(&means), expected, 5e-4);
    }

    // The first three rays of a path are always traced.
    let rays = 3.0 + (0..BOUNCES as i32 - 2).map(|behind| 0.72 * 0.6f64.powi(behind)).sum::<f64>();
    let per_path = |counters: &Counters| counters.get(Counter::CameraRays) as f64 / (64.0 * 48.0);
    let counted: Vec<f64> = frames.iter().map(|(_, counters)| per_path(counters)).collect();
    near("rays of a path", mean_and_error(&counted), rays, 5e-3);
}

/// Lossless objects of few facets with smooth normals show the radiance of a glowing room in every pixel. No pixel is
/// dark where the shading normal faces away, or where it sends light into the face. Lambert shows it on average, by
/// direct light.
#[test]
fn coarse_smooth_meshes_in_a_glowing_room_have_no_dark_pixels() {
    for (name, material) in [("mirror", metal(1.0, 0.0)), ("glass", glass(1.5)), ("lambert", lambert(1.0))] {
        let mut b = Builder::default();
        let (wall, thing) = (b.material(emitter(1.0)), b.material(material));
        b.block(wall, DVec3::splat(-2.0), DVec3::splat(2.0), true);
        b.sphere(thing, DVec3::new(-0.7, 0.0, 0.0), 0.6, 12, 6);
        b.smooth_block(thing, DVec3::new(0.7, 0.0, 0.0), 0.5);
        b.camera(DVec3::new(0.0, 0.9, 1.9), DVec3::ZERO, 1.0);
        let config = RenderConfig { max_bounces: 40, ..config(128, 96, 1) };
        let (image, _) = render(&b.build(), &config, "photons-grid", None, 0, 1).remove(0);
        let total = image.path.len() as f64;
        let dark = image.path.iter().filter(|v| v.x < 0.5).count() as f64 / total;
        println!("{name}: mean {:.5}, dark pixels {dark:.5}", mean_of(&image.path));
        // A ray may slip through an edge, and a path through glass may exceed the length limit. One sample a pixel of
        // direct light has a noise of about 0.4 on the third of the image that Lambert fills: four standard errors.
        let bound = match name {
            "mirror" => 1e-3,
            "glass" => 0.02,
            _ => 8e-3,
        };
        assert!((mean_of(&image.path) - 1.0).abs() < bound, "{name}");
        assert!(name == "lambert" || dark < bound, "{name}: {dark}");
    }
}

/// With black walls every pixel shows exactly 1, through glass and mirrors, except for paths that end at the length
/// limit.
#[test]
fn glass_in_a_black_glowing_room_shows_its_radiance_in_every_pixel() {
    let mut b = Builder::default();
    let wall = b.material(emitter(1.0));
    let ball = b.material(Material { absorption: Vec3::ZERO, ..glass(1.5) });
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.sphere(ball, DVec3::ZERO, 0.5, 128, 64);
    b.camera(DVec3::new(0.0, 0.0, 0.95), DVec3::ZERO, 1.0);
    let scene = b.build();
    let config = RenderConfig { max_bounces: 40, ..config(128, 96, 1) };
    let (image, _) = render(&scene, &config, "photons-grid", None, 0, 1).remove(0);
    let total = image.path.len() as f64;
    let off = image.path.iter().filter(|v| (v.x - 1.0).abs() > 1e-4).count() as f64 / total;
    println!("mean {:.6}, pixels off by more than 1e-4: {:.5}", mean_of(&image.path), off);
    assert!(image.path.iter().all(|v| v.x < 1.0 + 1e-4));
    assert!((mean_of(&image.path) - 1.0).abs() < 2e-3);
}
