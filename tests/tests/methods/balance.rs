//! `--light-paths auto`: the number minimises variance times cost, as measured independently, and follows from earlier
//! frames alone.

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::{Scene, SceneCamera};
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::emission::{AIMED, Emission, GUIDED, POWER};
use caustics_kernels::history::VALIDATED;
use caustics_kernels::interface::balance::{Balance, FIRST_PATHS, MAX_PATHS, MIN_PATHS};
use caustics_kernels::interface::counters::Counter;
use caustics_kernels::interface::history::HistoryPoint;
use caustics_kernels::method::Method;
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::method::kim2019::KIM2019;
use caustics_kernels::method::path::PATH;
use caustics_kernels::method::yang2021::YANG2021;
use caustics_kernels::pass::balance::light_cost;
use caustics_tests::moving::Moving;
use caustics_tests::scenes::*;
use caustics_tests::statistics::Mean;
use glam::{Quat, Vec3};
use std::f32::consts::PI;

const PIXELS: u32 = 160 * 90;

fn config(emission: &'static Emission, seed: u32) -> RenderConfig {
    let light_paths = Paths::Auto;
    RenderConfig { width: 160, height: 90, light_paths, seed, emission, ..RenderConfig::default() }
}

fn open(threads: usize, scene: &Scene, config: &RenderConfig, method: &'static Method) -> Session {
    let features = scene.features(config.specular_roughness);
    let choice = RunnerChoice::Cpu { threads };
    Session::new(&choice, scene, &scene.cameras[0], &RenderConfig { method, ..config.clone() }, features)
        .expect("a session opens")
}

/// Light paths of the frame after `frames` frames.
fn after(session: &mut Session, frames: u32) -> u32 {
    (0..frames).for_each(|frame| drop(session.frame(frame).expect("a frame runs")));
    session.read::<Balance>("balance").expect("a balance")[0].light_paths
}

/// Variance and cost of independent frames of a number of light paths per pixel, in f64.
struct Measured {
    /// Relative variance of the light of camera paths.
    path: f64,
    /// Relative variance of the light of light paths.
    caustics: f64,
    /// Costs of camera paths and of light paths.
    cost: [f64; 2],
}

fn measured(scene: &Scene, paths: f64) -> Measured {
    let light_paths = (paths * f64::from(PIXELS)) as u32;
    let config = RenderConfig { light_paths: Paths::Count(light_paths), ..config(&AIMED, 50) };
    let mut session = open(0, scene, &config, &BASIC);
    let frames = 48;
    let mut cost = [0.0; 2];
    let mut pixels = vec![[[0.0; 2]; 2]; PIXELS as usize];
    for frame in 0..frames {
        session.frame(frame).expect("a frame runs");
        let counters = session.counters().expect("counters");
        let count = |counter| counters.get(counter) as f32;
        cost[0] += f64::from(count(Counter::CameraRays) + count(Counter::ShadowRays));
        let [rays, photons, pairs] = [Counter::LightRays, Counter::Photons, Counter::Gathered].map(count);
        cost[1] += f64::from(light_cost(rays, photons, pairs));
        let image = session.image().expect("an image");
        for (pixel, sums) in pixels.iter_mut().enumerate() {
            for (sums, light) in sums.iter_mut().zip([image.path[pixel], image.caustics[pixel]]) {
                let value = f64::from(light.element_sum()) / 3.0;
                *sums = [sums[0] + value, sums[1] + value * value];
            }
        }
    }
    let frames = f64::from(frames);
    let shown = |sums: &[[f64; 2]; 2]| (sums[0][0] + sums[1][0]) / frames;
    let dark = 0.1 * pixels.iter().map(shown).sum::<f64>() / f64::from(PIXELS);
    let variance = |layer: usize| {
        let relative_variance = |sums: &[[f64; 2]; 2]| {
            let [sum, squares] = sums[layer];
            (squares - sum * sum / frames) / (frames - 1.0) / (shown(sums).powi(2) + dark * dark)
        };
        pixels.iter().map(relative_variance).sum::<f64>() / f64::from(PIXELS)
    };
    Measured { path: variance(0), caustics: variance(1), cost: cost.map(|cost| cost / frames) }
}

/// Variance times cost as a function of the light paths a pixel.
struct Product {
    /// Variance that no light path lowers: of camera paths, and of their choices at curved glass before caustics.
    left: f64,
    /// Variance of one light path per pixel.
    of_one: f64,
    /// Costs of camera paths and of one light path per pixel.
    cost: [f64; 2],
}

impl Product {
    fn for_scene(scene: &Scene) -> Product {
        let (few, many) = (measured(scene, 0.125), measured(scene, 1.0));
        let of_one = (few.caustics - many.caustics) / (1.0 / 0.125 - 1.0);
        Product { left: many.path + many.caustics - of_one, of_one, cost: many.cost }
    }

    /// Number of light paths at the minimum.
    fn best(&self) -> f64 {
        (self.of_one / self.left * (self.cost[0] / self.cost[1])).sqrt()
    }

    fn at(&self, paths: f64) -> f64 {
        (self.left + self.of_one / paths) * (self.cost[0] + paths * self.cost[1])
    }
}

/// Rooms that need many light paths and few. Pixels are weighed by few frames of them and their neighbours, and yet a
/// frame's time buys as much as the best number would.
#[test]
fn auto_light_paths_minimise_variance_times_cost_to_15_percent() {
    let mut found = Vec::new();
    for name in ["cornell-box", "mirror-room", "textured-room", "ring"] {
        let scene = committed(name);
        let product = Product::for_scene(&scene);
        let paths =
            f64::from(after(&mut open(0, &scene, &config(&AIMED, 1), &BASIC), 24)) / f64::from(PIXELS);
        let best = product.best().clamp(f64::from(MIN_PATHS), f64::from(MAX_PATHS));
        let loss = product.at(paths) / product.at(best);
        let [wrong_few, wrong_many] = [0.1, 10.0].map(|factor| product.at(factor * best) / product.at(best));
        println!(
            "{name}: {paths:.3} light paths a pixel, best {best:.3}, {loss:.3} times the least product; ten times too few {wrong_few:.2}, too many {wrong_many:.2}"
        );
        assert!(loss < 1.15 && wrong_few > 1.3 && wrong_many > 1.3, "{name}");
        found.push(paths);
    }
    assert!(found[3] > 4.0 * found[0], "the rooms differ");
}

/// Frames that choose the number of light paths of later frames have the mean of frames that do not.
#[test]
fn auto_light_paths_keep_the_mean_of_a_fixed_number() {
    let scene = committed("cornell-box");
    for (emission, method) in [(&GUIDED, &BASIC), (&POWER, &KIM2019), (&POWER, &YANG2021)] {
        let light = |light_paths| {
            let sums: Vec<f64> = (0..12)
                .map(|seed| {
                    let config = RenderConfig { light_paths, ..config(emission, 100 + seed) };
                    let mut session = open(0, &scene, &config, method);
                    let sum = |frame| {
                        session.frame(frame).expect("a frame runs");
                        let caustics: Vec<Vec3> = session.read("caustic_radiance").expect("caustics");
                        caustics.iter().map(|value| f64::from(value.element_sum())).sum::<f64>()
                    };
                    (0..4).map(sum).sum::<f64>()
                })
                .collect();
            Mean::from_samples(&sums)
        };
        let (fixed, balanced) = (light(Paths::Count(PIXELS)), light(Paths::Auto));
        println!("{}: {fixed:?}, balanced {balanced:?}", method.name);
        assert!(balanced.agrees(&fixed, 3.0) && balanced.error < 0.03 * balanced.value);
    }
}

/// Neither threads nor clocks decide the number. A restored state continues, also where something moved.
#[test]
fn auto_light_paths_are_deterministic_and_continue_from_a_restored_state() {
    let mut scene = Moving::GlassCaster.scene();
    let mut run = |threads, restored: Option<u32>| {
        let mut session = open(threads, &scene, &config(&GUIDED, 3), &BASIC);
        let mut paths = Vec::new();
        for frame in 0..6_u32 {
            scene.pose(f64::from(frame / 2) * 0.1).expect("a pose");
            session.pose(&scene, &scene.cameras[0]).expect("a pose");
            session.frame(frame).expect("a frame runs");
            paths.push(session.counters().expect("counters").get(Counter::LightPaths));
            if restored == Some(frame) {
                let state: Vec<_> =
                    session.state().unwrap().into_iter().map(|(n, b)| (n.to_string(), b)).collect();
                session = open(threads, &scene, &config(&GUIDED, 3), &BASIC);
                session.restore(frame, &state).expect("a state");
            }
        }
        (paths, session.read::<Vec3>("caustic_radiance").expect("caustics"))
    };
    let whole = run(0, None);
    println!("{:?}", whole.0);
    assert_eq!(whole.0[0], u64::from((PIXELS as f32 * FIRST_PATHS) as u32));
    assert!(whole.0.iter().any(|paths| *paths != whole.0[0]), "it is no constant");
    for (threads, restored) in [(1, None), (0, Some(3)), (0, Some(4))] {
        assert!(run(threads, restored) == whole, "{threads} threads, restored after {restored:?}");
    }
}

/// Validation paths are as many and as bright in every frame: a still view reuses all of its light.
#[test]
fn history_reuses_as_much_with_auto_light_paths_as_with_a_fixed_number() {
    let scene = committed("ring");
    let run = |light_paths| {
        let config = RenderConfig { light_paths, history: &VALIDATED, ..config(&POWER, 3) };
        let mut session = open(0, &scene, &config, &BASIC);
        let mut paths = Vec::new();
        for frame in 0..8 {
            session.frame(frame).expect("a frame runs");
            paths.push(session.counters().expect("counters").get(Counter::LightPaths));
        }
        let points: Vec<HistoryPoint> = session.read("history_points").expect("points");
        let caustics: Vec<Vec3> = session.read("caustic_radiance").expect("caustics");
        let samples = points.iter().map(|point| f64::from(point.samples)).sum::<f64>() / f64::from(PIXELS);
        (samples, caustics.iter().map(|value| f64::from(value.element_sum())).sum::<f64>(), paths)
    };
    let (fixed, balanced) = (run(Paths::Count(PIXELS * MAX_PATHS)), run(Paths::Auto));
    println!("{fixed:?}, balanced {balanced:?}");
    assert!(balanced.2.windows(2).any(|pair| pair[0] != pair[1]));
    assert!(fixed.0 > 4.0 && (balanced.0 / fixed.0 - 1.0).abs() < 1.0e-3);
    // 5 % is for the noise of few light paths.
    assert!((balanced.1 / fixed.1 - 1.0).abs() < 0.05);
}

/// The camera, turned to the side.
fn turned(camera: &SceneCamera, angle: f32) -> SceneCamera {
    let turn = Quat::from_axis_angle(camera.up, angle);
    SceneCamera { forward: turn * camera.forward, right: turn * camera.right, ..camera.clone() }
}

/// Light that enters a moving view is no noise. Such a view gets as many light paths as a still one whose frames know
/// as little of each other.
#[test]
fn auto_light_paths_of_a_moving_view_are_within_a_factor_of_2_of_a_still_one() {
    for name in ["ring", "cornell-box"] {
        let scene = committed(name);
        let [standing, moving] = [0.0, 0.02].map(|step| {
            let mut session = open(0, &scene, &config(&AIMED, 1), &BASIC);
            let frames = 8..24_u16;
            let paths = (0..frames.end).map(|frame| {
                let camera = turned(&scene.cameras[0], step * (f32::from(frame) - 16.0));
                session.pose(&scene, &camera).expect("a pose");
                session.jump();
                session.frame(frame.into()).expect("a frame runs");
                session.counters().expect("counters").get(Counter::LightPaths) as f64
            });
            let paths: Vec<f64> = paths.collect();
            paths[usize::from(frames.start)..].iter().sum::<f64>() / frames.len() as f64
        });
        println!("{name}: {standing} light paths a frame, {moving} in a view that moves by three pixels");
        assert!((0.5..2.0).contains(&(moving / standing)), "{name}");
    }
}

/// Black frames and light without bounds teach nothing, and learning continues after both.
#[test]
fn black_frames_leave_the_balance_unchanged_and_unbounded_light_does_not_end_it() {
    let scene = Moving::GlassCaster.scene();
    let mut session = open(0, &scene, &config(&AIMED, 3), &BASIC);
    let mut bright = scene.clone();
    for light in &mut bright.lights {
        light.emission *= 1.0e30;
    }
    let away = SceneCamera {
        position: scene.cameras[0].position + 1000.0 * Vec3::Y,
        ..turned(&scene.cameras[0], PI)
    };
    let mut before = Balance::default();
    for frame in 0..24 {
        match frame {
            6 => session.pose(&scene, &away),
            12 => session.pose(&bright, &scene.cameras[0]),
            14 => session.pose(&scene, &scene.cameras[0]),
            _ => Ok(()),
        }
        .expect("a pose");
        session.frame(frame).expect("a frame runs");
        let balance = session.read::<Balance>("balance").expect("a balance")[0];
        println!("{frame}: {balance:?}");
        let sums = [balance.path_variance, balance.caustic_variance, balance.camera_cost, balance.light_cost];
        assert!(sums.iter().all(|sum| sum.is_finite() && *sum >= 0.0), "{frame}");
        match frame {
            6..12 => assert_eq!(balance, before, "a black frame changes the balance"),
            12 | 13 => {
                let seen = session.image().expect("an image").path.into_iter().map(Vec3::max_element);
                assert!(seen.fold(0.0, f32::max) > 1.0e28, "it is bright");
            }
            15..24 => assert_ne!(balance, before, "the balance no longer changes"),
            _ => {}
        }
        before = balance;
    }
}

/// A frame without light traces no light path, and a method without light paths has no balance. Neither loses the
/// learnt balance.
#[test]
fn auto_light_paths_are_zero_without_light_and_resume_with_it() {
    let lit = Moving::GlassCaster.scene();
    let mut dark = lit.clone();
    dark.lights.clear();
    let mut session = open(0, &lit, &config(&GUIDED, 3), &BASIC);
    let (mut paths, mut learnt) = (Vec::new(), 0);
    for frame in 0..8 {
        let scene = if (4..6).contains(&frame) { &dark } else { &lit };
        session.pose(scene, &scene.cameras[0]).expect("a pose");
        session.frame(frame).expect("a frame runs");
        paths.push(session.counters().expect("counters").get(Counter::LightPaths));
        if frame == 3 {
            learnt = u64::from(session.read::<Balance>("balance").expect("a balance")[0].light_paths);
        }
    }
    println!("{paths:?}, learnt {learnt}");
    assert!(learnt > paths[0] && paths[4..6] == [0, 0] && paths[6] == learnt);
    // No frame can trace light paths: nothing casts caustics, or paths are too short for them.
    let dull = committed("plain-room");
    for (scene, max_bounces) in [(&dull, 5), (&lit, 1)] {
        let mut session = open(0, scene, &RenderConfig { max_bounces, ..config(&GUIDED, 3) }, &BASIC);
        session.frame(0).expect("a frame runs");
        session.frame(1).expect("a frame runs");
        assert_eq!(session.counters().expect("counters").get(Counter::LightPaths), 0);
    }
    let mut session = open(0, &committed("ring"), &config(&POWER, 1), &PATH);
    session.frame(0).expect("a frame runs");
    assert!(session.read::<Balance>("balance").is_err());
}
