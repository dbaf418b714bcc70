//! Integrals over microfacet normals in f64, implemented independently of the kernels.

use std::f64::consts::TAU;

use caustics_kernels::interface::material::{FLAG_THIN, Material};
use glam::DVec3;

/// Mean of `value(h)` over normals h sampled from D(h) cos(h), by midpoints of the inverse distribution.
pub fn over_normals(alpha: f64, value: impl Fn(DVec3) -> f64) -> f64 {
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

/// Shares that white rough glass reflects and transmits, by quadrature in f64, independently of the kernels.
pub fn dielectric_by_quadrature(material: &Material, cos: f64, eta: f64) -> (f64, f64) {
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
