//! Ray cones against real footprints.

use caustics_kernels::math::cone::RayCone;
use caustics_kernels::math::ray::Ray;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::pass::collect::follow;
use caustics_kernels::surface::class::Classes;
use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::DVec3;
use std::f64::consts::PI;

use super::settings;

/// The disc of a point seen directly has the area of its pixel's real footprint, from rays through the pixel's
/// corners; 3 % for the spread that is one for all pixels and for footprints that are no parallelograms.
#[test]
fn disc_has_the_area_of_the_pixels_footprint() {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.5));
    b.panel(floor, DVec3::ZERO, 9.0 * DVec3::Z, 9.0 * DVec3::X);
    b.light(DVec3::new(0.0, 2.0, 0.0), 1.0);
    b.camera(DVec3::new(0.0, 1.0, 2.0), DVec3::ZERO, 0.15);
    let scene = b.build();
    let world = World::new(&scene, &settings(36, 24, 1));
    let camera = &world.params.camera;
    let on_floor = |x: f64, y: f64| {
        let along_x = camera.right.as_dvec3() * (2.0 * x / 36.0 - 1.0);
        let along_y = camera.up.as_dvec3() * (1.0 - 2.0 * y / 24.0);
        let direction = camera.forward.as_dvec3() + along_x + along_y;
        camera.position.as_dvec3() - direction * f64::from(camera.position.y) / direction.y
    };
    for (pixel, collected) in world.collect().iter().enumerate() {
        let (x, y) = ((pixel % 36) as f64, (pixel / 36) as f64);
        let diagonals =
            (on_floor(x + 1.0, y + 1.0) - on_floor(x, y)).cross(on_floor(x, y + 1.0) - on_floor(x + 1.0, y));
        let footprint = 0.5 * diagonals.length();
        let disc = PI * f64::from(collected.geometry.radius).powi(2);
        assert!((disc / footprint - 1.0).abs() < 0.03, "pixel {pixel}: {disc:e} {footprint:e}");
    }
}

/// Seen in a convex sphere mirror, the cone is as wide in the plane of incidence as neighbouring rays part, to 10 %
/// up to 60 degrees (facets of 256 x 128 and their interpolated normals).
#[test]
fn cone_behind_a_convex_mirror_is_as_wide_as_neighbouring_rays_part() {
    let mut b = Builder::default();
    let wall = b.material(lambert(0.5));
    let ball = b.material(metal(1.0, 0.0));
    b.block(wall, DVec3::splat(-8.0), DVec3::splat(8.0), true);
    b.sphere(ball, DVec3::ZERO, 1.0, 256, 128);
    b.light(DVec3::new(0.0, 6.0, 0.0), 1.0);
    b.camera(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, 0.4);
    let scene = b.build();
    let world = World::new(&scene, &settings(8, 8, 1));
    let spread = 1e-4_f64;

    // A ray from the eye towards the sphere's point at `phi` in the plane y = x / 3, its mirror image, and the wall.
    let eye = DVec3::new(0.0, 0.0, 5.0);
    let across = DVec3::new(3.0, 1.0, 0.0).normalize();
    let turned = |angle: f64| -DVec3::Z * angle.cos() + across * angle.sin();
    let mirrored = |angle: f64| {
        let direction = turned(angle);
        let half = eye.dot(direction);
        let distance = -half - (half * half - eye.length_squared() + 1.0).sqrt();
        let hit = eye + distance * direction;
        (hit, direction - 2.0 * direction.dot(hit) * hit, -direction.dot(hit))
    };
    let (mut tracer, mut tally) = (world.tracer(), Tally::default());
    let mut worst = 0.0_f64;
    for step in 1..=24 {
        let angle = 0.1705 * f64::from(step) / 24.0;
        let (hit, direction, cos) = mirrored(angle);
        if cos < 0.5 {
            break;
        }
        let ray = Ray::endless(eye.as_vec3(), turned(angle).as_vec3());
        let rng = Rng::new(Stream::Camera, 0, step as u32, 0);
        let cone = RayCone::at_eye(spread as f32);
        let collected = follow(
            ray,
            cone,
            rng,
            Classes::NON_SPECULAR,
            &world.params,
            world.needs,
            world.tables(),
            &mut tracer,
            &mut tally,
        );
        let point = collected.geometry;
        assert_eq!(point.depth, 2);
        let receiving = f64::from(collected.shading.to_viewer.dot(point.normal));
        let width = f64::from(point.radius) * (PI * receiving).sqrt();

        // Finite difference at the same distance behind the mirror.
        let distance = (point.position.as_dvec3() - hit).length();
        let (hit_2, direction_2, _) = mirrored(angle + 1e-6);
        let parted = (hit_2 + distance * direction_2) - (hit + distance * direction);
        let parted = (parted - direction * parted.dot(direction)).length() / 1e-6 * spread;
        worst = worst.max((width / parted - 1.0).abs());
        println!("incidence {:.1} degrees: width {:.5} {:.5}", cos.acos().to_degrees(), width, parted);
        assert!((width / parted - 1.0).abs() < 0.1);
    }
    println!("largest difference {worst:.4}");
}
