//! Where the numbers of camera paths come from: every sampler finds the same light, what it leaves to noise, and whether the variance
//! of a mean is what is said of it.

use caustics::accumulation::{Accumulation, BATCHES};
use caustics::picture::Picture;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics::settings::Settings;
use caustics_kernels::gather::variant::PHOTONS_GRID;
use caustics_kernels::interface::choice::Sampler;
use caustics_kernels::interface::frame::PIXEL_FILTER_BOX;
use caustics_kernels::method::Method;
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::method::path::PATH;
use caustics_tests::blocks::Blocks;
use caustics_tests::scenes::*;
use caustics_tests::statistics::Mean;
use caustics_tests::twin::load;
use glam::DVec3;

const CPU: RunnerChoice = RunnerChoice::Cpu { threads: 0 };

fn settings(sampler: Sampler, batches: u32, seed: u32) -> Settings {
    let (width, height, pixel_filter) = (64, 48, PIXEL_FILTER_BOX);
    Settings { width, height, pixel_filter, sampler, batches, seed, light_paths: 4000, ..Settings::default() }
}

fn session(scene: &Scene, settings: &Settings, method: &'static Method) -> Session {
    let features = scene.features(settings.specular_roughness);
    Session::new(&CPU, scene, &scene.cameras[0], settings, method, &PHOTONS_GRID, features)
        .expect("a session opens")
}

/// A floor beneath a square lamp, in plain view.
fn under_a_lamp() -> Scene {
    let mut b = Builder::default();
    let (floor, lamp) = (b.material(lambert(0.6)), b.material(emitter(5.0)));
    b.panel(floor, DVec3::ZERO, 9.0 * DVec3::Z, 9.0 * DVec3::X);
    b.panel(lamp, DVec3::new(0.3, 1.5, 0.0), 0.4 * DVec3::X, 0.4 * DVec3::Z);
    b.camera(DVec3::new(0.0, 1.0, 2.0), DVec3::ZERO, 0.6);
    b.build()
}

/// The light of mirrors, glass, textures and lamps in three rooms: means of blocks differ by chance alone, in both layers.
#[test]
fn every_sampler_finds_the_same_light() {
    for (name, method, frames) in
        [("cornell-box", &BASIC, 128), ("textured-room", &BASIC, 128), ("mirror-room", &PATH, 512)]
    {
        let scene = load(name);
        let blocks = |sampler, batches, seed| {
            Blocks::render(&CPU, &scene, &settings(sampler, batches, seed), method, &PHOTONS_GRID, frames)
        };
        let independent = blocks(Sampler::Independent, 1, 2);
        for sampler in [Sampler::Sobol, Sampler::Blue] {
            // As many batches as a test of normal numbers wants.
            let scores = blocks(sampler, 64, 1).of_batches(64).scores(&independent);
            println!("{name} {sampler:?}: {scores:?}");
            assert!(scores.ratio_error < 0.03, "the test is too blunt");
            assert!(scores.fault().is_none(), "{name} {sampler:?}: {:?}", scores.fault());
        }
    }
}

/// Mean over pixels of the relative variance of means of so many frames, from runs of several seeds.
fn variance(scene: &Scene, settings: &Settings, counts: &[u32]) -> Vec<f64> {
    let runs = 8;
    let mut means: Vec<Vec<Picture>> = vec![Vec::new(); counts.len()];
    for seed in 0..runs {
        let mut session = session(scene, &Settings { seed, ..settings.clone() }, &PATH);
        let mut sums = Accumulation::default();
        for (means, count) in means.iter_mut().zip(counts) {
            while sums.frames() < *count {
                session.frame(sums.frames()).expect("a frame runs");
                sums.add(&session.picture().expect("a picture"));
            }
            means.push(sums.mean());
        }
    }
    let of_means = |means: &Vec<Picture>| {
        let pixels = means[0].path.len();
        let of_pixel = |pixel: usize| {
            let values: Vec<f64> = means.iter().map(|mean| f64::from(mean.path[pixel].x)).collect();
            let Mean { value, error } = Mean::of(&values);
            if value > 0.0 { values.len() as f64 * (error / value).powi(2) } else { 0.0 }
        };
        (0..pixels).map(of_pixel).sum::<f64>() / pixels as f64
    };
    means.iter().map(of_means).collect()
}

/// Direct light of a lamp in plain view is a smooth integrand: its variance falls faster than by chance, and so with several batches.
#[test]
fn smooth_light_converges_faster_than_by_chance() {
    let scene = under_a_lamp();
    let counts = [4, 16, 64, 256];
    // Variances of eight runs, each off by half: those of 768 pixels have a mean that is known to 2 %.
    let variance = |sampler, batches| {
        variance(&scene, &Settings { width: 32, height: 24, ..settings(sampler, batches, 0) }, &counts)
    };
    let slope = |variances: &[f64]| (variances[3] / variances[1]).ln() / 16.0f64.ln();
    let independent = variance(Sampler::Independent, 1);
    let sobol = variance(Sampler::Sobol, 1);
    let batches = variance(Sampler::Sobol, BATCHES);
    println!("independent {independent:?}, Sobol {sobol:?}, of {BATCHES} batches {batches:?}");
    assert!((slope(&independent) + 1.0).abs() < 0.1, "{}", slope(&independent));
    assert!(slope(&sobol) < -1.4, "{}", slope(&sobol));
    assert!(slope(&batches) < -1.3, "{}", slope(&batches));
    assert!(sobol[3] < 0.1 * independent[3] && batches[3] < 0.2 * independent[3]);
}

/// In one frame of smooth light, blocks of pixels are far less noisy where pixels share an even set; each pixel is as noisy.
#[test]
fn noise_of_neighbours_evens_out() {
    let scene = under_a_lamp();
    let (width, height, side, runs) = (64, 48, 4, 24);
    // Variance between seeds of the means of blocks, over that mean squared.
    let variance = |sampler, side: usize| {
        let frames: Vec<Picture> = (0..runs)
            .map(|seed| {
                let mut session = session(&scene, &settings(sampler, 1, seed), &PATH);
                session.frame(0).expect("a frame runs");
                session.picture().expect("a picture")
            })
            .collect();
        let block = |frame: &Picture, left: usize, top: usize| {
            let rows =
                (top..top + side).flat_map(|row| (left..left + side).map(move |column| row * width + column));
            rows.map(|pixel| f64::from(frame.path[pixel].x)).sum::<f64>()
        };
        let blocks = (0..height / side)
            .flat_map(|row| (0..width / side).map(move |column| (column * side, row * side)));
        let relative = blocks.filter_map(|(left, top)| {
            let values: Vec<f64> = frames.iter().map(|frame| block(frame, left, top)).collect();
            let Mean { value, error } = Mean::of(&values);
            (value > 0.0).then(|| (error / value).powi(2))
        });
        relative.sum::<f64>()
    };
    let ratio = |side| variance(Sampler::Blue, side) / variance(Sampler::Sobol, side);
    let (of_blocks, of_pixels) = (ratio(side), ratio(1));
    println!("blocks {of_blocks}, pixels {of_pixels}");
    assert!(of_blocks < 0.5 && (of_pixels - 1.0).abs() < 0.1, "blocks {of_blocks}, pixels {of_pixels}");
}

/// The variance between batches is that of the mean; that between frames, as if they were independent, is far more.
#[test]
fn variances_of_batches_are_honest() {
    let scene = under_a_lamp();
    let frames = 32;
    let truth = variance(&scene, &settings(Sampler::Sobol, BATCHES, 0), &[frames])[0];
    let said = |mut sums: Accumulation| {
        let mut session = session(&scene, &settings(Sampler::Sobol, BATCHES, 9), &PATH);
        for frame in 0..frames {
            session.frame(frame).expect("a frame runs");
            sums.add(&session.picture().expect("a picture"));
        }
        let (mean, variance) = (sums.mean(), sums.variance().expect("several frames"));
        let relative = mean.path.iter().zip(&variance).filter(|(mean, _)| mean.x > 0.0);
        let sum: f64 = relative.map(|(mean, variance)| f64::from(variance.x / (mean.x * mean.x))).sum();
        sum / mean.path.len() as f64
    };
    let (batches, frames) = (said(Accumulation::in_batches(BATCHES)), said(Accumulation::default()));
    println!("variance {truth:.3e}, between batches {batches:.3e}, between frames {frames:.3e}");
    assert!((batches / truth - 1.0).abs() < 0.1, "{batches} {truth}");
    assert!(frames > 2.0 * truth, "a wrong variance is noticed");
}
