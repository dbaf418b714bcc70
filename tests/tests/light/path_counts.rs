//! Light paths per pixel, from a hundredth to ten: caustics have equal energy with every emission, history and method.

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::emission::{AIMED, Emission, GUIDED, POWER};
use caustics_kernels::history::{History, NONE, VALIDATED};
use caustics_kernels::method::Method;
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::method::kim2019::KIM2019;
use caustics_kernels::method::progressive::PROGRESSIVE;
use caustics_kernels::method::yang2021::YANG2021;
use caustics_tests::scenes::{committed, open_air};
use caustics_tests::statistics::Mean;

const WIDTH: u32 = 32;
const HEIGHT: u32 = 18;

/// A configuration that renders caustics.
#[derive(Clone, Copy)]
struct Configuration {
    name: &'static str,
    method: &'static Method,
    emission: &'static Emission,
    history: &'static History,
    /// Largest relative standard error of a comparison in the mirror room, by 400,000 paths of each number; measured
    /// values, rounded up. Paths that start by power seldom meet the small casters.
    max_error: f64,
}

const BY_POWER: Configuration =
    Configuration { name: "by power", method: &BASIC, emission: &POWER, history: &NONE, max_error: 0.05 };
const CONFIGURATIONS: [Configuration; 7] = [
    BY_POWER,
    Configuration { name: "aimed", emission: &AIMED, max_error: 0.02, ..BY_POWER },
    Configuration { name: "guided", emission: &GUIDED, max_error: 0.02, ..BY_POWER },
    Configuration { name: "validated", history: &VALIDATED, max_error: 0.08, ..BY_POWER },
    Configuration {
        name: "guided, validated",
        emission: &GUIDED,
        history: &VALIDATED,
        max_error: 0.02,
        ..BY_POWER
    },
    Configuration { name: "progressive", method: &PROGRESSIVE, max_error: 0.12, ..BY_POWER },
    Configuration { name: "kim2019", method: &KIM2019, max_error: 0.2, ..BY_POWER },
];

/// Mean over runs of the caustics' energy, summed over the frames of a still view. Frames of a run depend on each other
/// where a history or an emission keeps state.
fn energy(scene: &Scene, configuration: Configuration, paths_per_pixel: f64, frames: u32, runs: u32) -> Mean {
    let light_paths = (paths_per_pixel * f64::from(WIDTH * HEIGHT)).round() as u32;
    let run = |seed| {
        let config = RenderConfig {
            width: WIDTH,
            height: HEIGHT,
            light_paths: Paths::Count(light_paths),
            seed,
            emission: configuration.emission,
            history: configuration.history,
            ..RenderConfig::default()
        };
        let features = scene.features(config.specular_roughness);
        let cpu = RunnerChoice::Cpu { threads: 1 };
        let camera = &scene.cameras[0];
        let mut session = Session::new(
            &cpu,
            scene,
            camera,
            &RenderConfig { method: configuration.method, ..config.clone() },
            features,
        )
        .expect("a session opens");
        let mut sum = 0.0;
        for frame in 0..frames {
            session.frame(frame).expect("a frame runs");
            let caustics = session.image().expect("an image").caustics;
            sum += caustics.iter().map(|light| f64::from(light.element_sum())).sum::<f64>();
        }
        sum / f64::from(frames)
    };
    let part = |seeds: std::ops::Range<u32>| seeds.map(run).collect::<Vec<f64>>();
    let energies = std::thread::scope(|scope| {
        let second = scope.spawn(|| part(runs / 2..runs));
        let mut all = part(0..runs / 2);
        all.extend(second.join().expect("no panic"));
        all
    });
    Mean::from_samples(&energies)
}

/// Compares numbers of paths with ten paths per pixel, by `budget` paths of each in `runs` runs. Fails where they
/// differ by more than three standard errors, or where a relative error exceeds `error` times the largest of the
/// configuration.
fn have_one_energy(
    scene: &Scene,
    configurations: &[Configuration],
    per_pixel: &[f64],
    budget: f64,
    runs: u32,
    error: f64,
) {
    let frames = |paths: f64| {
        let paths = paths * f64::from(WIDTH * HEIGHT);
        (budget / f64::from(runs) / paths).ceil() as u32
    };
    let mut wrong = Vec::new();
    for &configuration in configurations {
        let many = energy(scene, configuration, 10.0, 4 * frames(10.0), runs);
        for &paths in per_pixel {
            let few = energy(scene, configuration, paths, frames(paths), runs);
            let z = (few.value - many.value) / few.error.hypot(many.error);
            let line = format!(
                "{}, {paths} paths a pixel, {} frames: {:.4} +- {:.4} of ten paths, z {z:.2}",
                configuration.name,
                frames(paths),
                few.value / many.value,
                few.error.hypot(many.error) / many.value,
            );
            println!("{line}");
            let sharp = few.error.hypot(many.error) <= error * configuration.max_error * many.value;
            if z.abs().is_nan() || z.abs() > 3.0 || !sharp {
                wrong.push(line);
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn caustics_of_few_light_paths_have_the_energy_of_many() {
    let scene = committed("mirror-room");
    let configurations = CONFIGURATIONS.map(|configuration| configuration.name);
    let [aimed, guided, kept] = ["aimed", "guided", "guided, validated"].map(|name| {
        CONFIGURATIONS
            [configurations.iter().position(|configuration| *configuration == name).expect("a configuration")]
    });
    have_one_energy(&scene, &[aimed, guided, kept], &[0.01, 0.1, 1.0], 8000.0, 24, 7.5);
}

mod release {
    use super::*;

    #[test]
    #[ignore = "minutes"]
    fn caustics_of_few_light_paths_have_the_energy_of_many_sharply() {
        for scene in [committed("mirror-room"), open_air().build()] {
            have_one_energy(&scene, &CONFIGURATIONS, &[0.01, 0.03, 0.1, 0.3, 1.0, 3.0], 400_000.0, 32, 1.0);
        }
    }

    /// Photons of this method have the width that its density map gives.
    #[test]
    #[ignore = "a minute"]
    fn splats_of_few_light_paths_have_the_energy_of_many_sharply() {
        let configuration =
            Configuration { name: "yang2021", method: &YANG2021, max_error: 0.13, ..BY_POWER };
        have_one_energy(&committed("mirror-room"), &[configuration], &[0.01, 0.1, 1.0], 400_000.0, 32, 1.0);
    }
}
