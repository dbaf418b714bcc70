//! Light of an environment: orientation of its image, sampling of directions, and its effect on a scene.

use caustics::render_config::{Paths, Radius, RenderConfig};
use caustics::scene::{EnvironmentMap, Scene};
use caustics::session::RunnerChoice;
use caustics_kernels::emission::{AIMED, GUIDED, POWER};
use caustics_kernels::gather::variant::PHOTONS_GRID;
use caustics_kernels::interface::choice::{Caustics, LightSampler, PixelFilter};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::material::Material;
use caustics_kernels::light::environment::{direction_of, pdf_solid_angle, radiance_from, to_unit_square};
use caustics_kernels::light::light_sampling::LightCandidates;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::method::path::PATH;
use caustics_kernels::method::progressive::PROGRESSIVE;
use caustics_tests::blocks::Blocks;
use caustics_tests::direct::{World, mean_and_error};
use caustics_tests::energy::ledger;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};

const CPU: RunnerChoice = RunnerChoice::Cpu { threads: 0 };
const SAMPLES: u32 = 1 << 18;

/// A white sky from the horizon up, black below, with a warm sun of a few texels.
fn sky() -> EnvironmentMap {
    let (width, height) = (256, 128);
    let texel = |index: u32| {
        let (x, y) = (index % width, index / width);
        let sky = if y < height / 2 { Vec3::new(0.5, 0.6, 0.8) } else { Vec3::ZERO };
        let is_sun = (90..93).contains(&x) && (30..33).contains(&y);
        sky + if is_sun { Vec3::new(600.0, 500.0, 400.0) } else { Vec3::ZERO }
    };
    EnvironmentMap::new(width, height, (0..width * height).map(texel).collect())
}

/// A ball in empty space, seen from the side.
fn ball(material: Material) -> Scene {
    let mut b = Builder::default();
    let ball = b.material(material);
    b.sphere(ball, DVec3::ZERO, 0.5, 48, 24);
    b.camera(DVec3::new(0.0, 0.0, 2.0), DVec3::ZERO, 0.7);
    b.build()
}

fn put(mut scene: Scene, map: EnvironmentMap) -> Scene {
    scene.set_environment(map).expect("an environment that can be used");
    scene
}

/// An image with a colour for each axis: its position under any rotation.
#[test]
fn environment_image_has_z_in_the_middle_and_x_a_quarter_from_the_left() {
    let axes = [Vec3::NEG_Z, Vec3::X, Vec3::Z, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y];
    let (width, height) = (64, 32);
    // Columns around the left edge, a quarter, the middle, three quarters; rows at the poles.
    let color = |index: u32| {
        let (x, y) = (index % width, index / width);
        let axis = match y {
            0..4 => 4,
            28.. => 5,
            _ => ((x + 8) / 16 % 4) as usize,
        };
        Vec3::splat(1.0 + axis as f32)
    };
    let map = EnvironmentMap::new(width, height, (0..width * height).map(color).collect());
    let seen = |scene: &Scene, direction| radiance_from(scene.tables(), direction).x;
    let scene = put(ball(lambert(0.5)), map.clone());
    for (id, axis) in axes.into_iter().enumerate() {
        assert_eq!(seen(&scene, axis), 1.0 + id as f32, "{axis}");
    }
    // A quarter turn brings the texel of +z to +x.
    let turned = put(ball(lambert(0.5)), map.clone().placed(1.0, 90.0));
    for (from, to) in [(Vec3::Z, Vec3::X), (Vec3::X, Vec3::NEG_Z), (Vec3::Y, Vec3::Y)] {
        assert_eq!(seen(&turned, to), seen(&scene, from), "{from} to {to}");
    }
    let doubled = put(ball(lambert(0.5)), map.placed(2.0, -720.0));
    assert_eq!(seen(&doubled, Vec3::X), 2.0 * seen(&scene, Vec3::X));
}

#[test]
fn square_to_sphere_map_preserves_area_and_inverts() {
    let mut sum = Vec3::ZERO;
    for path in 0..SAMPLES {
        let u = Rng::new(Stream::Light, 3, path, 0).next4();
        let at = glam::Vec2::new(u.x, u.y);
        let direction = direction_of(at);
        assert!((direction.length() - 1.0).abs() < 1e-6);
        let angle = (direction_of(to_unit_square(direction)) - direction).length();
        assert!(angle < 2e-3, "{direction}: {angle}");
        sum += direction * direction;
    }
    // Second moments of even directions.
    let n = SAMPLES as f32;
    assert!((sum / n - Vec3::splat(1.0 / 3.0)).abs().max_element() < 4.0 * 0.3 / n.sqrt(), "{}", sum / n);
}

/// Light samples have the density that `pdf_solid_angle` reports, and give the image's irradiance on an upward face.
#[test]
fn environment_samples_follow_their_density_and_give_the_irradiance() {
    let scene = put(ball(lambert(0.5)), sky());
    let world = World::new(&scene, &RenderConfig::default());
    let light = scene.lights[0];
    let (mut irradiances, mut measures, mut suns) = (vec![], vec![], 0);
    for path in 0..SAMPLES {
        let u = Rng::new(Stream::Camera, 12, path, 0).next4();
        let c = LightCandidates::ONE.sample_light(0, world.tables(), 1, world.features, Vec3::ZERO, u);
        assert!(c.endless && c.pdf_solid_angle > 0.0);
        let known = radiance_from(world.tables(), c.to_light);
        let pdf = pdf_solid_angle(&light, world.tables(), c.to_light);
        assert_eq!(c.pdf_solid_angle, pdf);
        measures.push(f64::from(1.0 / pdf));
        irradiances.push(f64::from(c.radiance_over_pdf.x * c.to_light.y.max(0.0)));
        suns += u32::from(known.x > 100.0);
    }
    // Every direction can be sampled.
    let (measure, error) = mean_and_error(&measures);
    println!("solid angle {measure:.4} +- {error:.4}");
    assert!((measure - 4.0 * std::f64::consts::PI).abs() < 4.0 * error && error < 0.2);
    // Sum finely over the image's texels; interpolation gives the same except for texels that cross the horizon.
    let (sum, _) = integral(&scene, |direction| direction.y.max(0.0));
    let (irradiance, error) = mean_and_error(&irradiances);
    println!(
        "irradiance {irradiance:.5} +- {error:.5}, known {sum:.5}; sun {}",
        f64::from(suns) / f64::from(SAMPLES)
    );
    assert!((irradiance - sum).abs() < 4.0 * error + 1e-4 * sum && error < 0.004 * sum);
    // Three ten-thousandths of all directions have a third of the light, and are sampled as often.
    assert!(suns > SAMPLES / 5);
}

/// Integral of the red radiance times a weight over all directions, by a fine grid, and the solid angle of all.
fn integral(scene: &Scene, weight: impl Fn(Vec3) -> f32) -> (f64, f64) {
    let (columns, rows) = (2048, 1024);
    let (mut sum, mut measure) = (0.0, 0.0);
    for row in 0..rows {
        let down = std::f64::consts::PI * (f64::from(row) + 0.5) / f64::from(rows);
        let area = down.sin()
            * (std::f64::consts::PI / f64::from(rows))
            * (std::f64::consts::TAU / f64::from(columns));
        for column in 0..columns {
            let along = std::f64::consts::TAU * (f64::from(column) + 0.5) / f64::from(columns);
            let direction =
                DVec3::new(down.sin() * along.sin(), down.cos(), -down.sin() * along.cos()).as_vec3();
            let radiance = radiance_from(scene.tables(), direction).x;
            sum += f64::from(radiance * weight(direction)) * area;
            measure += area;
        }
    }
    (sum, measure)
}

fn config(seed: u32) -> RenderConfig {
    RenderConfig {
        width: 64,
        height: 48,
        pixel_filter: PixelFilter::Box,
        radius: Radius::Px(0.3),
        seed,
        ..RenderConfig::default()
    }
}

/// Under a uniform sky a lossless object is invisible, and one that reflects half is half as bright.
#[test]
fn lossless_objects_in_a_furnace_are_invisible() {
    let furnace = EnvironmentMap::constant(Vec3::splat(0.7));
    for (what, material, albedo) in [
        ("glass", glass(1.5), 1.0),
        ("dispersive glass", flint(1.5), 1.0),
        ("mirror", metal(1.0, 0.0), 1.0),
        ("white", lambert(1.0), 1.0),
        ("grey", lambert(0.5), 0.5),
    ] {
        let scene = put(ball(material), furnace.clone());
        for (method, frames) in [(&PATH, 64), (&BASIC, 64)] {
            let config = RenderConfig { max_bounces: 24, light_paths: Paths::Count(20_000), ..config(5) };
            let blocks = Blocks::render(&CPU, &scene, &config, method, &PHOTONS_GRID, frames);
            // The block in the middle of the ball, and one in a corner, of eight by six.
            let (middle, corner) = (blocks.block(3 * 8 + 4), blocks.block(0));
            println!("{what}, {}: {middle:?}", method.name);
            assert!((corner.value - 0.7).abs() < 1e-5, "{what}: {corner:?}");
            let slack = 4.0 * middle.error + 2e-3 * albedo;
            assert!((middle.value - 0.7 * albedo).abs() < slack, "{what}: {middle:?}");
            assert!(middle.error < 0.01, "the test is too noisy: {middle:?}");
        }
    }
}

/// Objects on a floor, without a sky.
fn things() -> Builder {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.6));
    let glass = b.material(Material { absorption: Vec3::new(0.5, 1.0, 2.0), ..glass(1.5) });
    let (ring, gloss) = (b.material(metal(0.9, 0.0)), b.material(metal(0.9, 0.2)));
    b.panel(floor, DVec3::new(0.0, -1.0, 0.0), 1.2 * DVec3::Z, 1.2 * DVec3::X);
    b.sphere(glass, DVec3::new(-0.35, -0.645, 0.1), 0.35, 48, 24);
    b.wall(ring, DVec3::new(0.45, -0.999, 0.2), 0.3, 0.15, 0.0, std::f64::consts::TAU, 96);
    b.panel(gloss, DVec3::new(0.0, -0.5, -0.9), 0.6 * DVec3::X, 0.4 * DVec3::Y);
    b.camera(DVec3::new(0.1, 0.4, 1.6), DVec3::new(0.0, -0.8, 0.0), 0.9);
    b
}

fn open_sky(map: EnvironmentMap) -> Scene {
    put(things().build(), map)
}

/// Every emission, with either share of light paths, agrees with plain path tracing. The sky has no sun, which the
/// reference would find too seldom behind glass.
#[test]
fn every_emission_and_caustics_setting_matches_path_tracing_under_a_sky() {
    let (width, height) = (32, 16);
    let texel = |index: u32| {
        let (x, y) = (index % width, index / width);
        let up = (height - y) as f32 / height as f32;
        let is_bright = (10..15).contains(&x) && (3..7).contains(&y);
        Vec3::new(0.3, 0.4, 0.6) * up + if is_bright { Vec3::new(6.0, 5.0, 4.0) } else { Vec3::ZERO }
    };
    let scene = open_sky(EnvironmentMap::new(width, height, (0..width * height).map(texel).collect()));
    let reference_settings = RenderConfig { light_sampler: LightSampler::Power, ..config(1) };
    let reference = Blocks::render(&CPU, &scene, &reference_settings, &PATH, &PHOTONS_GRID, 375);
    let mut faults = Vec::new();
    for (caustics, emission) in [
        (Caustics::First, &GUIDED),
        (Caustics::First, &AIMED),
        (Caustics::First, &POWER),
        (Caustics::Any, &POWER),
    ] {
        let config = RenderConfig { light_paths: Paths::Count(12_000), caustics, emission, ..config(2) };
        let split = Blocks::render(&CPU, &scene, &config, &PROGRESSIVE, &PHOTONS_GRID, 100);
        let scores = split.scores(&reference);
        println!("{caustics:?}, {}: {scores:?}, caustic share {:.3}", emission.name, split.caustic_share);
        assert!(scores.ratio_error < 0.01 && split.caustic_share > 0.01, "the test has nothing to check");
        faults.extend(
            split.failure(&reference).map(|fault| format!("{caustics:?}, {}: {fault}", emission.name)),
        );
    }
    assert!(faults.is_empty(), "{faults:?}");
}

/// The sun of an image acts like parallel light of its irradiance, as far as its width lets it.
#[test]
fn sun_of_an_environment_image_matches_a_directional_light() {
    let (width, height) = (2048, 1024);
    let index = 250 * width + 700;
    let mut texels = vec![Vec3::ZERO; (width * height) as usize];
    texels[index as usize] = Vec3::splat(1e5);
    let sunny = open_sky(EnvironmentMap::new(width, height, texels));
    let down = std::f64::consts::PI * (250.5 / f64::from(height));
    let along = std::f64::consts::TAU * (700.5 / f64::from(width));
    let from = DVec3::new(down.sin() * along.sin(), down.cos(), -down.sin() * along.cos());
    let (power, _) = integral(&sunny, |_| 1.0);

    let mut plain = things();
    plain.directional(-from, power as f32);
    let plain = plain.build();
    let render = |scene: &Scene, seed| {
        let config =
            RenderConfig { light_paths: Paths::Count(12_000), radius: Radius::Px(2.0), ..config(seed) };
        Blocks::render(&CPU, scene, &config, &BASIC, &PHOTONS_GRID, 400)
    };
    let (sun, directional) = (render(&sunny, 1), render(&plain, 2));
    println!("caustic share {:.4}, {:.4}", sun.caustic_share, directional.caustic_share);
    let scores = sun.scores(&directional);
    println!("{scores:?}");
    assert!((scores.ratio - 1.0).abs() < 4.0 * scores.ratio_error + 0.002, "{scores:?}");
    assert!((sun.caustic_share / directional.caustic_share - 1.0).abs() < 0.02);
    assert!(sun.caustic_share > 0.02, "the test has nothing to check");
}

/// Half the width of a lens, the radius of its round side, and the distance of a screen from its flat side (m). The
/// flat side faces the sun; the focus lies 1.6 m behind it.
const LENS: (f64, f64, f64) = (0.3, 0.8, 1.1);

/// A plano-convex glass lens around the origin that faces this direction, and a dark screen behind it.
fn lens(to_sun: DVec3) -> Builder {
    let (half, round, distance) = LENS;
    let turn = glam::DQuat::from_rotation_arc(DVec3::Y, to_sun);
    let mut b = Builder::default();
    let (screen, glass) = (b.material(lambert(1e-6)), b.material(glass(1.5)));
    let (rings, segments) = (64, 128);
    let centre = (round * round - half * half).sqrt();
    // Position by ring and segment on the round side, whose centre lies above the flat side.
    let at = |ring: u32, segment: u32| {
        let r = half * f64::from(ring) / f64::from(rings);
        let (sin, cos) =
            (std::f64::consts::TAU * f64::from(segment % segments) / f64::from(segments)).sin_cos();
        DVec3::new(r * cos, centre - (round * round - r * r).sqrt(), -r * sin)
    };
    let mut add = |corners: [DVec3; 3], normals: [DVec3; 3]| {
        b.triangle(glass, corners.map(|corner| turn * corner), normals.map(|normal| turn * normal));
    };
    let outwards = |p: DVec3| p - centre * DVec3::Y;
    for segment in 0..segments {
        for ring in 0..rings {
            let [a, b, c, d] =
                [at(ring, segment), at(ring, segment + 1), at(ring + 1, segment + 1), at(ring + 1, segment)];
            if ring > 0 {
                add([a, b, c], [a, b, c].map(outwards));
            }
            add([a, c, d], [a, c, d].map(outwards));
        }
        add([DVec3::ZERO, at(rings, segment), at(rings, segment + 1)], [DVec3::Y; 3]);
    }
    b.panel(screen, turn * (-distance * DVec3::Y), turn * (0.6 * DVec3::Z), turn * (0.6 * DVec3::X));
    b.camera(turn * DVec3::new(0.0, 0.5, 1.0), turn * (-distance * DVec3::Y), 0.9);
    b
}

/// Share of the lens's light within a radius of its axis on the screen, by Snell's and Fresnel's laws.
fn within_on_screen(radius: f64) -> f64 {
    let (half, round, distance) = LENS;
    let centre = (round * round - half * half).sqrt();
    let steps = 100_000;
    let ring = |step: i32| {
        let h = half * (f64::from(step) + 0.5) / f64::from(steps);
        let (inside, outside) = ((h / round).asin(), (1.5 * h / round).asin());
        let drop = (round * round - h * h).sqrt() - centre;
        let lands = h - (distance - drop) * (outside - inside).tan();
        let (ci, ct) = (1.5 * inside.cos(), outside.cos());
        let s = ((ci - ct) / (ci + ct)).powi(2);
        let p = ((inside.cos() - 1.5 * ct) / (inside.cos() + 1.5 * ct)).powi(2);
        let passes = 0.96 * (1.0 - 0.5 * (s + p));
        if lands.abs() <= radius { passes * 2.0 * h / (half * half) * half / f64::from(steps) } else { 0.0 }
    };
    (0..steps).map(ring).sum()
}

/// Behind a lens, a sun of 0.18 degrees leaves as much light within circles on a screen as a directional light of its
/// irradiance. Both match Snell's and Fresnel's laws.
#[test]
fn sun_of_an_environment_image_matches_a_directional_light_behind_a_lens() {
    let (width, height) = (2048, 1024);
    let index = 250 * width + 700;
    let mut texels = vec![Vec3::ZERO; (width * height) as usize];
    texels[index as usize] = Vec3::splat(1e5);
    let down = std::f64::consts::PI * (250.5 / f64::from(height));
    let along = std::f64::consts::TAU * (700.5 / f64::from(width));
    let from = DVec3::new(down.sin() * along.sin(), down.cos(), -down.sin() * along.cos());
    let sunny = put(lens(from).build(), EnvironmentMap::new(width, height, texels));
    let (irradiance, _) = integral(&sunny, |_| 1.0);
    let mut plain = lens(from);
    plain.directional(-from, irradiance as f32);
    let plain = plain.build();

    let (half, _, distance) = LENS;
    let on_lens = irradiance * std::f64::consts::PI * half * half;
    let foot = -distance * from;
    let paths = 1_500_000;
    let radii = [0.03, 0.04, 0.05, 0.1];
    let shares = |scene: &Scene| {
        let config = RenderConfig {
            width: 8,
            height: 8,
            light_paths: Paths::Count(paths),
            max_bounces: 4,
            ..RenderConfig::default()
        };
        let world = World::new(scene, &config);
        let photons = world.shoot(&world.by_power());
        radii.map(|radius| {
            let near = |p: Vec3| (p.as_dvec3() - foot).length() <= radius;
            let hits = photons.flux().filter(|(g, _)| g.scatterings == 2 && near(g.position));
            let (mut sum, mut squares) = (0.0, 0.0);
            for (_, flux) in hits {
                (sum, squares) = (sum + flux, squares + flux * flux);
            }
            (sum / on_lens, squares.sqrt() / on_lens)
        })
    };
    let (sun, directional) = (shares(&sunny), shares(&plain));
    for ((radius, sun), directional) in radii.into_iter().zip(sun).zip(directional) {
        let expected = within_on_screen(radius);
        println!("within {radius}: sun {sun:.4?}, directional {directional:.4?}, expected {expected:.4}");
        // The facets of the round side; half a per cent is for the tail of the map's texels around the sun, and for its
        // width.
        assert!((directional.0 - expected).abs() < 3.5 * directional.1 + 2e-3, "{radius}: {directional:?}");
        assert!((sun.0 - expected).abs() < 3.5 * sun.1 + 5e-3, "{radius}: {sun:?}");
        assert!(sun.1 < 0.02 && directional.1 < 0.02, "the test is too noisy");
    }
}

/// Flux of the sky is absorbed, or escapes.
#[test]
fn ledger_balances_under_a_sky() {
    let scene = open_sky(sky());
    let config = RenderConfig {
        width: 8,
        height: 8,
        light_paths: Paths::Count(1 << 16),
        max_bounces: 8,
        caustics: Caustics::Any,
        ..RenderConfig::default()
    };
    let world = World::new(&scene, &config);
    let energy = ledger(&world, &world.by_power(), 0);
    println!("{energy:?}");
    let emitted = f64::from(scene.flux.element_sum());
    // Glass and mirrors scatter nearly all flux without noise; four errors of the noise of the floor's directions.
    assert!(energy.residual.abs() < 2e-3, "{energy:?}");
    assert!((energy.emitted / emitted - 1.0).abs() < 0.02, "{} {emitted}", energy.emitted);
}

/// A scene without an environment compiles without its code. Sampled sky light is parallel, so that the code of
/// parallel light is compiled in.
#[test]
fn environment_feature_is_set_only_with_an_environment() {
    let features = |scene: &Scene| scene.features(0.25);
    assert!(!features(&open_air().build()).has(Features::ENVIRONMENT));
    let of_sky = features(&open_sky(sky()));
    assert!(of_sky.has(Features::ENVIRONMENT) && of_sky.has(Features::DIRECTIONAL_LIGHTS));
}
