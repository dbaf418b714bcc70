//! The density estimate: its bias, its borders, facets, pixels without a point.

use caustics_kernels::gather::accumulator::Sum;
use caustics_kernels::gather::brute::Brute;
use caustics_kernels::gather::contribution::takes;
use caustics_kernels::interface::needs::Needs;
use caustics_kernels::interface::point::{DepositGeometry, DepositLight, PointGeometry, PointShading};
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

use super::{above_a_floor, near, settings};

/// O7 by the kernels' own gather and resolve: points in the plane z = 0 over deposits of density `flux(x, y)` per
/// area in [-1, 1]^2, arriving straight. Mean of pi L / albedo over the points and its standard error.
fn estimated(radius: f32, at: impl Fn(u32) -> (f32, f32), flux: impl Fn(f32, f32) -> f32) -> (f64, f64) {
    let (albedo, count, batches) = (0.5, 40_000_u32, 12);
    let materials = [lambert(albedo)];
    let settings = settings(20, 20, 1);
    let mut b = above_a_floor();
    b.light(DVec3::Y, 1.0);
    let scene = b.build();
    let mut params = World::new(&scene, &settings).params;
    params.cell_mask = (1 << 16) - 1;
    params.quantum = 2.0_f32.powi(-40);
    let points: Vec<_> = (0..400)
        .map(|id| {
            let (x, y) = at(id);
            PointGeometry { position: Vec3::new(x, y, 0.0), radius, normal: Vec3::Z, depth: 1 }
        })
        .collect();
    let shading = PointShading {
        to_viewer: Vec3::new(0.6, 0.0, 0.8),
        shading_normal: Vec3::Z,
        throughput: Vec3::ONE,
        ..PointShading::default()
    };
    let shadings = vec![shading; points.len()];
    let values: Vec<f64> = (0..batches)
        .map(|batch| {
            let mut deposits = Deposits::default();
            for path in 0..count {
                let u = Rng::new(Stream::Light, 3, path, batch).next4();
                let (x, y) = (2.0 * u.x - 1.0, 2.0 * u.y - 1.0);
                let geometry = DepositGeometry {
                    position: Vec3::new(x, y, 0.0),
                    scatterings: 1,
                    normal: Vec3::Z,
                    padding: 0,
                };
                let flux = Vec3::splat(flux(x, y) * 4.0 / count as f32);
                deposits.push(geometry, DepositLight { to_light: Vec3::Z, flux, ..DepositLight::default() });
            }
            let grid = Grid::build(&points, &deposits, &params);
            let (sorted, neighbours) = (&grid.sorted, grid.neighbours());
            let words = gather(&points, &shadings, sorted, neighbours, &materials, Needs::RECEIVERS, &params);
            assert!(words.iter().any(|&word| word != 0));
            mean_of(&resolved(&points, &shadings, &words, &params)) * PI / f64::from(albedo)
        })
        .collect();
    mean_and_error(&values)
}

/// O7: uniform light is exact, x^2 is off by r^2 / 4, an edge gives a half and a corner a quarter.
#[test]
fn disc_estimates_as_its_bias_says() {
    let scattered = |id: u32| {
        let u = Rng::new(Stream::Camera, 9, id, 0).next4();
        (1.4 * u.x - 0.7, 1.4 * u.y - 0.7)
    };
    near("uniform", estimated(0.1, scattered, |_, _| 2.0), 2.0, 1e-5);
    let along_x = |id: u32| (0.0, 1.4 * Rng::new(Stream::Camera, 9, id, 0).next4().y - 0.7);
    near("x^2 at 0, r = 0.2", estimated(0.2, along_x, |x, _| 3.0 * x * x), 0.03, 1e-6);
    near("straight edge", estimated(0.1, along_x, |x, _| f32::from(u8::from(x < 0.0))), 0.5, 1e-5);
    let corner = |x: f32, y: f32| f32::from(u8::from(x < 0.0 && y < 0.0));
    near("corner", estimated(0.2, |_| (0.0, 0.0), corner), 0.25, 1e-5);
}

/// Irradiance over truth on a cylinder of radius 1 with `facets` under smooth normals, by discs of 0.05; mean over
/// points anywhere on it and its standard error (from batches of deposits).
fn on_facets(facets: u32) -> (f64, f64) {
    let place = |around: f64, y: f64| {
        let step = 2.0 * PI / f64::from(facets);
        let left = (around * f64::from(facets)).floor() * step;
        let at = |angle: f64| DVec3::new(angle.cos(), 0.0, angle.sin());
        let (a, b) = (at(left), at(left + step));
        let share = (around * f64::from(facets)).fract();
        let position = a.lerp(b, share) + y * DVec3::Y;
        (position.as_vec3(), a.lerp(b, share).normalize().as_vec3())
    };
    let area = f64::from(facets) * 2.0 * (PI / f64::from(facets)).sin();
    let points: Vec<_> = (0..200)
        .map(|id| {
            let u = Rng::new(Stream::Camera, 11, id, facets).next4();
            let (position, normal) = place(f64::from(u.x), 0.6 * f64::from(u.z) - 0.3);
            PointGeometry { position, radius: 0.05, normal, depth: 1 }
        })
        .collect();
    let count = 30_000;
    let batches: Vec<f64> = (0..12)
        .map(|batch| {
            // An even lattice (the plastic number's), shifted at random: each batch is unbiased, and sharp.
            let shift = Rng::new(Stream::Light, 12, 0, batch).next4();
            let mut taken = 0_u32;
            for path in 0..count {
                let around = (f64::from(shift.x) + f64::from(path) * 0.754_877_666_246_692_8).fract();
                let y = (f64::from(shift.y) + f64::from(path) * 0.569_840_290_998_053_3).fract();
                let (position, normal) = place(around, y - 0.5);
                let deposit = DepositGeometry { position, scatterings: 1, normal, padding: 0 };
                taken += points.iter().map(|point| u32::from(takes(point, &deposit, 5))).sum::<u32>();
            }
            f64::from(taken) / 200.0 / f64::from(count) * area / (PI * 0.05 * 0.05)
        })
        .collect();
    mean_and_error(&batches)
}

/// The test of the disc loses nothing on smooth normals over facets up to 11 degrees apart; coarser ones are printed.
#[test]
fn disc_loses_nothing_on_smooth_normals_over_facets() {
    for facets in [128, 64, 32] {
        near(&format!("{facets} facets"), on_facets(facets), 1.0, 2e-3);
    }
    for facets in [24, 16, 12] {
        let (share, error) = on_facets(facets);
        println!("{facets} facets: {share:.4} +- {error:.4} of the light is found");
    }
}

/// Unused words of the accumulator stay zero where no point is.
#[test]
fn pixels_without_a_point_take_nothing() {
    let points = vec![PointGeometry::default(); 4];
    let shadings = vec![PointShading::default(); 4];
    let mut deposits = Deposits::default();
    deposits.push(DepositGeometry::default(), DepositLight::default());
    let scene = above_a_floor().build();
    let world = World::new(&scene, &settings(2, 2, 1));
    let brute = Brute { count: 1 };
    let words = gather(&points, &shadings, &deposits, brute, &scene.materials, world.needs, &world.params);
    assert!(words.iter().all(|&word| word == 0));
    assert_eq!(Sum::read(&words, 3, 1.0), (Vec3::ZERO, 0));
}
