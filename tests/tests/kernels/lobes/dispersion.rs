//! Smooth faces that refract channels differently.

use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::material::Material;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::surface::class::Classes;
use caustics_kernels::surface::dispersion::Indices;
use caustics_kernels::surface::{Bsdf, fresnel};
use caustics_tests::scenes::{coated, flint};
use glam::Vec3;

use super::viewer;

/// Indices of `flint(1.5)`, above over below, or below over above.
fn indices(carried: Vec3, inside: bool) -> Indices {
    let behind = Vec3::new(1.475, 1.5, 1.525);
    let etas = if inside { behind } else { 1.0 / behind };
    Indices { eta: etas.y, etas, carried: carried / carried.element_sum(), is_dispersive: true }
}

/// Throughputs of the path before a face. The critical angles of the channels have cosines of 0.735, 0.745 and 0.755.
const CARRIED: [Vec3; 4] = [Vec3::ONE, Vec3::new(0.7, 0.25, 0.05), Vec3::new(0.6, 0.4, 0.0), Vec3::Z];
const COSINES: [f32; 5] = [1.0, 0.76, 0.75, 0.74, 0.3];

/// Each sample of white glass keeps the sum of the path's channels. It reflects all channels by their own reflectance,
/// or transmits one by its own index. In expectation each channel is reflected and transmitted by its own Fresnel
/// formula.
#[test]
fn smooth_faces_reflect_all_channels_and_transmit_one() {
    let count = 100_000;
    for (carried, inside) in CARRIED.into_iter().flat_map(|carried| [(carried, false), (carried, true)]) {
        for cos in COSINES {
            let indices = indices(carried, inside);
            let carried = indices.carried;
            let (surface, interface) =
                Bsdf::new(flint(1.5), viewer(cos), indices, 0.25, Classes::ALL, false, Features::ALL);
            let exact = indices.etas.to_array().map(|eta| fresnel::dielectric_reflectance(cos, eta));
            let (mut reflected, mut transmitted) = (Vec3::ZERO, Vec3::ZERO);
            for path in 0..count {
                let u = Rng::new(Stream::Camera, 51, path, 0).next4();
                let sampled = surface.sample(interface, u);
                let carries = carried * sampled.weight;
                assert!((carries.element_sum() - 1.0).abs() < 1e-5, "{carries}");
                if !sampled.transmitted {
                    reflected += carries / count as f32;
                    let ratio = Vec3::from(exact) / sampled.weight;
                    assert!((ratio - ratio.x).abs().max_element() < 1e-4 * ratio.x);
                    continue;
                }
                transmitted += carries / count as f32;
                let channel = (0..3).find(|&channel| carries[channel] > 0.0).expect("it carries light");
                assert_eq!(carries.element_sum(), carries[channel], "it has one channel");
                assert_eq!(sampled.eta, indices.etas[channel]);
                // Snell's law.
                assert!((sampled.direction.x + sampled.eta * viewer(cos).x).abs() < 1e-5);
            }
            for channel in 0..3 {
                let share = carried[channel];
                let expected = [share * exact[channel], share * (1.0 - exact[channel])];
                for (found, expected) in [reflected, transmitted].into_iter().zip(expected) {
                    // Four standard errors of the binomial law; sums of 100,000 in f32 are good to 1e-3.
                    let error = (expected * (1.0 - expected).max(0.0) / count as f32).sqrt();
                    let off = (found[channel] - expected).abs();
                    assert!(off < 4.0 * error + 1e-3 * expected + 1e-6, "{carried} {cos} {inside} {channel}");
                }
            }
        }
    }
}

/// The other lobes of a partly dispersive surface keep all channels.
#[test]
fn lobes_beside_smooth_dispersive_glass_keep_all_channels() {
    let material = Material { metallic: 0.3, transmission: 0.5, dispersion: 2.0, ..coated(0.6, 0.0) };
    let indices = indices(Vec3::ONE, false);
    let (surface, interface) =
        Bsdf::new(material, viewer(0.6), indices, 0.25, Classes::ALL, false, Features::ALL);
    let (mut whole, mut parted) = (0, 0);
    for path in 0..10_000 {
        let sampled = surface.sample(interface, Rng::new(Stream::Camera, 52, path, 0).next4());
        let single = sampled.weight.max_element() == sampled.weight.element_sum();
        assert_eq!(single, sampled.transmitted, "{sampled:?}");
        whole += u32::from(!single);
        parted += u32::from(single);
    }
    assert!(whole > 5_000 && parted > 1_000, "{whole} {parted}");
}

/// The ledger's albedo of such a face is the mean weight of its samples, for each channel.
#[test]
fn the_albedo_of_a_smooth_dispersive_face_is_its_mean_weight() {
    let material = Material { base_color: Vec3::new(0.9, 0.5, 0.2), ..flint(1.5) };
    for cos in COSINES {
        let indices = indices(Vec3::new(0.5, 0.3, 0.2), true);
        let (surface, interface) =
            Bsdf::new(material, viewer(cos), indices, 0.25, Classes::ALL, false, Features::ALL);
        let count = 200_000;
        let weight = |path| surface.sample(interface, Rng::new(Stream::Camera, 53, path, 0).next4()).weight;
        let mut sums = [[0.0_f64; 2]; 3];
        for path in 0..count {
            for (sum, weight) in sums.iter_mut().zip(weight(path).to_array()) {
                sum[0] += f64::from(weight);
                sum[1] += f64::from(weight).powi(2);
            }
        }
        let albedo = surface.albedo(Classes::ALL, glam::Vec4::splat(0.5));
        for (channel, [sum, squares]) in sums.into_iter().enumerate() {
            let (mean, n) = (sum / f64::from(count), f64::from(count));
            let error = ((squares / n - mean * mean).max(0.0) / n).sqrt();
            assert!(
                (mean - f64::from(albedo[channel])).abs() < 4.0 * error + 1e-5,
                "{cos} {channel}: {mean}"
            );
        }
    }
}
