//! Parity tests of the histories: a frame of an animation step by step on equal inputs, and a few frames on each runner's
//! own buffers.

mod path;
mod sequence;
mod steps;

use caustics::render_config::{Paths, Radius, RenderConfig};
use caustics::scene::Scene;
use caustics::upload::Upload;
use caustics_kernels::declare::Step;
use caustics_kernels::gather::variant::PHOTONS_GRID;
use caustics_kernels::history::auxiliary::AUXILIARY;
use caustics_kernels::history::path::PATH_HISTORY;
use caustics_kernels::history::{self, History, VALIDATED};
use caustics_kernels::interface::auxiliary::Auxiliary;
use caustics_kernels::interface::frame::{Camera, FrameParams};
use caustics_kernels::method::basic;
use caustics_kernels::method::{Parts, Stages};
use caustics_tests::compare::{Tolerance, records};
use caustics_tests::gpu::{Gpu, watched_gpu};
use caustics_tests::parity::{RunnerPair, load};
use caustics_tests::table::Table;

/// Frames per second.
const RATE: f64 = 30.0;

/// An animation on two runners.
struct Animation {
    scene: Scene,
    config: RenderConfig,
    runners: RunnerPair,
    uploads: [Upload; 2],
    /// The camera of the last frame.
    camera: Camera,
    /// Whether path-traced light outlives its frame.
    keeps_path: bool,
}

impl Animation {
    /// Opens both runners with the buffers of every history.
    fn open(gpu: &Gpu, hardware: bool, scene: &str, light_paths: u32) -> Animation {
        let config = RenderConfig {
            width: 160,
            height: 90,
            light_paths: Paths::Count(light_paths),
            radius: Radius::Px(2.0),
            history: &VALIDATED,
            ..RenderConfig::default()
        };
        let scene = load(scene);
        // This scene needs all features that the others need.
        let kernels = load("animated-light").features(config.specular_roughness);
        let runners = RunnerPair::with(gpu, hardware, &scene, &config, kernels);
        let uploads = [Upload::new(&scene), Upload::new(&scene)];
        let camera = runners.params.camera;
        Animation { scene, config, runners, uploads, camera, keeps_path: false }
    }

    /// Restarts the animation without a history.
    fn restart(&mut self, history: &'static History) {
        self.config.history = history;
        let forget = history::ALL.iter().flat_map(|history| history.forget);
        let forget: Vec<Step> = forget.map(|&buffer| Step::Clear { buffer }).collect();
        self.runners.run(&FrameParams::default(), &forget);
    }

    /// Poses both runners at a frame and returns its parameters.
    fn pose(&mut self, frame: u32) -> FrameParams {
        self.scene.pose(f64::from(frame) / RATE).expect("a pose");
        let [cpu, gpu] = &mut self.uploads;
        cpu.run(&mut *self.runners.cpu, &self.scene).expect("the CPU takes the pose");
        gpu.run(&mut *self.runners.gpu, &self.scene).expect("the GPU takes the pose");
        let params = self.config.params(&self.scene, &self.scene.cameras[0], frame);
        let params = FrameParams { previous_camera: self.camera, ..params };
        self.camera = params.camera;
        params
    }

    fn steps(&self, params: &FrameParams) -> Vec<Step> {
        basic::steps(self.parts(), params)
    }

    fn parts(&self) -> Parts {
        let (history, keeps_path) = (self.config.history, self.keeps_path);
        let stages = Stages::NONE.with(&PATH_HISTORY, keeps_path);
        Parts { history, stages, ..Parts::from(&PHOTONS_GRID) }
    }
}

/// Compares a swinging light, then a plate that carries a light and a ring, by the same kernels in software. One light
/// path in a hundred meets the ring.
#[test]
fn histories_agree_under_a_moving_light_and_on_a_moving_plate() {
    let Some(gpu) = watched_gpu() else { return };
    runners_agree(&gpu, gpu.tracers(), "animated-light", 30_000);
    runners_agree(&gpu, &[false], "moving-receiver", 200_000);
}

/// Below a swinging light changes show the noise; under a moving camera the mean of frames does.
#[test]
fn path_history_agrees_under_a_moving_light_and_camera() {
    let Some(gpu) = watched_gpu() else { return };
    for &hardware in gpu.tracers() {
        path::steps_agree(&mut Animation::open(&gpu, hardware, "animated-light", 1000));
        path::steps_agree(&mut Animation::open(&gpu, hardware, "animated-camera", 1000));
    }
}

/// Compares auxiliary layers and motion, under a moving camera and on a moving plate.
#[test]
fn auxiliary_layers_agree_under_motion() {
    const REASON: &str = "the parity rule: 0.2 % of the paths may diverge";
    let Some(gpu) = watched_gpu() else { return };
    for &hardware in gpu.tracers() {
        for scene in ["animated-camera", "sliding-receiver"] {
            let mut animation = Animation::open(&gpu, hardware, scene, 1000);
            animation.pose(3);
            let params = animation.pose(4);
            animation.runners.run(&params, &[Step::new(&AUXILIARY, &params)]);
            let (cpu, gpu) = animation.runners.records::<Auxiliary>("auxiliary");
            let moving =
                cpu.iter().filter(|record| record.depth > 0.0 && record.motion.length() > 0.1).count();
            assert!(moving > cpu.len() / 20, "{scene}: {moving}");
            let words = Tolerance::EXACT.except(2.0e-3, REASON);
            let near = Tolerance::relative(1.0e-3, 0.0, REASON).except(2.0e-3, REASON);
            // In pixels: a difference of two positions in the image.
            let motion = Tolerance { absolute: 1.0e-2, ..near };
            let tolerance = |name: &str| if name == "motion" { motion } else { near };
            let mut table = Table::new(&format!("{scene}, what pixels show (hardware {hardware})"));
            table.add("auxiliary", records(&cpu, &gpu, words, |field| tolerance(field.name)));
            table.finish();
        }
    }
}

fn runners_agree(gpu: &Gpu, tracers: &[bool], scene: &str, light_paths: u32) {
    for &hardware in tracers {
        let tracer = if hardware { "hardware" } else { "software" };
        // On software Vulkan, opening takes longer than all frames.
        let mut animation = Animation::open(gpu, hardware, scene, light_paths);
        for &history in history::ALL.iter().filter(|history| history.settings.is_some()) {
            let name = history.name;
            let title = format!("{scene}, {name}, CPU against {} ({tracer} tracer)", gpu.info.name);
            animation.restart(history);
            steps_agree(&mut animation, &title);
            animation.restart(history);
            sequences_agree(&mut animation, &title);
            if !hardware {
                animation.restart(history);
                detects_the_history_of_another_seed(&mut animation);
            }
        }
    }
}

fn steps_agree(animation: &mut Animation, title: &str) {
    let mut table = Table::new(title);
    for frame in 0..3 {
        let params = animation.pose(frame);
        animation.runners.cpu.run(&params, &animation.steps(&params)).expect("the CPU runs a frame");
    }
    let params = animation.pose(3);
    for step in animation.steps(&params) {
        steps::one(animation, &params, step, &mut table);
    }
    table.finish();
}

fn sequences_agree(animation: &mut Animation, title: &str) {
    let error = sequence::error(&animation.config, &animation.scene);
    let compared = sequence::run(animation, 0, title);
    compared.table.finish();
    let [cpu, gpu] = compared.means;
    let sigmas = (cpu - gpu).abs() / error;
    eprintln!("means {cpu:.6e} and {gpu:.6e}, standard error {error:.1e}: {sigmas:.4} sigma apart");
    assert!(cpu > 0.0 && sigmas <= 3.0);
}

fn detects_the_history_of_another_seed(animation: &mut Animation) {
    let compared = sequence::run(animation, 1, "only the last frame has one seed");
    assert_eq!(compared.table.failures().len(), 1, "{}", compared.table);
    eprintln!("{}", compared.table);
}

mod long {
    use super::*;

    #[test]
    #[ignore = "half a minute on lavapipe"]
    fn histories_agree_by_ray_queries_on_a_moving_plate() {
        let Some(gpu) = watched_gpu() else { return };
        if gpu.info.ray_queries {
            runners_agree(&gpu, &[true], "moving-receiver", 200_000);
        }
    }
}
