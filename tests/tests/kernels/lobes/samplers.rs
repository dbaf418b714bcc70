//! Every lobe, mixture and warp against its density by chi-square, and weights against f cos / pdf.

use caustics_kernels::interface::material::Material;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::math::{PI, warp};
use caustics_kernels::surface::class::Classes;
use caustics_kernels::surface::{Bsdf, DielectricInterface, ggx};
use caustics_tests::chi_square::{Fit, SphereCells};
use caustics_tests::scenes::{coated, glass, lambert, metal, pane};
use glam::Vec3;

use super::{seen_from, viewer};

const CELLS: SphereCells = SphereCells { rows: 48, columns: 24 };
const SAMPLES: u32 = 200_000;

/// Name, material, and index before over index behind.
pub fn cases() -> Vec<(&'static str, Material, f32)> {
    let rough = |roughness, ior| Material { roughness, ..glass(ior) };
    let tinted = Vec3::new(0.9, 0.5, 0.2);
    vec![
        ("lambert", lambert(0.5), 1.0),
        ("polished metal 0.1", metal(0.9, 0.1), 1.0),
        ("metal 0.3", metal(0.9, 0.3), 1.0),
        ("metal 0.8", metal(0.9, 0.8), 1.0),
        ("glossy metal 0.2", metal(0.9, 0.2), 1.0),
        ("coat 0.4", coated(0.5, 0.4), 1.0),
        ("glossy coat 0.2", coated(0.5, 0.2), 1.0),
        ("smooth coat", coated(0.5, 0.0), 1.0),
        ("half metal 0.5", Material { metallic: 0.5, ..coated(0.5, 0.5) }, 1.0),
        ("rough glass 0.2, entered", rough(0.2, 1.5), 1.0 / 1.5),
        ("rough glass 0.2, left", rough(0.2, 1.5), 1.5),
        ("rough glass 0.5, entered", Material { base_color: tinted, ..rough(0.5, 1.5) }, 1.0 / 1.5),
        ("rough glass 0.5, left", Material { base_color: tinted, ..rough(0.5, 1.5) }, 1.5),
        ("rough glass 1, entered", rough(1.0, 2.0), 0.5),
        ("rough glass 1, left", rough(1.0, 2.0), 2.0),
        ("rough glass 0.4 in water", rough(0.4, 1.5), 1.33 / 1.5),
        ("rough thin glass 0.4", Material { roughness: 0.4, ..pane(1.5) }, 1.0),
        ("half glass 0.5 over half metal", half_of_all(0.5), 1.0 / 1.5),
        ("half glass 0.2 over half metal", half_of_all(0.2), 1.5),
        ("smooth half glass over half metal", half_of_all(0.0), 1.5),
        ("smooth thin glass", Material { base_color: tinted, ..pane(1.5) }, 1.0),
    ]
}

/// Every lobe at once.
fn half_of_all(roughness: f32) -> Material {
    Material { metallic: 0.3, transmission: 0.5, ..coated(0.6, roughness) }
}

/// Every case at every cosine, with both ways to choose among the lobes of rough glass.
fn seen(cosines: &[f32]) -> Vec<(String, Material, Bsdf, DielectricInterface)> {
    let mut all = Vec::new();
    for (name, material, eta) in cases() {
        for &cos in cosines {
            let (surface, interface) = seen_from(material, viewer(cos), eta, false);
            all.push((format!("{name}, cos {cos}"), material, surface, interface));
            if is_rough_dielectric(&material) {
                let (surface, interface) = seen_from(material, viewer(cos), eta, true);
                all.push((format!("{name}, cos {cos}, by class"), material, surface, interface));
            }
        }
    }
    all
}

fn is_rough_dielectric(material: &Material) -> bool {
    material.transmission > 0.0 && material.roughness > 0.0
}

/// Counts of a class's non-delta samples by cell; asserts that each leaves to the side that it claims.
fn count(surface: &Bsdf, interface: DielectricInterface, class: Classes) -> Vec<u32> {
    let mut seen = vec![0; CELLS.count()];
    for path in 0..SAMPLES {
        let sampled = surface.sample(interface, Rng::new(Stream::Light, 4, path, 0).next4());
        let lost = sampled.transmitted != (sampled.direction.z < 0.0);
        if sampled.class == class && sampled.pdf_solid_angle > 0.0 && !lost {
            seen[CELLS.cell_index(sampled.direction)] += 1;
        }
    }
    seen
}

/// Expected counts. A narrow lobe needs more midpoints, above all around the normal, where a grazing view squeezes it.
fn expect(surface: &Bsdf, class: Classes, roughness: f32) -> Vec<f64> {
    let sub = match roughness {
        ..0.15 => [72, 288],
        ..0.3 => [40, 96],
        _ => [16, 24],
    };
    CELLS.integrate(sub, |d| f64::from(surface.eval(d, class).pdf_solid_angle) * f64::from(SAMPLES))
}

/// Samples of a class fall into cells of the sphere by their density, the choice of a lobe included.
#[test]
fn lobe_samples_follow_their_density() {
    densities_hold(&[0.5]);
}

fn densities_hold(cosines: &[f32]) {
    for (name, material, surface, interface) in seen(cosines) {
        for class in [Classes::SPECULAR, Classes::NON_SPECULAR] {
            let counts = count(&surface, interface, class);
            // A class without a non-delta lobe: nothing may be sampled, and the density must be 0.
            if counts.iter().all(|count| *count == 0) {
                let towards = [Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.6, 0.0, -0.8)];
                assert!(towards.iter().all(|d| surface.eval(*d, class).pdf_solid_angle == 0.0), "{name}");
                continue;
            }
            let fit = Fit::new(&counts, &expect(&surface, class, material.roughness));
            println!("{name}, class {}: {:.0} of {}", class.0, fit.chi_square, fit.cells);
            assert!(fit.passes(), "{name}, class {}: {fit:?}", class.0);
        }
    }
}

/// The comparer detects a roughness that is 5 % too large.
#[test]
fn detects_samples_of_another_roughness() {
    for (material, eta) in [(metal(0.9, 0.4), 1.0), (Material { roughness: 0.4, ..glass(1.5) }, 1.0 / 1.5)] {
        let (surface, interface) = seen_from(material, viewer(0.5), eta, true);
        let other = Material { roughness: 0.42, ..material };
        for class in [Classes::SPECULAR, Classes::NON_SPECULAR] {
            if surface.class_probability(class) > 0.1 {
                let expected = expect(&seen_from(other, viewer(0.5), eta, true).0, class, 0.4);
                assert!(!Fit::new(&count(&surface, interface, class), &expected).passes());
            }
        }
    }
}

/// The share of samples of a class is its probability; four standard errors of the binomial law.
#[test]
fn classes_are_sampled_with_their_probability() {
    for (name, material, eta) in cases() {
        for cos in [0.98, 0.15] {
            let (surface, interface) = seen_from(material, viewer(cos), eta, true);
            let class_of =
                |path| surface.sample(interface, Rng::new(Stream::Light, 6, path, 0).next4()).class;
            let taken = (0..SAMPLES).filter(|&path| class_of(path) == Classes::SPECULAR).count();
            let probability = f64::from(surface.class_probability(Classes::SPECULAR));
            let both = probability + f64::from(surface.class_probability(Classes::NON_SPECULAR));
            assert!((both - 1.0).abs() < 1e-5, "{name}: {both}");
            let error = (probability * (1.0 - probability) / f64::from(SAMPLES)).max(0.0).sqrt();
            let share = taken as f64 / f64::from(SAMPLES);
            assert!((share - probability).abs() <= 4.0 * error + 1e-6, "{name} {cos}: {share} {probability}");
        }
    }
}

/// A sample's weight is f cos / pdf of its own class, to an ulp or two.
#[test]
fn weights_are_f_cos_over_pdf_of_their_class() {
    for (name, material, surface, interface) in seen(&[0.98, 0.5, 0.15]) {
        // A delta lobe has no density.
        if material.transmission == 1.0 && material.roughness == 0.0 {
            continue;
        }
        let mut weighed = 0;
        for path in 0..20_000 {
            let sampled = surface.sample(interface, Rng::new(Stream::Light, 5, path, 0).next4());
            if sampled.pdf_solid_angle == 0.0 || sampled.transmitted != (sampled.direction.z < 0.0) {
                continue;
            }
            weighed += 1;
            let lobes = surface.eval(sampled.direction, sampled.class);
            assert_eq!(lobes.pdf_solid_angle, sampled.pdf_solid_angle, "{name}");
            let weight = lobes.f * sampled.direction.z.abs() / lobes.pdf_solid_angle;
            let max_weight = weight.max_element().max(1e-6);
            assert!(
                (weight - sampled.weight).abs().max_element() <= 1e-6 * max_weight,
                "{name}: {sampled:?}"
            );
        }
        assert!(weighed > 1_000, "{name}: {weighed}");
    }
}

/// Compares the warps of directions with their densities.
#[test]
fn warps_follow_their_density() {
    let counts = |warp: &dyn Fn(f32, f32) -> Vec3| {
        let mut seen = vec![0; CELLS.count()];
        for path in 0..SAMPLES {
            let u = Rng::new(Stream::Light, 8, path, 0).next4();
            seen[CELLS.cell_index(warp(u.x, u.y))] += 1;
        }
        seen
    };
    let check = |name: &str, warp: &dyn Fn(f32, f32) -> Vec3, pdf: &dyn Fn(Vec3) -> f32, sub| {
        let expected = CELLS.integrate(sub, |d| f64::from(pdf(d)) * f64::from(SAMPLES));
        let fit = Fit::new(&counts(warp), &expected);
        println!("{name}: {:.0} of {}", fit.chi_square, fit.cells);
        assert!(fit.passes(), "{name}: {fit:?}");
    };
    check("sphere", &warp::uniform_sphere, &|_| 0.25 / PI, [1, 1]);
    check("hemisphere", &warp::cosine_hemisphere, &|d| warp::cosine_hemisphere_pdf(d.z), [4, 1]);
    for (alpha, cos) in [(0.15, 0.9), (0.3, 0.9), (0.3, 0.1), (1.0, 0.5), (1.0, 0.02)] {
        let to_viewer = viewer(cos);
        // Visible normals: the density of mirrored directions over the Jacobian 1 / (4 cos).
        let pdf = |half: Vec3| {
            let cos = to_viewer.dot(half);
            if half.z <= 0.0 || cos <= 0.0 {
                0.0
            } else {
                4.0 * cos * ggx::visible_pdf(to_viewer, half, alpha)
            }
        };
        let name = format!("visible normals, alpha {alpha}, cos {cos}");
        check(&name, &|u, v| warp::visible_ggx_normal(to_viewer, alpha, u, v), &pdf, [64, 32]);
    }
}

/// Points on a triangle fall evenly into the cells of an 8 x 8 x 2 subdivision.
#[test]
fn points_on_a_triangle_are_uniform() {
    let mut seen = vec![0; 128];
    for path in 0..SAMPLES {
        let u = Rng::new(Stream::Light, 9, path, 0).next4();
        let b = warp::uniform_triangle(u.x, u.y) * 8.0;
        let (x, y) = (b.x as usize, b.y as usize);
        let upper = b.x.fract() + b.y.fract() > 1.0;
        seen[(y.min(7) * 8 + x.min(7)) * 2 + usize::from(upper)] += 1;
    }
    let inside = |i: usize| i / 16 + i / 2 % 8 + i % 2 < 8;
    let expected: Vec<f64> =
        (0..128).map(|i| if inside(i) { f64::from(SAMPLES) / 64.0 } else { 0.0 }).collect();
    assert_eq!(expected.iter().filter(|&&e| e > 0.0).count(), 64);
    let fit = Fit::new(&seen, &expected);
    assert!(fit.passes(), "{fit:?}");
}

mod long {
    use super::*;

    #[test]
    #[ignore = "the same from other directions: ten seconds"]
    fn lobe_samples_follow_their_density_from_above_and_at_a_slant() {
        densities_hold(&[0.98, 0.15]);
    }
}
