//! O6: conic mirrors. A parabola sends parallel light to its focus, an ellipse the light of one focus to the other.
//!
//! Mirrors are facets under smooth normals. A facet of edge h lies off its mirror by up to h^2 k / 8 (k: curvature).
//! Its interpolated unit normal is turned by the same order. Light misses the focus by a length that falls with h^2;
//! the tests print this length and check its fall. Discs are chosen wider than that.

use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

use super::{config, near};

/// Reflectance at normal incidence of the mirrors; at other angles it is Schlick's.
const RHO: f64 = 0.8;

fn reflectance(cos: f64) -> f64 {
    RHO + (1.0 - RHO) * (1.0 - cos).powi(5)
}

/// A piece of the paraboloid y = (x^2 + z^2) / 4, x in [0.4, 1.4], z in [-0.5, 0.5], of `count` x `count` squares. Its
/// focus is at (0, 1, 0); nothing there shades it from above. Returns distance from the focus and flux of all light of
/// irradiance 1 that it sends to a plate at the focus.
fn by_parabola(count: u32) -> Vec<(f64, f64)> {
    let mut b = Builder::default();
    let mirror = b.material(metal(RHO as f32, 0.0));
    let plate = b.material(lambert(1e-6));
    let at = |i: u32, j: u32| {
        let (x, z) = (0.4 + f64::from(i) / f64::from(count), f64::from(j) / f64::from(count) - 0.5);
        (DVec3::new(x, 0.25 * (x * x + z * z), z), DVec3::new(-0.5 * x, 1.0, -0.5 * z))
    };
    for i in 0..count {
        for j in 0..count {
            let [a, b_, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            b.triangle(mirror, [a.0, b_.0, c.0], [a.1, b_.1, c.1]);
            b.triangle(mirror, [a.0, c.0, d.0], [a.1, c.1, d.1]);
        }
    }
    b.panel(plate, DVec3::Y, 0.1 * DVec3::Z, 0.1 * DVec3::X);
    b.camera(DVec3::new(0.0, 8.0, 0.0), DVec3::ZERO, 0.5);
    let scene = b.build();
    let world = World::new(&scene, &config(8, 8, 200_000));
    let beam = Beam {
        centre: Vec3::new(0.9, 3.0, 0.0),
        direction: Vec3::NEG_Y,
        axes: [0.5 * Vec3::X, 0.5 * Vec3::Z],
        round: false,
        irradiance: 1.0,
    };
    let photons = world.shoot(&beam);
    let focused = photons.flux().filter(|(g, _)| g.scatterings == 1);
    focused.map(|(g, flux)| ((g.position.as_dvec3() - DVec3::Y).length(), 200_000.0 * flux)).collect()
}

/// Mean flux of all paths within `radius`, and its standard error; some paths bring nothing.
fn within(paths: &[(f64, f64)], count: usize, radius: f64) -> (f64, f64) {
    let inside = paths.iter().filter(|(distance, _)| *distance <= radius).map(|(_, flux)| *flux);
    let mut all: Vec<f64> = inside.collect();
    all.resize(count, 0.0);
    mean_and_error(&all)
}

/// Distance from the focus within which 99.9 % of the light lies.
fn spread(paths: &[(f64, f64)]) -> f64 {
    let mut distances: Vec<f64> = paths.iter().map(|(distance, _)| *distance).collect();
    distances.sort_by(f64::total_cmp);
    distances[distances.len() * 999 / 1000]
}

/// O6: every disc at a parabola's focus holds all of rho x flux. 1e-3 is for rays at the piece's border, and for the
/// flux correction of shading normals. This averages to 1 over a facet to second order.
#[test]
fn parabola_sends_all_light_to_its_focus() {
    let steps = 400;
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(steps);
    let cells = (0..steps * steps).map(|cell| (0.4 + at(cell % steps), at(cell / steps) - 0.5));
    let expected = cells.map(|(x, z)| reflectance(1.0 / (1.0 + 0.25 * (x * x + z * z)).sqrt())).sum::<f64>()
        / f64::from(steps * steps);
    assert!(expected > RHO && expected < 1.001 * RHO);
    let (coarse, fine) = (by_parabola(16), by_parabola(128));
    println!(
        "99.9 % within {:.2e} m (16 x 16 squares), {:.2e} m (128 x 128)",
        spread(&coarse),
        spread(&fine)
    );
    assert!(spread(&fine) < spread(&coarse) / 30.0, "eight times finer: 64 times nearer");
    for radius in [1e-3, 1e-2, 0.1] {
        let measured = within(&fine, 200_000, radius);
        near(&format!("parabola, within {radius} of the focus"), measured, expected, 1e-3 * expected);
    }
}

/// An ellipsoid of half axes 1.25, 0.75 and 0.75 with its foci at x = -1 and 1. A point light of 1 W/sr is in one
/// focus, a cube of half edge `catcher` around the other. Returns the flux on the cube after one reflection, and its
/// standard error.
fn by_ellipse(segments: u32, catcher: f64) -> (f64, f64) {
    let mut b = Builder::default();
    let mirror = b.material(metal(RHO as f32, 0.0));
    let dark = b.material(lambert(1e-6));
    let rows = segments / 2;
    let at = |row: u32, segment: u32| {
        let (sin, cos) = (PI * f64::from(row) / f64::from(rows)).sin_cos();
        let (s, c) = (TAU * f64::from(segment % segments) / f64::from(segments)).sin_cos();
        // Poles on the long axis: facets are finest near the foci.
        let p = DVec3::new(1.25 * cos, 0.75 * sin * c, 0.75 * sin * s);
        (p, -p / DVec3::new(1.25 * 1.25, 0.75 * 0.75, 0.75 * 0.75))
    };
    for row in 0..rows {
        for segment in 0..segments {
            let [a, b_, c, d] =
                [at(row, segment), at(row, segment + 1), at(row + 1, segment + 1), at(row + 1, segment)];
            if row + 1 != rows {
                b.triangle(mirror, [a.0, c.0, d.0], [a.1, c.1, d.1]);
            }
            if row != 0 {
                b.triangle(mirror, [a.0, b_.0, c.0], [a.1, b_.1, c.1]);
            }
        }
    }
    b.block(dark, DVec3::X - catcher, DVec3::X + catcher, false);
    b.light(DVec3::NEG_X, 1.0);
    b.camera(DVec3::ZERO, DVec3::Z, 0.5);
    let scene = b.build();
    let paths = 200_000;
    let world = World::new(&scene, &config(8, 8, paths));
    let photons = world.shoot(&world.by_power());
    let caught: Vec<(f64, f64)> = photons
        .flux()
        .filter(|(g, _)| g.scatterings == 1)
        .map(|(_, flux)| (0.0, f64::from(paths) * flux))
        .collect();
    within(&caught, paths as usize, 1.0)
}

/// O6: an ellipse sends all light of one focus to the other: a cube of any size around it takes rho x flux. The cube's
/// own shadow is r^2 / (4 pi) of the light; 1e-3 is for facets of 512 x 256.
#[test]
fn ellipse_sends_all_light_from_focus_to_focus() {
    // Mean reflectance over the directions of the light.
    let steps = 20_000;
    let mean = |step: i32| {
        let cos = -1.0 + (f64::from(step) + 0.5) * 2.0 / f64::from(steps);
        // Distance from the focus at -1 along this direction, by r = b^2 / (a - c cos).
        let r = 0.5625 / (1.25 - cos);
        let p = DVec3::new(-1.0 + r * cos, r * (1.0 - cos * cos).sqrt(), 0.0);
        let normal = -(p / DVec3::new(1.5625, 0.5625, 0.5625)).normalize();
        reflectance((DVec3::NEG_X - p).normalize().dot(normal))
    };
    let expected = 4.0 * PI * (0..steps).map(mean).sum::<f64>() / f64::from(steps);
    for half in [0.01, 0.03, 0.1] {
        let lit = expected * (1.0 - half * half / (4.0 * PI));
        near(&format!("ellipse, cube of {half}"), by_ellipse(512, half), lit, 1e-3 * expected);
    }
}
