//! Normal maps and textured materials in whole images.

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::scene::texture::Role;
use caustics_kernels::interface::choice::Caustics;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::texture::MaterialTextures;
use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};

/// `mixed_room` with a normal map of this texel on the walls and the ball.
fn bumped(texel: Option<[u8; 4]>) -> Scene {
    let mut b = Builder::default();
    let record = match texel {
        Some(texel) => {
            let normal = b.texture(Role::Normal, 4, 4, |_, _| texel);
            MaterialTextures { normal, ..MaterialTextures::default() }
        }
        None => MaterialTextures::default(),
    };
    let wall = b.textured(lambert(0.6), record);
    let ball = b.textured(metal(0.9, 0.0), record);
    let light = b.material(emitter(40.0));
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.sphere(ball, DVec3::new(-0.35, -0.645, 0.1), 0.35, 48, 24);
    b.panel(light, DVec3::new(0.2, 0.98, 0.1), DVec3::new(0.15, 0.0, 0.0), DVec3::new(0.0, 0.0, 0.15));
    b.camera(DVec3::new(0.1, 0.2, 0.95), DVec3::new(0.0, -0.45, 0.0), 0.9);
    b.build()
}

#[test]
fn flat_normal_maps_change_no_bit() {
    let config =
        RenderConfig { width: 64, height: 48, light_paths: Paths::Count(60_000), ..RenderConfig::default() };
    let image = |scene: &Scene| render(scene, &config, "photons-grid", None, 0, 1).remove(0).0;
    let (plain, flat) = (bumped(None), bumped(Some([128, 128, 255, 255])));
    assert!(
        flat.features(0.25).has(Features::NORMAL_MAPS) && !plain.features(0.25).has(Features::NORMAL_MAPS)
    );
    let (plain, flat) = (image(&plain), image(&flat));
    assert!(plain == flat);
    let tilted = image(&bumped(Some([150, 128, 252, 255])));
    assert!(tilted != plain && plain.photons.iter().sum::<f32>() > 50.0, "the test has nothing to check");
}

/// Bytes of the texel that tilts the normals of `tilted`.
const TILT: (i32, i32) = (63, 110);

/// A panel in the plane z = 0 whose normal map tilts by 30 degrees towards -x.
fn tilted(b: &mut Builder, material: Material) {
    let texel = [(128 - TILT.0) as u8, 128, (128 + TILT.1) as u8, 255];
    let normal = b.texture(Role::Normal, 1, 1, |_, _| texel);
    let bump = b.textured(material, MaterialTextures { normal, ..MaterialTextures::default() });
    b.panel(bump, DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y);
}

/// A beam from -x that meets the panel at 60 degrees.
fn slanting_beam() -> Beam {
    let (sin, cos) = 60_f32.to_radians().sin_cos();
    Beam {
        centre: Vec3::new(-sin, 0.0, cos) * 0.5,
        direction: Vec3::new(sin, 0.0, -cos),
        axes: [0.1 * Vec3::new(cos, 0.0, sin), 0.1 * Vec3::Y],
        round: false,
        irradiance: 1.0,
    }
}

/// A mirror with normals tilted by 30 degrees sends the beam straight up. Its flux is that of the face times |arriving
/// . n_s| |leaving . n_g| / (|arriving . n_g| |leaving . n_s|) = cos 0 / cos 60.
#[test]
fn mirror_of_tilted_normals_scales_flux_by_the_adjoint_factor() {
    let mut b = Builder::default();
    tilted(&mut b, metal(1.0, 0.0));
    let catcher = b.material(lambert(0.5));
    b.panel(catcher, DVec3::new(0.0, 0.0, 2.0), 20.0 * DVec3::NEG_X, 20.0 * DVec3::Y);
    b.camera(DVec3::new(0.0, 0.0, 1.0), DVec3::ZERO, 0.8);
    let scene = b.build();
    let config = RenderConfig {
        width: 8,
        height: 8,
        light_paths: Paths::Count(10_000),
        max_bounces: 2,
        ..RenderConfig::default()
    };
    let (world, beam) = (World::new(&scene, &config), slanting_beam());
    let photons = world.shoot(&beam);
    let ratio = photons.flux().map(|(_, flux)| flux).sum::<f64>() / beam.area();
    let tilt = f64::from(TILT.0).atan2(f64::from(TILT.1));
    assert!((tilt.to_degrees() - 30.0).abs() < 0.3);
    let (arriving, leaving) = (60_f64.to_radians(), 2.0 * tilt - 60_f64.to_radians());
    let expected = (arriving - tilt).cos() * leaving.cos() / (arriving.cos() * (tilt - leaving).cos());
    println!("mirror: {ratio:.5}, expected {expected:.5}; it would be 1 without the factor");
    assert!(photons.len() == 10_000 && (ratio / expected - 1.0).abs() < 1e-4, "{ratio} {expected}");
}

/// A Lambertian with tilted normals has the radiance albedo / pi cos 30 in all directions that both normals face. Their
/// projected solid angle is pi (1 + cos 30) / 2. Without the factor it is off by cos 60 / cos 30 = 0.58. A mirror above
/// returns all light to a floor, so that it counts as a caustic.
#[test]
fn lambertian_of_tilted_normals_scatters_by_the_shading_normal() {
    let albedo = 0.9;
    let mut b = Builder::default();
    tilted(&mut b, lambert(albedo));
    let (mirror, floor) = (b.material(metal(1.0, 0.0)), b.material(lambert(0.5)));
    b.panel(mirror, DVec3::new(0.0, 0.0, 1.0), 300.0 * DVec3::NEG_X, 300.0 * DVec3::Y);
    b.panel(floor, DVec3::new(0.0, 0.0, -0.01), 900.0 * DVec3::X, 900.0 * DVec3::Y);
    b.camera(DVec3::new(0.0, 0.0, 0.5), DVec3::ZERO, 0.8);
    let scene = b.build();
    let tilt = f64::from(TILT.0).atan2(f64::from(TILT.1));
    // Directions below the face are flipped, so that the mean correction over all directions is that of the arriving
    // light.
    let expected = f64::from(albedo) * (60_f64.to_radians() - tilt).cos() / 60_f64.to_radians().cos();
    let beam = slanting_beam();
    let ratios: Vec<f64> = (0..12)
        .map(|seed| {
            let config = RenderConfig {
                width: 8,
                height: 8,
                light_paths: Paths::Count(50_000),
                max_bounces: 3,
                seed,
                caustics: Caustics::Any,
                ..RenderConfig::default()
            };
            let photons = World::new(&scene, &config).shoot(&beam);
            photons.flux().map(|(_, flux)| flux).sum::<f64>() / beam.area()
        })
        .collect();
    let (ratio, error) = mean_and_error(&ratios);
    println!("Lambertian: {ratio:.4} +- {error:.4}, expected {expected:.4}, 0.58 of it without the factor");
    // 1e-4 is for light that passes beyond the mirror's rim.
    assert!((ratio - expected).abs() < 3.0 * error + 1e-4 && error < 0.01 * expected);
}
