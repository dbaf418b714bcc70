//! Cut-outs let light through, in every tracer and for every kind of ray.

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::scene::texture::Role;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::ray::Ray;
use caustics_kernels::interface::texture::MaterialTextures;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::trace::Tracer;
use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};

/// A floor under a far light, with a screen between them in which every other square is open. Interpolated alpha is at
/// the cut-off exactly on the squares' borders.
fn screened(screen: bool, cutoff: f32) -> Scene {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.5));
    let alpha = |x: u32, y: u32| [255, 255, 255, if (x + y).is_multiple_of(2) { 255 } else { 0 }];
    let base_color = b.texture(Role::Color, 16, 16, alpha);
    let record = MaterialTextures { base_color, alpha_cutoff: cutoff, ..MaterialTextures::default() };
    let leaves = b.textured(lambert(0.0), record);
    b.panel(floor, DVec3::ZERO, 1.0 * DVec3::Z, 1.0 * DVec3::X);
    if screen {
        b.panel(leaves, DVec3::new(0.0, 0.5, 0.0), 4.0 * DVec3::Z, 4.0 * DVec3::X);
    }
    b.light(DVec3::new(0.0, 1000.0, 0.0), 1e6);
    // View from between floor and screen.
    b.camera(DVec3::new(0.0, 0.45, 0.0), DVec3::ZERO, 1.2);
    b.build()
}

#[test]
fn half_open_screens_let_half_the_light_through() {
    let config = RenderConfig {
        width: 256,
        height: 256,
        light_paths: Paths::Count(1),
        max_bounces: 1,
        ..RenderConfig::default()
    };
    let light = |scene: &Scene| mean_of(&render(scene, &config, "photons-grid", None, 0, 1)[0].0.path);
    let (open, half) = (light(&screened(false, 0.5)), light(&screened(true, 0.5)));
    println!("{half:.5} of {open:.5}");
    // The image shows about 2 x 2 squares of the shadow pattern, counted by pixels of 2 mm: borders take 1 %.
    assert!((half / open - 0.5).abs() < 0.01, "{half} of {open}");
    // A cut-off at or near 0 leaves no hole.
    assert!(light(&screened(true, 1e-6)) < 1e-3 * open);
    assert_eq!(light(&screened(true, 0.0)), 0.0);
}

#[test]
fn closest_hits_and_occlusion_see_the_same_holes() {
    let scene = screened(true, 0.5);
    let features = scene.features(0.25);
    assert!(features.has(Features::CUT_OUTS) && !screened(true, 0.0).features(0.25).has(Features::CUT_OUTS));
    let mut tracer = scene.tracer(features);
    let mut passed = 0;
    let count = 100_000;
    for path in 0..count {
        let u = Rng::new(Stream::Light, 2, path, 0).next4();
        let origin = Vec3::new(8.0 * u.x - 4.0, 0.75, 8.0 * u.y - 4.0);
        let ray = Ray { length: 0.5, ..Ray::endless(origin, Vec3::NEG_Y) };
        let hit = tracer.closest(&ray);
        assert_eq!(tracer.occluded(&ray), !hit.is_miss());
        passed += u32::from(hit.is_miss());
    }
    // Three standard errors of a fair coin.
    let share = f64::from(passed) / f64::from(count);
    assert!((share - 0.5).abs() < 1.5 / f64::from(count).sqrt(), "{share}");
}

/// Without the feature the code is compiled out, and the screen is whole.
#[test]
fn screen_is_opaque_without_the_cut_out_feature() {
    let scene = screened(true, 0.5);
    let mut tracer = scene.tracer(Features(0));
    for path in 0..1000 {
        let u = Rng::new(Stream::Light, 3, path, 0).next4();
        let origin = Vec3::new(7.9 * u.x - 3.95, 0.75, 7.9 * u.y - 3.95);
        assert!(tracer.occluded(&Ray { length: 0.5, ..Ray::endless(origin, Vec3::NEG_Y) }));
    }
}

/// The background is seen through holes and past all geometry; it lights nothing.
#[test]
fn background_is_seen_directly_and_in_mirrors_and_lights_nothing() {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.5));
    let mirror = b.material(metal(0.8, 0.0));
    b.panel(floor, DVec3::new(-1.0, 0.0, 0.0), DVec3::X, DVec3::Y);
    b.panel(mirror, DVec3::new(1.0, 0.0, 0.0), DVec3::X, DVec3::Y);
    b.camera(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 1.0);
    b.light(DVec3::new(-1.0, 0.0, 1.0), 1.0);
    let scene = b.build();
    let background = Vec3::new(0.25, 0.5, 1.0);
    let config =
        RenderConfig { width: 64, height: 64, light_paths: Paths::Count(1), ..RenderConfig::default() };
    let with = RenderConfig { background: Some(background.to_array()), ..config.clone() };
    let dark = render(&scene, &config, "photons-grid", None, 0, 1).remove(0).0;
    let bright = render(&scene, &with, "photons-grid", None, 0, 1).remove(0).0;
    let (mut free, mut mirrored, mut on_floor) = (0, 0, 0);
    for (dark, bright) in dark.path.iter().zip(&bright.path) {
        let added = *bright - *dark;
        if added == Vec3::ZERO {
            on_floor += 1;
        } else if added == background {
            free += 1;
        } else {
            // A metal's reflectance at these angles is its colour to 1 %.
            assert!((added / (0.8 * background) - Vec3::ONE).abs().max_element() < 0.01, "{added}");
            mirrored += 1;
        }
    }
    println!("{free} pixels see it, {mirrored} in the mirror, {on_floor} not at all");
    assert!(free > 500 && mirrored > 300 && on_floor > 300);
    // The file's own colour counts where the option is absent.
    let scene = Scene { background, ..scene };
    assert!(render(&scene, &config, "photons-grid", None, 0, 1).remove(0).0.path == bright.path);
}
