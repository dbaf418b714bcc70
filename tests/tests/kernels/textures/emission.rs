//! Textured emitters: flux of light paths, results of light sampling, and the camera's view.

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::scene::texture::Role;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::texture::MaterialTextures;
use caustics_kernels::light::emit::Emit;
use caustics_kernels::light::light_sampling::LightCandidates;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Linear light of an sRGB byte.
fn linear(byte: u8) -> f64 {
    let encoded = f64::from(byte) / 255.0;
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Brighter to the right and below, with a black stripe.
fn glow(x: u32, y: u32) -> [u8; 4] {
    let byte = if x == 3 { 0 } else { (40 + x * 20 + y * 5) as u8 };
    [byte, 255 - byte, 30, 255]
}

const RADIANCE: f64 = 4.0;

/// Effect of alpha on the emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Alpha {
    /// None.
    Whole,
    /// Every other square of two texels is a hole.
    Holes,
    /// Squares blend to a fifth, alternating with opaque ones; all alpha is multiplied by 0.75.
    Blends,
}

const ALPHAS: [Alpha; 3] = [Alpha::Whole, Alpha::Holes, Alpha::Blends];

/// A textured panel of 1 m^2 that faces down from a height of 1 m, over a dark floor.
fn light(alpha: Alpha) -> (Scene, f64) {
    let mut b = Builder::default();
    let emissive = b.texture(Role::Color, 8, 8, glow);
    let mut record = MaterialTextures { emissive, ..MaterialTextures::default() };
    let byte = |x: u32, y: u32| match (alpha, (x / 2 + y / 2).is_multiple_of(2)) {
        (Alpha::Whole, _) | (_, false) => 255,
        (Alpha::Holes, true) => 0,
        (Alpha::Blends, true) => 51,
    };
    let mut factor = 1.0;
    if alpha != Alpha::Whole {
        record.base_color = b.texture(Role::Color, 8, 8, |x, y| [255, 255, 255, byte(x, y)]);
        if alpha == Alpha::Holes {
            record.alpha_cutoff = 0.5;
        } else {
            (record.alpha, record.blends, factor) = (0.75, 1, 0.75);
        }
        // Sharp holes make a sum over texels the exact mean.
        b.textures.textures[record.base_color as usize].nearest = true;
        b.textures.textures[emissive as usize].nearest = true;
    }
    let glowing = b.textured(emitter(RADIANCE as f32), record);
    let floor = b.material(lambert(0.5));
    b.panel(glowing, DVec3::new(0.0, 1.0, 0.0), 0.5 * DVec3::X, -0.5 * DVec3::NEG_Z);
    b.panel(floor, DVec3::ZERO, 2.0 * DVec3::Z, 2.0 * DVec3::X);
    b.camera(DVec3::new(0.0, 0.5, 1.5), DVec3::ZERO, 0.8);
    let texels = (0..8).flat_map(|y| (0..8).map(move |x| (x, y)));
    // A repeating texture has the mean of its texels under any interpolation.
    let share = |x, y| factor * f64::from(byte(x, y)) / 255.0;
    let mean = texels.map(|(x, y)| share(x, y) * linear(glow(x, y)[0])).sum::<f64>() / 64.0;
    (b.build(), RADIANCE * mean)
}

fn world(scene: &Scene) -> World<'_> {
    World::new(
        scene,
        &RenderConfig { width: 32, height: 32, light_paths: Paths::Count(1), ..RenderConfig::default() },
    )
}

/// Flux = area x mean radiance x pi, in the light table and in the mean of emitted paths.
#[test]
fn textured_light_has_the_flux_of_its_mean_texel() {
    for alpha in ALPHAS {
        let (scene, mean) = light(alpha);
        let features = scene.features(0.25);
        assert_eq!(features.has(Features::CUT_OUTS), alpha == Alpha::Holes);
        assert_eq!(features.has(Features::BLENDS), alpha == Alpha::Blends);
        let expected = PI * mean;
        // The host averages positions half a texel apart: the midpoint rule on straight pieces, and on holes that the
        // diagonal cuts.
        let table = f64::from(scene.flux.x);
        assert!((table / expected - 1.0).abs() < 5e-3, "table {table}, expected {expected}");
        let world = world(&scene);
        let emit = world.by_power();
        let values: Vec<f64> = (0..100_000)
            .map(|path| {
                let mut rng = Rng::new(Stream::Light, 4, path, 0);
                let emission = emit.sample(&mut rng);
                assert!(emission.ray.direction.y < 0.0, "the light faces down");
                f64::from(emission.flux.x)
            })
            .collect();
        let (flux, error) = mean_and_error(&values);
        println!("{alpha:?}: {flux:.4} +- {error:.4}, expected {expected:.4}, table {table:.4}");
        assert!((flux - expected).abs() < 3.0 * error);
        assert!(error < 0.01 * expected);
    }
}

/// A large scene has few samples a triangle, which miss the lit texels of a facade: coarser levels of the texture find them.
#[test]
fn a_light_of_few_lit_texels_in_a_large_scene_is_kept() {
    let mut b = Builder::default();
    let emissive = b.texture(Role::Color, 512, 512, |x, y| {
        if x % 64 == 37 && y % 64 == 21 { [255; 4] } else { [0, 0, 0, 255] }
    });
    let record = MaterialTextures { emissive, ..MaterialTextures::default() };
    let facade = b.textured(emitter(1.0e4), record);
    let dark = b.material(lambert(0.5));
    b.panel(facade, DVec3::new(0.0, 1.0, 0.0), 0.5 * DVec3::X, -0.5 * DVec3::NEG_Z);
    b.panel(dark, DVec3::ZERO, 2.0 * DVec3::Z, 2.0 * DVec3::X);
    for id in 0..160_000 {
        let corner = DVec3::new(f64::from(id % 400), 0.0, f64::from(id / 400)) * 0.01;
        b.triangle(dark, [corner, corner + 0.005 * DVec3::Z, corner + 0.005 * DVec3::X], [DVec3::Y; 3]);
    }
    b.camera(DVec3::new(0.0, 0.5, 1.5), DVec3::ZERO, 0.8);
    let scene = b.build();
    let expected = PI * 1.0e4 / 4096.0;
    println!("{} lights, flux {}, expected {expected}", scene.lights.len(), scene.flux.x);
    assert_eq!(scene.lights.len(), 2);
    // The flux only decides how often the light is chosen.
    assert!((0.7..1.4).contains(&(f64::from(scene.flux.x) / expected)));
}

/// Irradiance of a floor patch by light sampling, and by light paths that arrive in it.
#[test]
fn light_sampling_and_light_paths_bring_equal_irradiance() {
    for alpha in ALPHAS {
        let (scene, _) = light(alpha);
        let world = world(&scene);
        let features = world.features;
        // A patch off the middle, nearer to the brighter side of the light.
        let (low, high) = (Vec3::new(0.2, 0.0, 0.1), Vec3::new(0.6, 0.0, 0.5));
        let sampled: Vec<f64> = (0..200_000)
            .map(|path| {
                let mut rng = Rng::new(Stream::Camera, 6, path, 0);
                let position = low + (high - low) * rng.next4().truncate();
                let light_sample = LightCandidates::ONE.sample_light(
                    0,
                    scene.tables(),
                    scene.lights.len() as u32,
                    features,
                    position,
                    rng.next4(),
                );
                f64::from(light_sample.radiance_over_pdf.x * light_sample.to_light.y.max(0.0))
            })
            .collect();
        let emit = world.by_power();
        let area = f64::from((high.x - low.x) * (high.z - low.z));
        let arrived: Vec<f64> = (0..3_000_000)
            .map(|path| {
                let mut rng = Rng::new(Stream::Light, 8, path, 0);
                let emission = emit.sample(&mut rng);
                let ray = emission.ray;
                let at = ray.origin - ray.direction * (ray.origin.y / ray.direction.y);
                let inside = at.x > low.x && at.x < high.x && at.z > low.z && at.z < high.z;
                if inside { f64::from(emission.flux.x) / area } else { 0.0 }
            })
            .collect();
        let ((a, error_a), (b, error_b)) = (mean_and_error(&sampled), mean_and_error(&arrived));
        println!("{alpha:?}: light samples {a:.4} +- {error_a:.4}, light paths {b:.4} +- {error_b:.4}");
        assert!((a - b).abs() < 3.0 * error_a.hypot(error_b));
        assert!(error_b < 0.01 * b);
    }
}

/// The camera sees the texels themselves, at the finest level from any distance.
#[test]
fn camera_sees_the_texels_of_a_textured_light() {
    let (scene, _) = light(Alpha::Whole);
    let config =
        RenderConfig { width: 64, height: 64, light_paths: Paths::Count(1), ..RenderConfig::default() };
    let mut camera = scene.cameras[0].clone();
    camera.position = Vec3::new(0.0, 0.01, 0.0);
    (camera.forward, camera.right, camera.up) = (Vec3::Y, Vec3::X, Vec3::NEG_Z);
    camera.fov_y = 2.0 * 0.5_f32.atan();
    let scene = Scene { cameras: vec![camera], ..scene };
    let collected = World::new(&scene, &config).collect();
    let mean = collected.iter().map(|c| f64::from(c.light.radiance.x)).sum::<f64>() / 4096.0;
    let (lowest, highest) = collected.iter().fold((f32::MAX, 0.0_f32), |(lowest, highest), c| {
        (lowest.min(c.light.radiance.x), highest.max(c.light.radiance.x))
    });
    let expected = f64::from(scene.flux.x) / PI;
    println!("mean {mean:.4} of {expected:.4}, {lowest:.4} to {highest:.4}");
    // The view cuts off the outermost 1 %; texels differ by a factor of 20.
    assert!((mean / expected - 1.0).abs() < 0.02 && lowest < 0.05 && f64::from(highest) > 1.5 * expected);
}
