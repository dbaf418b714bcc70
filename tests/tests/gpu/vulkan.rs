//! Guarantees of the Vulkan runner beyond equal numbers: devices without ray queries, large frames, small buffers,
//! fresh kernels.

use caustics::kernels::Source;
use caustics::render_config::{Paths, RenderConfig};
use caustics::runner::gpu::GpuRunner;
use caustics::session::{self, RunnerChoice, Session};
use caustics::vulkan::context::Context;
use caustics::vulkan::passes::DeviceOptions;
use caustics_kernels::gather::variant;
use caustics_kernels::interface::choice::Caustics;
use caustics_kernels::interface::counters::Counter;
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::method::frame::frame_buffers;
use caustics_tests::gpu::watched_gpu;
use caustics_tests::parity::load;

/// Size of the talk's image, with fewer light paths than its 1024^2.
fn full() -> RenderConfig {
    RenderConfig {
        width: 1920,
        height: 1080,
        light_paths: Paths::Count(1 << 18),
        caustics: Caustics::Any,
        ..RenderConfig::default()
    }
}

#[test]
fn base_module_renders_on_a_device_without_ray_queries() {
    let Some(gpu) = watched_gpu() else { return };
    assert!(!Context::new(None, false, gpu.validation).unwrap().is_hardware());
    let (scene, config) = (
        load("mirror-room"),
        RenderConfig { width: 96, height: 54, light_paths: Paths::Count(8192), ..full() },
    );
    let features = scene.features(config.specular_roughness);
    let variant = &variant::PHOTONS_GRID;
    let mut session = Session::new(
        &gpu.choice(false),
        &scene,
        &scene.cameras[0],
        &RenderConfig { gather: Some(variant), ..config.clone() },
        features,
    )
    .unwrap();
    session.frame(0).unwrap();
    let image = session.image().unwrap();
    assert!(image.path.iter().all(|pixel| pixel.is_finite()));
    assert!(image.caustics.iter().any(|pixel| pixel.max_element() > 0.0));
    assert!(session.counters().unwrap().get(Counter::Gathered) > 0);
}

#[test]
fn module_with_ray_queries_is_refused_on_a_device_without() {
    let Some(gpu) = watched_gpu() else { return };
    let modules = Source::from_environment().modules().unwrap();
    // Pass the module as `base`: it loads although the device lacks the feature.
    let options =
        DeviceOptions { validation: gpu.validation, base: modules.rayquery, ..DeviceOptions::default() };
    let scene = load("plain-room");
    let tables = scene.buffers();
    let error = GpuRunner::new(&options, scene.features(0.25), &[], &tables, &scene.instanced)
        .err()
        .expect("it is refused");
    assert!(error.to_string().contains("RayQuery"), "{error}");
}

#[test]
#[ignore = "a frame of two million pixels takes tens of seconds on lavapipe"]
fn full_hd_frame_runs() {
    let Some(gpu) = watched_gpu() else { return };
    let scene = load("mirror-room");
    let features = scene.features(full().specular_roughness);
    for variant in variant::ALL.iter().filter(|variant| variant.name != "brute") {
        if variant.hardware && !gpu.info.ray_queries {
            eprintln!("{} skipped: no ray queries", variant.name);
            continue;
        }
        let choice = gpu.choice(variant.hardware);
        let mut session = Session::new(
            &choice,
            &scene,
            &scene.cameras[0],
            &RenderConfig { gather: Some(variant), ..full().clone() },
            features,
        )
        .unwrap();
        let start = std::time::Instant::now();
        let times = session.frame(0).unwrap();
        eprintln!("{} on {}: {:.2?}", variant.name, session.device(), start.elapsed());
        times.iter().for_each(|step| eprintln!("  {:<22} {:>10.2?}", step.pass, step.time));
        let image = session.image().unwrap();
        assert_eq!(image.path.len(), 1920 * 1080);
        assert!(image.path.iter().chain(&image.caustics).all(|pixel| pixel.is_finite()));
        assert!(session.counters().unwrap().get(Counter::Gathered) > 10_000);
    }
}

#[test]
fn full_hd_buffers_stay_within_128_mib() {
    let scene = load("mirror-room");
    for light_paths in [1 << 18, 1 << 20, 1 << 26] {
        for max_bounces in [2, 5, 12] {
            let config = RenderConfig { light_paths: Paths::Count(light_paths), max_bounces, ..full() };
            let params = config.params(&scene, &scene.cameras[0], 0);
            for variant in variant::ALL {
                for spec in frame_buffers(&BASIC, variant.into(), &params) {
                    assert!(
                        spec.bytes <= 128 << 20,
                        "{} of {}: {} bytes",
                        spec.name,
                        variant.name,
                        spec.bytes
                    );
                }
            }
        }
    }
}

#[test]
fn missing_kernel_folder_is_refused_with_a_remedy() {
    let scene = load("plain-room");
    let open = |choice| session::open(&choice, &scene, scene.features(0.25), &[]).map(|_| ());
    let kernels = Source::Folder("no such folder".into());
    let gpu = RunnerChoice::Gpu { device: None, hardware: false, validation: false, kernels };
    let message = open(gpu).unwrap_err().to_string();
    assert!(message.contains("no such folder") && message.contains("cargo kernels"), "{message}");
    assert!(message.contains("--runner cpu"), "{message}");
    open(RunnerChoice::Cpu { threads: 1 }).unwrap();
}

#[test]
fn embedded_kernels_match_their_sources() {
    // Where the kernels' sources changed, every GPU test would be skipped: report it here.
    if let Err(error) = Source::Embedded.modules() {
        panic!("{error}");
    }
}
