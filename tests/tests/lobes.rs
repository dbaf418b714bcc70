//! Lobes through `Surface`: energy, reciprocity, and every sampler against its density.

use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::needs::Needs;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::math::warp::cosine_hemisphere;
use caustics_kernels::surface::class::Classes;
use caustics_kernels::surface::{Surface, fresnel};
use caustics_tests::scenes::{coated, glass, lambert, metal};
use glam::Vec3;
use std::f64::consts::{PI, TAU};

fn viewer(cos: f32) -> Vec3 {
    Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
}

/// Mean weight of samples seen at `cos` (the directional albedo), and its standard error.
fn albedo(material: Material, cos: f32) -> (f64, f64) {
    let (surface, glass) = Surface::new(material, viewer(cos), 1.0, 0.25, Classes::ALL, Needs::ALL);
    let count = 100_000;
    let (mut sum, mut squares) = (0.0, 0.0);
    for path in 0..count {
        let sampled = surface.sample(glass, Rng::new(Stream::Camera, 1, path, 0).next4());
        let passes = sampled.transmitted || sampled.direction.z > 0.0;
        let weight = if passes { f64::from(sampled.weight.x) } else { 0.0 };
        sum += weight;
        squares += weight * weight;
    }
    let n = f64::from(count);
    (sum / n, ((squares / n - (sum / n).powi(2)).max(0.0) / n).sqrt())
}

const COSINES: [f32; 6] = [1.0, 0.8, 0.5, 0.25, 0.1, 0.03];

#[test]
fn lambert_reflects_its_albedo() {
    for cos in COSINES {
        let (mean, _) = albedo(lambert(0.75), cos);
        assert!((mean - 0.75).abs() < 1e-5, "{cos}: {mean}");
    }
}

#[test]
fn delta_mirror_and_glass_lose_nothing() {
    for cos in COSINES {
        let (mean, _) = albedo(metal(1.0, 0.0), cos);
        assert!((mean - 1.0).abs() < 1e-5, "mirror {cos}: {mean}");
        for eta in [1.0 / 1.5, 1.5, 1.33 / 1.5] {
            let (surface, interface) =
                Surface::new(glass(1.5), viewer(cos), eta, 0.25, Classes::ALL, Needs::ALL);
            let mut reflected = 0;
            for path in 0..20_000 {
                let sampled = surface.sample(interface, Rng::new(Stream::Camera, 2, path, 0).next4());
                assert!((sampled.weight.x - 1.0).abs() < 1e-4);
                assert!((sampled.direction.length() - 1.0).abs() < 1e-5);
                reflected += u32::from(!sampled.transmitted);
                if sampled.transmitted {
                    // Snell, on the other side of the normal, in the plane of incidence.
                    assert!((sampled.direction.x + eta * viewer(cos).x).abs() < 1e-5);
                    assert!(sampled.direction.z < 0.0 && sampled.direction.y == 0.0);
                }
            }
            // Four standard errors for the 18 cases here.
            let r = f64::from(fresnel::dielectric(cos, eta));
            let error = (r * (1.0 - r) / 20_000.0).sqrt();
            assert!((f64::from(reflected) / 20_000.0 - r).abs() <= 4.0 * error + 1e-6, "{cos} {eta}");
        }
    }
}

/// Single scattering loses what other facets would pass on; nothing is gained.
#[test]
fn white_metal_never_gains_energy() {
    println!("directional albedo of GGX with F0 = 1; rows: roughness, columns: cosine {COSINES:?}");
    for roughness in [0.08, 0.15, 0.25, 0.4, 0.6, 0.8, 1.0] {
        let row = COSINES.map(|cos| albedo(metal(1.0, roughness), cos));
        println!("{roughness:.2}: {}", row.map(|(mean, _)| format!("{mean:.4}")).join(" "));
        for (cos, (mean, error)) in COSINES.into_iter().zip(row) {
            assert!(mean <= 1.0 + 3.0 * error + 1e-5, "roughness {roughness}, cos {cos}: {mean}");
        }
    }
    // Single-scattering GGX by quadrature over visible normals in f64; seen straight at alpha = 1 it is 1 - ln 2.
    let known = [
        (0.25, 1.0, 0.9957),
        (0.25, 0.25, 0.9620),
        (0.4, 0.5, 0.9264),
        (0.6, 0.1, 0.8818),
        (1.0, 0.5, 0.4507),
        (1.0, 1.0, 1.0 - 2.0_f64.ln()),
    ];
    for (roughness, cos, expected) in known {
        let (mean, error) = albedo(metal(1.0, roughness), cos);
        assert!((mean - expected).abs() < 3.0 * error + 1e-4, "{roughness} {cos}: {mean} {expected}");
    }
}

/// 1e-3 is for the sums in f32.
#[test]
fn coat_over_white_lambert_never_gains_energy() {
    println!(
        "directional albedo of a coat (n = 1.5) over white; rows: roughness, columns: cosine {COSINES:?}"
    );
    let mut worst = 0.0_f64;
    for roughness in [0.0, 0.1, 0.25, 0.4, 0.7, 1.0] {
        let row = COSINES.map(|cos| albedo(coated(1.0, roughness), cos));
        println!("{roughness:.2}: {}", row.map(|(mean, _)| format!("{mean:.4}")).join(" "));
        worst = row.iter().fold(worst, |worst, (mean, error)| worst.max(mean - 3.0 * error));
    }
    assert!(worst <= 1.0 + 1e-3, "a coated white surface reflects {worst:.3} of what it gets");
}

#[test]
fn lobes_are_reciprocal() {
    let materials = [
        metal(0.7, 0.1),
        metal(0.7, 0.5),
        coated(0.6, 0.3),
        coated(0.6, 0.9),
        coated(0.6, 0.0),
        lambert(0.6),
    ];
    for material in materials {
        for path in 0..20_000 {
            let u = Rng::new(Stream::Camera, 3, path, 0).next4();
            let (a, b) = (cosine_hemisphere(u.x, u.y), cosine_hemisphere(u.z, u.w));
            if a.z.min(b.z) < 1e-3 {
                continue;
            }
            let f = |from: Vec3, to: Vec3| {
                let (surface, _) = Surface::new(material, from, 1.0, 0.25, Classes::ALL, Needs::ALL);
                surface.eval(to, Classes::SPECULAR).f.x + surface.eval(to, Classes::NON_SPECULAR).f.x
            };
            let (there, back) = (f(a, b), f(b, a));
            assert!((there - back).abs() <= 1e-4 * there.max(back), "{material:?} {a} {b}: {there} {back}");
        }
    }
}

/// Upper bound of chi-square at a level of 1e-5 (z = 4.26) [Wilson and Hilferty 1931].
fn chi_square_bound(degrees: f64) -> f64 {
    let a = 2.0 / (9.0 * degrees);
    degrees * (1.0 - a + 4.26 * a.sqrt()).powi(3)
}

/// Samples of a class fall into 24 x 24 cells of the hemisphere as its density says, the choice of lobe included.
#[test]
fn samples_follow_their_density() {
    let cases = [
        ("lambert", lambert(0.5)),
        ("metal 0.3", metal(0.9, 0.3)),
        ("metal 0.8", metal(0.9, 0.8)),
        ("glossy metal 0.2", metal(0.9, 0.2)),
        ("coat 0.4", coated(0.5, 0.4)),
        ("glossy coat 0.2", coated(0.5, 0.2)),
        ("half metal 0.5", Material { metallic: 0.5, ..coated(0.5, 0.5) }),
    ];
    const CELLS: usize = 24;
    const SUB: usize = 24;
    let count = 200_000_u32;
    for (name, material) in cases {
        for cos in [0.98, 0.5, 0.15] {
            let (surface, interface) =
                Surface::new(material, viewer(cos), 1.0, 0.25, Classes::ALL, Needs::ALL);
            for class in [Classes::SPECULAR, Classes::NON_SPECULAR] {
                if surface.class_chance(class) == 0.0 {
                    continue;
                }
                // Cells are even in cosine and azimuth: equal solid angles.
                let mut seen = vec![0_u32; CELLS * CELLS];
                for path in 0..count {
                    let sampled = surface.sample(interface, Rng::new(Stream::Light, 4, path, 0).next4());
                    if sampled.class != class || sampled.direction.z <= 0.0 {
                        continue;
                    }
                    let d = sampled.direction.as_dvec3();
                    let again = surface.eval(sampled.direction, class).pdf_solid_angle;
                    assert_eq!(again, sampled.pdf_solid_angle, "{name}: pdf of the sample and of eval");
                    let row = ((1.0 - d.z) * CELLS as f64) as usize;
                    let column = (d.y.atan2(d.x) / TAU + 0.5) * CELLS as f64;
                    seen[row.min(CELLS - 1) * CELLS + (column as usize).min(CELLS - 1)] += 1;
                }
                let mut expected = vec![0.0_f64; CELLS * CELLS];
                let fine = (CELLS * SUB) as f64;
                for i in 0..CELLS * SUB {
                    let z = 1.0 - (i as f64 + 0.5) / fine;
                    for j in 0..CELLS * SUB {
                        let (sin, cos) = (((j as f64 + 0.5) / fine - 0.5) * TAU).sin_cos();
                        let r = (1.0 - z * z).sqrt();
                        let direction = Vec3::new((r * cos) as f32, (r * sin) as f32, z as f32);
                        let pdf = surface.eval(direction, class).pdf_solid_angle;
                        expected[i / SUB * CELLS + j / SUB] +=
                            f64::from(pdf) * 2.0 * PI / (fine * fine) * f64::from(count);
                    }
                }
                let (mut chi_square, mut cells, mut few, mut few_expected) = (0.0, 0.0, 0.0, 0.0);
                for (&n, &e) in seen.iter().zip(&expected) {
                    if e < 20.0 {
                        few += f64::from(n);
                        few_expected += e;
                    } else {
                        chi_square += (f64::from(n) - e).powi(2) / e;
                        cells += 1.0;
                    }
                }
                if few_expected > 5.0 {
                    chi_square += (few - few_expected).powi(2) / few_expected;
                    cells += 1.0;
                }
                let bound = chi_square_bound(cells);
                println!("{name}, cos {cos}, class {}: {chi_square:.0} of {cells} cells", class.0);
                assert!(chi_square < bound, "{name}, cos {cos}: {chi_square} > {bound}");
            }
        }
    }
}
