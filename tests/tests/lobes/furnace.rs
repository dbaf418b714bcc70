//! Furnaces: what a lobe scatters of uniform light, by quadrature in f64 and by the samplers.

use caustics_kernels::interface::material::{FLAG_THIN, Material};
use caustics_kernels::interface::needs::Needs;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::surface::class::Classes;
use caustics_kernels::surface::{Surface, ggx};
use caustics_tests::scenes::{glass, pane};
use glam::{DVec3, Vec3};
use std::f64::consts::TAU;

use super::{COSINES, viewer};

/// Mean over normals h drawn from D(h) cos(h) of `value(h)`: midpoints of the inverse distribution.
fn over_normals(alpha: f64, value: impl Fn(DVec3) -> f64) -> f64 {
    let (rows, columns) = (600, 600);
    let mut sum = 0.0;
    for i in 0..rows {
        // Squared, so that the tails get more points; the weight is its derivative.
        let v = (f64::from(i) + 0.5) / f64::from(rows);
        let (u, weight) = (1.0 - v * v, 2.0 * v);
        let tan2 = alpha * alpha * u / (1.0 - u);
        let z = 1.0 / (1.0 + tan2).sqrt();
        let r = (1.0 - z * z).sqrt();
        for j in 0..columns {
            let (sin, cos) = (TAU * (f64::from(j) + 0.5) / f64::from(columns)).sin_cos();
            sum += weight * value(DVec3::new(r * cos, r * sin, z));
        }
    }
    sum / f64::from(rows * columns)
}

/// The weak white furnace: what is mirrored by all visible normals, unshadowed in the way out, is 1 [Heitz 2014].
/// 2e-3: midpoints, where the horizon of visibility cuts through the cells at grazing angles.
#[test]
fn weak_white_furnace_is_one() {
    println!("integral of the density of visible normals; rows: roughness, columns: cosine {COSINES:?}");
    for roughness in [0.08_f32, 0.15, 0.25, 0.4, 0.6, 0.8, 1.0] {
        let alpha = ggx::alpha(roughness);
        let row = COSINES.map(|cos| {
            let o = viewer(cos);
            over_normals(f64::from(alpha), |h| {
                let half = h.as_vec3();
                let cos_half = o.dot(half);
                if cos_half <= 0.0 {
                    return 0.0;
                }
                let density = 4.0 * cos_half * ggx::visible_pdf(o, half, alpha);
                f64::from(density) / (f64::from(ggx::distribution(half, alpha)) * h.z)
            })
        });
        println!("{roughness:.2}: {}", row.map(|value| format!("{value:.4}")).join(" "));
        assert!(row.iter().all(|value| (value - 1.0).abs() < 2e-3), "roughness {roughness}: {row:?}");
    }
}

/// Shares that rough glass (white) reflects and transmits, by quadrature: all in f64 and written out anew.
fn glass_by_quadrature(material: &Material, cos: f64, eta: f64) -> (f64, f64) {
    let alpha = f64::from(material.roughness).powi(2);
    let thin = material.flags & FLAG_THIN != 0;
    let o = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let lambda = |z: f64| 0.5 * ((1.0 + alpha * alpha * (1.0 - z * z) / (z * z)).sqrt() - 1.0);
    let fresnel = |c: f64, eta: f64| {
        let behind = 1.0 - eta * eta * (1.0 - c * c);
        if behind <= 0.0 {
            return 1.0;
        }
        let t = behind.sqrt();
        0.5 * (((eta * c - t) / (eta * c + t)).powi(2) + ((c - eta * t) / (c + eta * t)).powi(2))
    };
    let (mut reflected, mut transmitted) = (0.0, 0.0);
    let share = |h: DVec3, part: usize| {
        let c = o.dot(h);
        if c <= 0.0 {
            return 0.0;
        }
        let mut r = fresnel(c, if thin { 1.0 / f64::from(material.ior) } else { eta });
        if thin {
            r = 2.0 * r / (1.0 + r);
        }
        let mirrored = 2.0 * c * h - o;
        let (leaves, carried) = if part == 0 {
            (mirrored.z, r)
        } else if thin {
            (mirrored.z, 1.0 - r)
        } else {
            let behind = 1.0 - eta * eta * (1.0 - c * c);
            let t = h * (eta * c - behind.max(0.0).sqrt()) - eta * o;
            (-t.z, 1.0 - r)
        };
        if leaves <= 0.0 {
            return 0.0;
        }
        carried * c / (cos * h.z * (1.0 + lambda(cos) + lambda(leaves)))
    };
    reflected += over_normals(alpha, |h| share(h, 0));
    transmitted += over_normals(alpha, |h| share(h, 1));
    (reflected, transmitted)
}

/// The samplers' mean weights: (reflected, transmitted), each with its standard error.
fn glass_by_sampling(material: Material, cos: f32, eta: f32, classes: Classes) -> [(f64, f64); 2] {
    let (surface, interface) = Surface::new(material, viewer(cos), eta, 0.25, classes, Needs::ALL);
    let count = 200_000;
    let (mut sums, mut squares) = ([0.0; 2], [0.0; 2]);
    for path in 0..count {
        let sampled = surface.sample(interface, Rng::new(Stream::Camera, 21, path, 0).next4());
        let weight = f64::from(sampled.weight.x);
        sums[usize::from(sampled.transmitted)] += weight;
        squares[usize::from(sampled.transmitted)] += weight * weight;
    }
    let n = f64::from(count);
    [0, 1].map(|i| (sums[i] / n, ((squares[i] / n - (sums[i] / n).powi(2)).max(0.0) / n).sqrt()))
}

/// Rough glass never gains energy, its loss is that of single scattering, and both of its parts are what a quadrature
/// in f64 says. Four standard errors for 336 comparisons; 1e-3 is for the midpoints at grazing angles.
#[test]
fn rough_glass_scatters_what_quadrature_says() {
    let cases = [("entered", glass(1.5), 1.0 / 1.5), ("left", glass(1.5), 1.5), ("thin", pane(1.5), 1.0)];
    for (name, material, eta) in cases {
        println!("white glass, n = 1.5, {name}: reflected + transmitted (loss); columns: cosine {COSINES:?}");
        for roughness in [0.08, 0.15, 0.25, 0.4, 0.6, 0.8, 1.0] {
            let material = Material { roughness, ..material };
            let row = COSINES.map(|cos| {
                let sampled = glass_by_sampling(material, cos, eta, Classes::ALL);
                let exact = glass_by_quadrature(&material, f64::from(cos), f64::from(eta));
                for (what, (mean, error), exact) in
                    [("reflected", sampled[0], exact.0), ("transmitted", sampled[1], exact.1)]
                {
                    let off = (mean - exact).abs();
                    assert!(
                        off < 4.0 * error + 1e-3,
                        "{name}, {what}, roughness {roughness}, cos {cos}: {mean} +- {error}, {exact}"
                    );
                }
                let loss = 1.0 - exact.0 - exact.1;
                assert!(loss > -2e-3, "{name}, roughness {roughness}, cos {cos}: gains {}", -loss);
                format!("{:.3}+{:.3} ({:+.3})", exact.0, exact.1, loss)
            });
            println!("{roughness:.2}: {}", row.join("  "));
        }
    }
}

/// Each class alone scatters its own part: what paths behind a collection point, and gathers, see.
#[test]
fn rough_glass_reflects_in_one_class_and_transmits_in_the_other() {
    let material = Material { roughness: 0.5, ..glass(1.5) };
    let (reflected, transmitted) = glass_by_quadrature(&material, 0.5, 1.0 / 1.5);
    let parts = |classes| glass_by_sampling(material, 0.5, 1.0 / 1.5, classes);
    let (specular, other) = (parts(Classes::SPECULAR), parts(Classes::NON_SPECULAR));
    assert_eq!((specular[0].0, other[1].0), (0.0, 0.0));
    assert!((specular[1].0 - transmitted).abs() < 4.0 * specular[1].1 + 1e-3);
    assert!((other[0].0 - reflected).abs() < 4.0 * other[0].1 + 1e-3);
}

/// Where the index does not change, nothing is reflected and everything goes straight on.
#[test]
fn rough_glass_in_its_own_medium_is_invisible() {
    let material = Material { roughness: 0.5, ..glass(1.5) };
    let (surface, interface) = Surface::new(material, viewer(0.4), 1.0, 0.25, Classes::ALL, Needs::ALL);
    for path in 0..1_000 {
        let sampled = surface.sample(interface, Rng::new(Stream::Camera, 22, path, 0).next4());
        assert!(sampled.transmitted && (sampled.direction + viewer(0.4)).length() < 1e-5);
        assert!((sampled.weight - Vec3::ONE).abs().max_element() < 1e-5);
    }
}
