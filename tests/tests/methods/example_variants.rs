//! The example variants of `tests/example_variants` from outside of the kernels: each renders once, and does what the
//! head of its file states. CONTRIBUTING.md quotes them. The light and the lobe must stand inside of the kernels:
//! `.ci/new-variant --check` compiles them.

use caustics::metric::comparison::{Comparison, Viewing};
use caustics::metric::pixels::{Estimate, Pixels};
use caustics::render_config::{Paths, Radius, RenderConfig};
// The metric's file expects these modules beside it, as in its own folder.
use caustics::metric::{comparison, pixels};
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::denoiser;
use caustics_kernels::emission;
use caustics_kernels::gather::Index;
use caustics_kernels::gather::variant::{PHOTONS_GRID, Variant};
use caustics_kernels::history;
use caustics_kernels::method::Method;
use caustics_kernels::method::basic::BASIC;
use caustics_tests::parity::load;
use caustics_tests::scenes::{Builder, lambert, metal};
use glam::{DVec3, Vec3};

#[path = "../../example_variants/even.rs"]
mod even;
#[path = "../../example_variants/halved.rs"]
mod halved;
#[path = "../../example_variants/largest.rs"]
mod largest;
#[path = "../../example_variants/pairs.rs"]
mod pairs;
#[path = "../../example_variants/same_pixel.rs"]
mod same_pixel;
#[path = "../../example_variants/stripes.rs"]
mod stripes;

/// Passes of the gather; the list of the kernels generates them for gathers of its own.
mod stripes_passes {
    use super::stripes::Stripes;

    caustics_kernels::index_pass!(stripes, Stripes);
    caustics_kernels::gather_pass!(stripes, Stripes);
}

static STRIPES: Variant =
    Variant { index: &stripes_passes::INDEX, gather: &stripes_passes::GATHER, ..stripes::Stripes::VARIANT };

fn config() -> RenderConfig {
    RenderConfig { width: 48, height: 32, light_paths: Paths::Count(2000), ..RenderConfig::default() }
}

/// The two layers of a frame.
#[derive(PartialEq)]
struct Layers {
    path: Vec<Vec3>,
    caustics: Vec<Vec3>,
}

/// Layers of the first frames of a still scene, one after the other.
fn frames(
    scene: &Scene,
    config: &RenderConfig,
    method: &'static Method,
    gather: &'static Variant,
    count: u32,
) -> Vec<Layers> {
    let cpu = RunnerChoice::Cpu { threads: 0 };
    let features = scene.features(config.specular_roughness);
    let config = RenderConfig { method, gather: Some(gather), ..config.clone() };
    let mut session =
        Session::new(&cpu, scene, &scene.cameras[0], &config, features).expect("a session opens");
    let mut frame = |index| {
        session.frame(index).expect("a frame runs");
        let [path, caustics] =
            ["path_radiance", "caustic_radiance"].map(|layer| session.read(layer).expect("a layer"));
        Layers { path, caustics }
    };
    (0..count).map(&mut frame).collect()
}

/// The first frame of the Cornell box.
fn frame(config: &RenderConfig, method: &'static Method, gather: &'static Variant) -> Layers {
    let mut frames = frames(&load("cornell-box"), config, method, gather, 1);
    let layers = frames.remove(0);
    assert!(layers.path.iter().chain(&layers.caustics).all(|value| value.is_finite()));
    layers
}

fn sum(layer: &[Vec3]) -> f32 {
    layer.iter().map(|value| value.element_sum()).sum()
}

#[test]
fn example_gather_matches_another_gather_to_the_bit() {
    let expected = frame(&config(), &BASIC, &PHOTONS_GRID);
    assert!(sum(&expected.caustics) > 0.0);
    assert!(frame(&config(), &BASIC, &STRIPES) == expected);
}

#[test]
fn example_method_renders_like_half_the_radius() {
    let whole = frame(&config(), &BASIC, &PHOTONS_GRID);
    let half = frame(&RenderConfig { radius: Radius::Px(0.5), ..config() }, &BASIC, &PHOTONS_GRID);
    let found = frame(&config(), &halved::HALVED, &PHOTONS_GRID);
    assert!(found.path == half.path && found.caustics == half.caustics);
    assert!(found.caustics != whole.caustics);
}

#[test]
fn example_denoiser_gives_pairs_of_pixels_their_mean() {
    let noisy = frame(&RenderConfig { denoiser: &denoiser::ATROUS, ..config() }, &BASIC, &PHOTONS_GRID);
    let found = frame(&RenderConfig { denoiser: &pairs::PAIRS, ..config() }, &BASIC, &PHOTONS_GRID);
    assert!(found.path.chunks(2).all(|pair| pair[0] == pair[1]));
    assert!(found.path.chunks(4).any(|pairs| pairs[0] != pairs[2]), "the scene is not flat");
    assert!(found.path != noisy.path);
    let plain = frame(&RenderConfig { denoiser: &denoiser::NONE, ..config() }, &BASIC, &PHOTONS_GRID);
    // Sums of 1,536 pixels in f32: rounding alone.
    assert!((sum(&found.path) / sum(&plain.path) - 1.0).abs() < 1e-4);
    assert!(found.caustics == plain.caustics);
}

/// A large weak light and a small strong one above a mirror on a floor.
fn two_lights() -> Scene {
    let mut b = Builder::default();
    let [floor, mirror] = [lambert(0.7), metal(0.9, 0.0)].map(|material| b.material(material));
    b.panel(floor, DVec3::ZERO, DVec3::Z, DVec3::X);
    b.panel(mirror, DVec3::new(0.0, 0.5, -0.5), 0.5 * DVec3::X, 0.5 * DVec3::Y);
    b.light(DVec3::new(0.3, 1.0, 0.3), 1.0);
    b.light(DVec3::new(-0.3, 1.0, 0.3), 9.0);
    b.camera(DVec3::new(0.0, 3.0, 1.0), DVec3::ZERO, 0.5);
    b.build()
}

#[test]
fn example_emission_keeps_the_mean_and_changes_the_samples() {
    let scene = two_lights();
    assert!(scene.lights.len() > 1);
    let caustics = |emission| {
        let config = RenderConfig { emission, light_paths: Paths::Count(200_000), ..config() };
        let frames = frames(&scene, &config, &BASIC, &PHOTONS_GRID, 8);
        frames.iter().map(|layers| sum(&layers.caustics)).collect::<Vec<_>>()
    };
    let [power, even] = [&emission::POWER, &even::EVEN].map(caustics);
    println!("by power {power:?}, evenly {even:?}");
    assert!(power[0] > 0.0 && power != even);
    // Frames have a standard deviation of 2.5 %: means of eight have a hundredth, and 0.06 is five standard errors of
    // their ratio.
    let ratio = even.iter().sum::<f32>() / power.iter().sum::<f32>();
    assert!((ratio - 1.0).abs() < 0.06, "{ratio}");
}

#[test]
fn example_history_blends_two_frames_of_a_still_scene() {
    // The camera sees the floor directly: collection points are the same in every frame.
    let scene = two_lights();
    let rendered = |history| frames(&scene, &RenderConfig { history, ..config() }, &BASIC, &PHOTONS_GRID, 2);
    let [alone, blended] = [&history::NONE, &same_pixel::SAME_PIXEL].map(rendered);
    assert!(alone[0].caustics != alone[1].caustics);
    let pairs = alone[0].caustics.iter().zip(&alone[1].caustics);
    let mut blended_count = 0;
    for (found, (first, second)) in blended[1].caustics.iter().zip(pairs) {
        let expected = 0.5 * (*first + *second);
        // The blend rounds in f32.
        assert!((*found - expected).length() <= 1e-5 * expected.length(), "{found} is not {expected}");
        blended_count += usize::from(first != second);
    }
    assert!(blended_count > 50, "only {blended_count} pixels differ");
}

#[test]
fn example_metric_is_the_largest_difference() {
    let estimate = |values: [f64; 2]| {
        let values = values.map(DVec3::splat).to_vec();
        Estimate { mean: Pixels { width: 2, height: 1, values }, variance: None, caustics: None }
    };
    let (run, reference) = ([estimate([0.5, 1.0])], estimate([0.25, 1.125]));
    let comparison = Comparison::new(&run, &reference, Viewing::default()).expect("finite pixels");
    assert_eq!((largest::LARGEST.compute)(&comparison), Ok(0.25));
}
