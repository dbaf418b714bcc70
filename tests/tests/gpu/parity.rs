//! Parity tests: equal inputs through the CPU runner and the GPU runner, pass by pass and frame by frame.

mod frames;
mod passes;
mod paths;
mod steps;

use caustics::render_config::RenderConfig;
use caustics::render_config::{Paths, Radius};
use caustics_kernels::emission::{AIMED, POWER};
use caustics_kernels::interface::choice::Sampler;
use caustics_kernels::interface::features::Features;
use caustics_tests::gpu::gpu;
use caustics_tests::lobes;
use caustics_tests::parity::{RunnerPair, load, needs};
use caustics_tests::scenes::{blended_room, dispersive_room};
use caustics_tests::table::Table;

/// A small view whose points are large enough to take thousands of photons.
fn config() -> RenderConfig {
    RenderConfig {
        width: 160,
        height: 90,
        light_paths: Paths::Count(131_072),
        radius: Radius::Px(3.0),
        sampler: Sampler::Sobol,
        ..RenderConfig::default()
    }
}

/// Features that textures, blended surfaces and dispersive glass need together: their tests share kernels.
fn rich() -> Features {
    needs(&[load("textured-room"), blended_room().build(), dispersive_room()], &config())
}

#[test]
fn steps_and_passes_agree() {
    let Some(gpu) = gpu() else { return };
    for &hardware in gpu.tracers() {
        let tracer = if hardware { "hardware" } else { "software" };
        let scene = load("mirror-room");
        let mut runners = RunnerPair::open(&gpu, hardware, &scene, &config());
        let mut table = Table::new(&format!("mirror-room, CPU against {} ({tracer} tracer)", gpu.info.name));
        steps::sample(&mut runners, &mut table);
        steps::hit(&mut runners, &scene, &mut table);
        steps::scatter(&mut runners, &scene, &mut table);
        steps::emit(&mut runners, &scene, &mut table);
        passes::all(&mut runners, &scene, hardware, &mut table);
        table.finish();
    }
}

/// Compares textures, normal maps, emission and holes, by both tracers.
#[test]
fn textured_steps_and_passes_agree() {
    let Some(gpu) = gpu() else { return };
    let scene = load("textured-room");
    for &hardware in gpu.tracers() {
        let tracer = if hardware { "hardware" } else { "software" };
        let config = RenderConfig { sampler: Sampler::Blue, ..config() };
        let mut runners = RunnerPair::with(&gpu, hardware, &scene, &config, rich());
        let mut table =
            Table::new(&format!("textured-room, CPU against {} ({tracer} tracer)", gpu.info.name));
        steps::hit(&mut runners, &scene, &mut table);
        steps::scatter(&mut runners, &scene, &mut table);
        steps::emit(&mut runners, &scene, &mut table);
        // Aimed paths start in both ways: by power, and in an emission cone.
        passes::frame(&mut runners, &scene, &AIMED, &mut table);
        table.finish();
    }
}

/// A blended surface blocks the same rays on both runners and on both tracers.
#[test]
fn blended_surfaces_agree_on_every_tracer() {
    let Some(gpu) = gpu() else { return };
    let scene = blended_room().build();
    for &hardware in gpu.tracers() {
        let tracer = if hardware { "hardware" } else { "software" };
        let mut runners = RunnerPair::with(&gpu, hardware, &scene, &config(), rich());
        let mut table =
            Table::new(&format!("things that blend, CPU against {} ({tracer} tracer)", gpu.info.name));
        steps::hit(&mut runners, &scene, &mut table);
        steps::emit(&mut runners, &scene, &mut table);
        passes::frame(&mut runners, &scene, &POWER, &mut table);
        table.finish();
    }
}

/// Both runners sample and keep the same channels along whole paths.
#[test]
fn dispersive_glass_agrees_in_sampled_channels() {
    let Some(gpu) = gpu() else { return };
    let scene = dispersive_room();
    for &hardware in gpu.tracers() {
        let tracer = if hardware { "hardware" } else { "software" };
        let mut runners = RunnerPair::with(&gpu, hardware, &scene, &config(), rich());
        let mut table =
            Table::new(&format!("dispersive glass, CPU against {} ({tracer} tracer)", gpu.info.name));
        steps::scatter(&mut runners, &scene, &mut table);
        passes::frame(&mut runners, &scene, &POWER, &mut table);
        table.finish();
    }
}

#[test]
fn scattering_agrees_on_every_lobe() {
    let Some(gpu) = gpu() else { return };
    for scene in [load("glossy-room"), lobes::scene()] {
        let title = format!("{}, CPU against {}", scene.name, gpu.info.name);
        let mut table = Table::new(&title);
        let mut runners = RunnerPair::open(&gpu, false, &scene, &config());
        steps::scatter(&mut runners, &scene, &mut table);
        steps::emit(&mut runners, &scene, &mut table);
        table.finish();
    }
}
