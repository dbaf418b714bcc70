//! Spot and directional lights: direct light, emitted rays, and both through mirrors and glass.

use caustics::scene::Scene;
use caustics_kernels::interface::features::Features;
use caustics_kernels::light::emit::{EmissionSample, Emit};
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::trace::Tracer;
use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::DVec3;
use std::f64::consts::PI;

use super::glass::within_on_floor;
use super::{config, near};

/// A spot of 1.2 W/sr: its position, its direction, and its inner and outer angle (rad).
const INTENSITY: f64 = 1.2;
const AT: DVec3 = DVec3::new(0.3, 1.5, 0.2);
const AXIS: DVec3 = DVec3::new(-0.36, -0.8, 0.48);
const ANGLES: (f64, f64) = (0.25, 0.6);

/// glTF's falloff at an angle to the axis of a spot with this inner and outer angle.
fn falloff((inner, outer): (f64, f64), angle: f64) -> f64 {
    ((angle.cos() - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0).powi(2)
}

/// Integral of the intensity over directions up to `angle` around the axis (W).
fn flux_within(angle: f64) -> f64 {
    let steps = 100_000;
    let at = |step: i32| (f64::from(step) + 0.5) / f64::from(steps) * angle;
    let ring = |a: f64| falloff(ANGLES, a) * 2.0 * PI * a.sin();
    INTENSITY * (0..steps).map(|step| ring(at(step))).sum::<f64>() * angle / f64::from(steps)
}

/// A floor of albedo 0.5 about the origin under one light.
fn lit_floor(light: impl Fn(&mut Builder)) -> Scene {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.5));
    b.panel(floor, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    light(&mut b);
    b.camera(DVec3::new(0.0, 3.0, 0.1), DVec3::ZERO, 0.9);
    b.build()
}

fn spot(b: &mut Builder) {
    b.spot(AT, AXIS, ANGLES.0, ANGLES.1, INTENSITY as f32);
}

/// First rays of the frame's light paths.
fn emissions(world: &World<'_>, count: u32) -> Vec<EmissionSample> {
    let emit = world.by_power();
    let start = |path| {
        let mut rng = Rng::new(Stream::Light, 7, path, 0);
        emit.sample(&mut rng)
    };
    (0..count).map(start).collect()
}

/// Direct light of a spot is I falloff cos / d^2 in every pixel: in the inner cone, in the falloff and outside. The
/// single light is chosen with certainty, so that there is no noise; 1e-5 of the brightest is for f32.
#[test]
fn spot_lights_a_floor_by_its_falloff() {
    let scene = lit_floor(spot);
    assert_eq!(
        (scene.features(0.25), scene.lights[0].kind),
        (Features::SPOT_LIGHTS | Features::RECEIVERS, Features::SPOT_LIGHTS.0)
    );
    let world = World::new(&scene, &config(48, 48, 1));
    let mut seen = [0; 3];
    for collected in world.collect() {
        let along = collected.point.geometry.position.as_dvec3() - AT;
        let angle = (along.normalize().dot(AXIS)).acos();
        let irradiance = INTENSITY * falloff(ANGLES, angle) * AT.y / along.length().powi(3);
        let radiance = f64::from(collected.light.radiance.x);
        let expected = irradiance * 0.5 / PI;
        assert!((radiance - expected).abs() < 1e-5 * INTENSITY * 0.5 / PI, "{angle}: {radiance} {expected}");
        seen[usize::from(angle > ANGLES.0) + usize::from(angle > ANGLES.1)] += 1;
        assert_eq!(radiance == 0.0, angle > ANGLES.1 + 1e-6 || expected == 0.0);
    }
    println!("{seen:?} pixels in the inner cone, in the falloff, outside");
    assert!(seen.iter().all(|&count| count > 100), "the test has nothing to check");
}

/// Emitted rays carry the same intensity: flux within discs across the axis, and in the scene's total flux. The falloff
/// bounds the flux of single rays, so that its own scatter gives the standard error.
#[test]
fn spot_sends_its_flux_through_discs_across_its_axis() {
    let scene = lit_floor(spot);
    let world = World::new(&scene, &config(8, 8, 1));
    let rays = emissions(&world, 400_000);
    for angle in [0.1, ANGLES.0, 0.4, 0.5, ANGLES.1 + 1e-4] {
        let inside = |emission: &EmissionSample| {
            let direction = emission.ray.direction.as_dvec3();
            // In the plane a metre away.
            let across = direction / direction.dot(AXIS) - AXIS;
            if across.length() <= angle.tan() { f64::from(emission.flux.x) } else { 0.0 }
        };
        let fluxes: Vec<f64> = rays.iter().map(inside).collect();
        near(&format!("spot, within {angle:.2} rad"), mean_and_error(&fluxes), flux_within(angle), 1e-6);
    }
    assert!((f64::from(scene.flux.x) / flux_within(ANGLES.1) - 1.0).abs() < 1e-6);
}

/// A narrow spot, and one as wide as glTF allows, light the centre of their floor with I / d^2.
#[test]
fn spots_of_any_width_have_their_intensity_on_the_axis() {
    for (inner, outer) in [(0.0, 1e-3), (1e-3, 2e-3), (0.0, 0.5 * PI)] {
        let scene = lit_floor(|b| b.spot(2.0 * DVec3::Y, DVec3::NEG_Y, inner, outer, 3.0));
        let mut world = World::new(&scene, &config(1, 1, 1));
        world.params.camera.position = glam::Vec3::Y;
        world.params.camera.forward = glam::Vec3::NEG_Y;
        let radiance = f64::from(world.collect()[0].light.radiance.x);
        assert!((radiance / (3.0 / 4.0 * 0.5 / PI) - 1.0).abs() < 1e-5, "{outer}: {radiance}");
        let rays = emissions(&world, 20_000);
        let max_sine =
            rays.iter().map(|l| l.ray.direction.as_dvec3().cross(DVec3::Y).length()).fold(0.0, f64::max);
        assert!(
            max_sine <= outer.sin() * (1.0 + 1e-5) && max_sine > 0.99 * outer.sin(),
            "{outer}: {max_sine}"
        );
    }
}

/// Directional light is E cos on every floor at any distance, and zero where it comes from behind.
#[test]
fn directional_light_falls_by_the_cosine() {
    for degrees in [0.0_f64, 30.0, 60.0, 85.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let scene = lit_floor(|b| b.directional(DVec3::new(0.6 * sin, -cos, 0.8 * sin), 2.0));
        assert_eq!(scene.features(0.25), Features::DIRECTIONAL_LIGHTS | Features::RECEIVERS);
        for collected in World::new(&scene, &config(24, 24, 1)).collect() {
            let radiance = f64::from(collected.light.radiance.x);
            // cos 85 degrees has 1e-6 of relative error in f32.
            assert!((radiance / (2.0 * cos * 0.5 / PI) - 1.0).abs() < 3e-6, "{degrees}: {radiance}");
        }
    }
    let behind = lit_floor(|b| b.directional(DVec3::new(0.1, 1.0, 0.0), 2.0));
    assert!(World::new(&behind, &config(8, 8, 1)).collect().iter().all(|c| c.light.radiance.x == 0.0));
}

/// A plate of a quarter of the floor's width, far above it, casts its shadow.
#[test]
fn directional_light_casts_sharp_shadows_from_afar() {
    let build = |height: f64| {
        lit_floor(|b| {
            let plate = b.material(lambert(0.0));
            b.panel(plate, height * DVec3::Y, 0.5 * DVec3::Z, 0.5 * DVec3::X);
            b.directional(DVec3::NEG_Y, 1.0);
        })
    };
    for height in [4.0, 1e3, 1e5] {
        let scene = build(height);
        for collected in World::new(&scene, &config(24, 24, 1)).collect() {
            let p = collected.point.geometry.position;
            let edge = p.x.abs().max(p.z.abs()) - 0.5;
            // A plate far away has a clearance of its own: skip the border.
            if edge.abs() > 1e-3 {
                assert_eq!(collected.light.radiance.x > 0.0, edge > 0.0, "{height}: {p}");
            }
        }
    }
}

/// Small plates in the corners of a large room receive E cos A of the paths' flux in any direction. The disc of the
/// starts covers the whole scene; a plate alone receives as much. Three standard errors of the binomial law.
#[test]
fn directional_paths_reach_every_corner_of_the_scene() {
    let paths = 400_000;
    for direction in [DVec3::NEG_Y, DVec3::new(0.3, -0.9, 0.2), DVec3::new(1.0, -0.05, 0.4), DVec3::Y] {
        for half in [1.0, 100.0, 1e4] {
            let mut b = Builder::default();
            let plate = b.material(lambert(0.5));
            let size = 0.05 * half;
            for corner in 0..8 {
                let sign = |bit: i32| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
                let centre = half * DVec3::new(sign(0), 0.6 * sign(1), sign(2));
                b.panel(plate, centre, size * DVec3::Z, size * DVec3::X);
            }
            b.directional(direction, 2.0);
            b.camera(DVec3::new(0.0, 3.0, 0.1), DVec3::ZERO, 0.9);
            let scene = b.build();
            let world = World::new(&scene, &config(8, 8, 1));
            let mut tracer = world.tracer();
            let mut received = vec![0.0; scene.triangles.len()];
            for emission in emissions(&world, paths) {
                assert_eq!(emission.ray.direction, scene.lights[0].direction);
                let hit = tracer.closest(&emission.ray);
                if !hit.is_miss() {
                    received[hit.triangle as usize] += f64::from(emission.flux.x) / f64::from(paths);
                }
            }
            let d = direction.normalize();
            let upper = |id: &usize| scene.triangles[*id].a.y * -(d.y as f32) > 0.0;
            // Straight down, the upper plates hide the lower ones.
            let straight = d.y.abs() == 1.0;
            let open: Vec<usize> = (0..received.len()).filter(|id| !straight || upper(id)).collect();
            assert_eq!(open.len(), if straight { 8 } else { 16 });
            let expected = 2.0 * 2.0 * size * size * d.y.abs();
            let one = f64::from(scene.flux.x) / f64::from(paths);
            for id in open {
                let error = (expected * one).sqrt();
                assert!(
                    (received[id] - expected).abs() < 4.0 * error,
                    "{direction} {half}: {} of {expected} +- {error} at {}",
                    received[id],
                    scene.triangles[id].a
                );
            }
            assert!(expected / one > 100.0 * d.y.abs(), "the standard error is too large");
        }
    }
}

/// O2 with a spot: a plane mirror makes a virtual spot, mirrored in position and direction.
#[test]
fn plane_mirror_makes_a_virtual_spot() {
    let albedo = 0.5;
    let mut b = Builder::default();
    let floor = b.material(lambert(albedo));
    let mirror = b.material(metal(1.0, 0.0));
    b.panel(floor, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    b.panel(mirror, DVec3::new(1.0, 1.01, 0.0), DVec3::Z, DVec3::Y);
    let axis = DVec3::new(0.6, -0.4, 0.1).normalize();
    let angles = (0.1, 0.3);
    b.spot(DVec3::new(0.0, 1.0, 0.0), axis, angles.0, angles.1, 5.0);
    b.camera(DVec3::new(-0.1, 3.0, 0.3), DVec3::new(-0.1, 0.0, 0.3), 0.45);
    let scene = b.build();
    let config = config(48, 32, 300_000);
    let (virtual_image, mirrored_axis) = (DVec3::new(2.0, 1.0, 0.0), DVec3::new(-axis.x, axis.y, axis.z));
    let points: Vec<_> = World::new(&scene, &config).collect().iter().map(|c| c.point.geometry).collect();
    let irradiance = |p: DVec3| {
        let along = p - virtual_image;
        5.0 * falloff(angles, along.normalize().dot(mirrored_axis).acos()) * virtual_image.y
            / along.length().powi(3)
    };
    let at: Vec<f64> = points.iter().map(|point| irradiance(point.position.as_dvec3())).collect();
    let expected = at.iter().sum::<f64>() / at.len() as f64;
    let dark = at.iter().filter(|&&value| value == 0.0).count();
    assert!(dark > 100 && dark < at.len() - 400, "the border of the cone is in the image: {dark} are dark");

    let frames = render(&scene, &config, "photons-grid", None, 0, 10);
    let measured: Vec<f64> =
        frames.iter().map(|(p, _)| mean_of(&p.caustics) * PI / f64::from(albedo)).collect();
    let (mean, error) = mean_and_error(&measured);
    assert!(error < 0.01 * expected, "the standard error is too large");
    near("virtual spot", (mean, error), expected, 0.0);
}

/// O2 with a directional light: a mirror at 45 degrees sends rho E across to the wall beside it.
#[test]
fn plane_mirror_turns_directional_light() {
    let mut b = Builder::default();
    let wall = b.material(lambert(0.5));
    let mirror = b.material(metal(1.0, 0.0));
    // Taller than the mirror's light.
    b.panel(wall, DVec3::new(-1.0, 0.0, 0.0), DVec3::Y, DVec3::Z);
    b.panel(mirror, DVec3::ZERO, DVec3::new(0.5, 0.5, 0.0), -0.7 * DVec3::Z);
    b.directional(DVec3::NEG_Y, 3.0);
    b.camera(DVec3::new(0.0, 0.0, 2.0), DVec3::new(-1.0, 0.0, 0.0), 0.3);
    let scene = b.build();
    assert_eq!(scene.lights[0].kind, Features::DIRECTIONAL_LIGHTS.0);
    let world = World::new(&scene, &config(8, 8, 600_000));
    let photons = world.shoot(&world.by_power());
    for half in [0.1, 0.3, 0.45] {
        let one = f64::from(scene.flux.x) / 600_000.0;
        let inside = photons.flux().filter(|(g, _)| {
            g.scatterings == 1 && g.position.x < -0.99 && g.position.y.abs().max(g.position.z.abs()) < half
        });
        let flux: f64 = inside.map(|(_, flux)| flux).sum();
        let expected = 3.0 * 4.0 * f64::from(half).powi(2);
        near(&format!("turned light within {half} m"), (flux, (flux * one).sqrt()), expected, 1e-5);
    }
}

/// O5 with a directional light of the scene through a glass sphere of index 1.5, on the floor 1.2 R below its centre.
/// 1e-3 pi is for 512 x 256 facets.
#[test]
fn glass_sphere_focuses_a_directional_light() {
    let mut b = Builder::default();
    let floor = b.material(lambert(1e-6));
    let ball = b.material(glass(1.5));
    b.panel(floor, DVec3::new(0.0, -1.2, 0.0), 1.2 * DVec3::Z, 1.2 * DVec3::X);
    b.sphere(ball, DVec3::ZERO, 1.0, 512, 256);
    b.directional(DVec3::NEG_Y, 1.0);
    b.camera(DVec3::new(0.0, 8.0, 0.0), DVec3::ZERO, 0.5);
    let scene = b.build();
    let paths = 1_000_000;
    let world = World::new(&scene, &config(8, 8, paths));
    let photons = world.shoot(&world.by_power());
    let one = f64::from(scene.flux.x) / f64::from(paths);
    for radius in [0.05, 0.1, 0.2, 0.3, 1.0] {
        let inside = photons.flux().filter(|(g, _)| {
            let p = g.position.as_dvec3();
            g.scatterings == 2 && p.y < -1.2 + 1e-3 && p.x.hypot(p.z) <= radius
        });
        let flux: f64 = inside.map(|(_, flux)| flux).sum();
        let expected = PI * within_on_floor(1.2, radius);
        near(
            &format!("sun through glass, within {radius} R"),
            (flux, (flux * one).sqrt()),
            expected,
            1e-3 * PI,
        );
    }
}

/// With all kinds in one scene each light is chosen by its share of the power. Light paths bring the flux of each
/// light; light samples sum to the light of all.
#[test]
fn lights_of_every_kind_are_sampled_by_their_share_of_the_power() {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.5));
    let light = b.material(emitter(2.0));
    b.panel(floor, DVec3::ZERO, DVec3::Z, DVec3::X);
    b.panel(light, DVec3::new(0.0, 3.0, 0.0), 0.01 * DVec3::X, 0.01 * DVec3::Z);
    b.light(DVec3::new(0.0, 2.0, 0.0), 0.1);
    b.spot(DVec3::new(0.5, 1.0, 0.0), DVec3::new(-0.5, -1.0, 0.0), 0.2, 0.5, 0.7);
    b.directional(DVec3::new(0.0, -0.8, 0.6), 0.05);
    b.camera(DVec3::new(0.0, 2.0, 1.0), DVec3::ZERO, 0.001);
    let scene = b.build();
    let every =
        Features::AREA_LIGHTS | Features::POINT_LIGHTS | Features::SPOT_LIGHTS | Features::DIRECTIONAL_LIGHTS;
    assert_eq!(scene.features(0.25), every | Features::RECEIVERS);

    // Light at the origin: area (8e-4 W/sr at 3 m), point, spot, directional.
    let spot = 0.7 * 0.8_f64.sqrt() / 1.25;
    let irradiance = 2.0 * 4e-4 / 9.0 + 0.1 / 4.0 + spot + 0.05 * 0.8;
    let world = World::new(&scene, &config(200, 200, 1));
    let radiance: Vec<f64> = world.collect().iter().map(|c| f64::from(c.light.radiance.x)).collect();
    near("direct light of all", mean_and_error(&radiance), irradiance * 0.5 / PI, 1e-5);

    let cone = 1.0 - 0.5_f64.cos();
    let ring = 0.2_f64.cos() - 0.5_f64.cos();
    let sun = scene.lights.iter().find(|light| light.kind == Features::DIRECTIONAL_LIGHTS.0).unwrap();
    let fluxes = [
        ("area", 2.0 * 4e-4 * PI),
        ("point", 0.1 * 4.0 * PI),
        ("spot", 0.7 * 2.0 * PI * (cone - ring + ring / 3.0)),
        ("directional", 0.05 * PI * f64::from(sun.radius).powi(2)),
    ];
    let total: f64 = fluxes.iter().map(|(_, flux)| flux).sum();
    assert!((f64::from(scene.flux.x) / total - 1.0).abs() < 1e-5);
    let paths = emissions(&world, 200_000);
    let kind = |emission: &EmissionSample| {
        let origin = emission.ray.origin;
        if emission.ray.direction == sun.direction {
            "directional"
        } else if (origin - glam::Vec3::new(0.5, 1.0, 0.0)).length() < 1e-3 {
            "spot"
        } else if (origin - 2.0 * glam::Vec3::Y).length() < 1e-3 {
            "point"
        } else {
            "area"
        }
    };
    assert_eq!(scene.lights.len(), 5);
    for (name, expected) in fluxes {
        let of_kind =
            |emission: &EmissionSample| if kind(emission) == name { f64::from(emission.flux.x) } else { 0.0 };
        let values: Vec<f64> = paths.iter().map(of_kind).collect();
        near(&format!("flux of paths, {name}"), mean_and_error(&values), expected, 1e-6);
    }
}
