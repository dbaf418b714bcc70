//! Lobes through `Bsdf`: energy, reciprocity, and every sampler against its density.

mod dispersion;
mod furnace;
mod lights;
mod moments;
mod samplers;

use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::material::Material;
use caustics_kernels::math::frame::ShadingFrame;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::math::warp::cosine_hemisphere;
use caustics_kernels::surface::class::Classes;
use caustics_kernels::surface::dispersion::Indices;
use caustics_kernels::surface::{Bsdf, DielectricInterface, fresnel};
use caustics_tests::scenes::{coated, glass, lambert, metal, pane};
use glam::Vec3;

fn viewer(cos: f32) -> Vec3 {
    Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
}

/// All lobes of a material, seen from a direction; with `divides`, the choice among them has a known probability for
/// each class.
fn seen_from(material: Material, to_previous: Vec3, eta: f32, divides: bool) -> (Bsdf, DielectricInterface) {
    Bsdf::new(material, to_previous, Indices::new(eta), 0.25, Classes::ALL, divides, Features::ALL)
}

/// Mean weight of samples seen at `cos` (the directional albedo), and its standard error.
fn albedo(material: Material, cos: f32) -> (f64, f64) {
    let (surface, interface) = seen_from(material, viewer(cos), 1.0, false);
    let count = 100_000;
    let (mut sum, mut squares) = (0.0, 0.0);
    for path in 0..count {
        let sampled = surface.sample(interface, Rng::new(Stream::Camera, 1, path, 0).next4());
        let passes = sampled.transmitted || sampled.direction.z > 0.0;
        let weight = if passes { f64::from(sampled.weight.x) } else { 0.0 };
        sum += weight;
        squares += weight * weight;
    }
    let n = f64::from(count);
    (sum / n, ((squares / n - (sum / n).powi(2)).max(0.0) / n).sqrt())
}

const COSINES: [f32; 6] = [1.0, 0.8, 0.5, 0.25, 0.1, 0.03];

/// Equal random numbers sample equal light at a wall, whichever side of an axis a rounding puts its normal on.
#[test]
fn sampled_directions_do_not_depend_on_roundings_of_an_axis_aligned_normal() {
    for axis in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
        let frame = ShadingFrame::new(axis);
        for nudge in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|nudge| [1e-7 * nudge, -1e-7 * nudge]) {
            let nudged = ShadingFrame::new((axis + nudge).normalize());
            let local = Vec3::new(0.6, 0.0, 0.8);
            let apart = (nudged.to_world(local) - frame.to_world(local)).length();
            assert!(apart < 1e-6, "{axis} and {nudge}: {apart}");
        }
    }
}

#[test]
fn lambert_reflects_its_albedo() {
    for cos in COSINES {
        let (mean, _) = albedo(lambert(0.75), cos);
        assert!((mean - 0.75).abs() < 1e-5, "{cos}: {mean}");
    }
}

#[test]
fn delta_mirror_and_glass_have_albedo_1() {
    for cos in COSINES {
        let (mean, _) = albedo(metal(1.0, 0.0), cos);
        assert!((mean - 1.0).abs() < 1e-5, "mirror {cos}: {mean}");
        for eta in [1.0 / 1.5, 1.5, 1.33 / 1.5] {
            let (surface, interface) = seen_from(glass(1.5), viewer(cos), eta, false);
            let mut reflected = 0;
            for path in 0..20_000 {
                let sampled = surface.sample(interface, Rng::new(Stream::Camera, 2, path, 0).next4());
                assert!((sampled.weight.x - 1.0).abs() < 1e-4);
                assert!((sampled.direction.length() - 1.0).abs() < 1e-5);
                reflected += u32::from(!sampled.transmitted);
                if sampled.transmitted {
                    // Snell's law: the direction is on the other side, in the plane of incidence.
                    assert!((sampled.direction.x + eta * viewer(cos).x).abs() < 1e-5);
                    assert!(sampled.direction.z < 0.0 && sampled.direction.y == 0.0);
                }
            }
            // Four standard errors for the 18 cases here.
            let r = f64::from(fresnel::dielectric_reflectance(cos, eta));
            let error = (r * (1.0 - r) / 20_000.0).sqrt();
            assert!((f64::from(reflected) / 20_000.0 - r).abs() <= 4.0 * error + 1e-6, "{cos} {eta}");
        }
    }
}

/// Single scattering loses light that other facets would scatter on, and gains nothing.
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
    // Single-scattering GGX by quadrature over visible normals in f64; at normal incidence and alpha = 1 it is 1 - ln
    // 2.
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

/// 1e-3 is for sums in f32.
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
    assert!(worst <= 1.0 + 1e-3, "a coated white surface reflects {worst:.3} of the light");
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
                let (surface, _) = seen_from(material, from, 1.0, false);
                surface.eval(to, Classes::SPECULAR).f.x + surface.eval(to, Classes::NON_SPECULAR).f.x
            };
            let (there, back) = (f(a, b), f(b, a));
            assert!((there - back).abs() <= 1e-4 * there.max(back), "{material:?} {a} {b}: {there} {back}");
        }
    }
}

/// Flux transport f (see `rough_dielectric`) from `a` above to `b` below and back: f n^2 of the exit side is equal both
/// ways. 1e-3 is for the facet's normal, which a narrow lobe loses to rounding. Facets at grazing incidence are left
/// out, because Fresnel's formula has the root of an ulp there.
#[test]
fn rough_transmission_is_reciprocal_but_for_the_square_of_the_index() {
    let flip = |v: Vec3| Vec3::new(v.x, v.y, -v.z);
    let cases = [
        (Material { roughness: 0.2, ..glass(1.5) }, 1.0 / 1.5),
        (Material { roughness: 0.6, ..glass(1.5) }, 1.0 / 1.5),
        (Material { roughness: 0.6, ..glass(1.5) }, 1.5),
        (Material { roughness: 0.9, ..glass(1.33) }, 1.33),
        (Material { roughness: 0.5, ..pane(1.5) }, 1.0),
    ];
    for (material, eta) in cases {
        let f = |from: Vec3, to: Vec3, eta: f32| {
            seen_from(material, from, eta, false).0.eval(to, Classes::SPECULAR).f.x
        };
        let (mut compared, mut worst) = (0, 0.0_f32);
        for path in 0..50_000 {
            let u = Rng::new(Stream::Camera, 3, path, 0).next4();
            let (a, b) = (cosine_hemisphere(u.x, u.y), flip(cosine_hemisphere(u.z, u.w)));
            if a.z.min(-b.z) < 1e-3 {
                continue;
            }
            let along = a * eta + b;
            let (cos, cos_behind) = (a.dot(along) / along.length(), b.dot(along) / along.length());
            if eta != 1.0 && cos.abs().min(cos_behind.abs()) < 0.1 {
                continue;
            }
            let (there, back) = (f(a, b, eta) * eta * eta, f(flip(b), flip(a), 1.0 / eta));
            if there.max(back) > 0.0 {
                compared += 1;
                worst = worst.max((there - back).abs() / there.max(back));
            }
        }
        println!("roughness {}, eta {eta:.3}: {compared} pairs, worst {worst:.1e}", material.roughness);
        assert!(compared > 5_000 && worst < 1e-3, "{material:?}: {worst}");
    }
}
