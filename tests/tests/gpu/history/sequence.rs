//! Frames that each runner renders from its own history.

use caustics::render_config::RenderConfig;
use caustics::scene::Scene;
use caustics_kernels::interface::frame::FrameParams;
use caustics_tests::compare::{Tolerance, floats};
use caustics_tests::frames::{Frames, sums};
use caustics_tests::statistics::Mean;
use caustics_tests::table::Table;

use super::{Animation, RATE};

/// Number of frames of a sequence.
const FRAMES: u32 = 5;

/// Caustics of the last frame, by the CPU and by the GPU.
pub struct Compared {
    pub table: Table,
    /// Means of a channel over the image (W m^-2 sr^-1).
    pub means: [f64; 2],
}

/// Renders on both runners; until the last frame the GPU's seed is larger by `other`.
pub fn run(animation: &mut Animation, other: u32, title: &str) -> Compared {
    for frame in 0..FRAMES {
        let params = animation.pose(frame);
        let other = if frame + 1 < FRAMES { other } else { 0 };
        let steps = animation.steps(&params);
        animation.runners.cpu.run(&params, &steps).expect("the CPU runs a frame");
        let params = FrameParams { seed: params.seed + other, ..params };
        animation
            .runners
            .gpu
            .run(&params, &steps)
            .expect("the GPU runs a frame and the validation layer is silent");
    }
    let (cpu, gpu) = animation.runners.records::<f32>("caustic_radiance");
    let mean = |layer: &[f32]| layer.iter().map(|&v| f64::from(v)).sum::<f64>() / layer.len() as f64;
    let means = [mean(&cpu), mean(&gpu)];
    let reason = "0.2 % of the camera paths and of the light paths may diverge, and a photon on a disc's bound is taken \
                  by one runner only; what a point takes too much is reused";
    let tolerance = Tolerance::relative(0.01, means[0] as f32, reason).except(0.01, reason);
    let mut table = Table::new(title);
    let within = Tolerance { relative: 0.0, ..tolerance };
    table.add("last frame", [floats("caustic_radiance", 3, &cpu, &gpu, within)]);
    Compared { table, means }
}

/// Standard error of the mean of a channel over the last frame, from sequences of other seeds on the CPU.
pub fn error(config: &RenderConfig, scene: &Scene) -> f64 {
    let mut scene = scene.clone();
    let mut last = |seed| {
        scene.pose(0.0).expect("a pose");
        let config = RenderConfig { seed, ..config.clone() };
        let mut frames = Frames::new(&scene, &config, config.history);
        let mut layer = vec![];
        for frame in 0..FRAMES {
            scene.pose(f64::from(frame) / RATE).expect("a pose");
            layer = frames.pose(&scene, &scene.cameras[0]);
        }
        sums(&layer).iter().sum::<f64>() / (3 * layer.len()) as f64
    };
    let means: Vec<f64> = (1..=6).map(&mut last).collect();
    Mean::from_samples(&means).error * (means.len() as f64).sqrt()
}
