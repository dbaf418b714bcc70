//! Whole frames: image means, gathers against each other, odd sizes.

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::{EnvironmentMap, Scene};
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::gather::accumulator::WORDS;
use caustics_kernels::gather::variant;
use caustics_kernels::interface::choice::{Caustics, IndirectEnd, IndirectShare, LightSampler};
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::method::Parts;
use caustics_kernels::method::basic;
use caustics_kernels::method::path::PATH;
use caustics_kernels::pass::more_points::MAX_POINTS;
use caustics_kernels::pass::step::STEP_HIT;
use caustics_tests::compare::{Tolerance, floats, words};
use caustics_tests::gpu::{gpu, watched_gpu};
use caustics_tests::parity::{self, RunnerPair, load, needs};
use caustics_tests::scenes::{open_air, room_of_lights};
use caustics_tests::statistics::Mean;
use caustics_tests::table::Table;
use glam::Vec3;

use super::config;

/// Number of frames of a mean.
const FRAMES: u32 = 4;

/// Means of the caustics and of all other light over an image, frame by frame.
fn means(choice: &RunnerChoice, scene: &Scene, features: Features, config: &RenderConfig) -> [Mean; 2] {
    let mut session = Session::new(choice, scene, &scene.cameras[0], config, features).unwrap();
    let mean = |image: &[Vec3]| {
        let sum = image.iter().map(|pixel| f64::from(pixel.element_sum())).sum::<f64>();
        sum / (3.0 * image.len() as f64)
    };
    let (mut caustics, mut path) = (vec![], vec![]);
    for frame in 0..FRAMES {
        session.frame(frame).unwrap();
        let image = session.image().unwrap();
        caustics.push(mean(&image.caustics));
        path.push(mean(&image.path));
    }
    if config.collection_points > 1 {
        let slots: Vec<[u32; 2]> = session.read("point_slots").unwrap();
        assert!(slots.iter().filter(|[_, further]| *further > 0).count() > 20, "further points");
    }
    [Mean::from_samples(&caustics), Mean::from_samples(&path)]
}

#[test]
fn image_means_agree_within_three_sigma() {
    image_means_agree(&[("mirror-room", load("mirror-room"))], &frames());
}

#[test]
fn image_means_agree_under_every_kind_of_light() {
    let mut under_a_sky = open_air().build();
    let texel = |index: u32| Vec3::splat(if index == 13 { 5.0 } else { 0.02 * (16 - index / 8) as f32 });
    let sky = EnvironmentMap::new(8, 4, (0..32).map(texel).collect());
    under_a_sky.set_environment(sky).expect("the sky is sound");
    image_means_agree(
        &[
            ("a spot and a directional light", open_air().build()),
            ("both, and a sky with a bright patch", under_a_sky),
            ("more lights than are all sampled", room_of_lights(7).build()),
        ],
        &frames(),
    );
}

/// Caustics in a rough mirror, by one point a pixel and by several: both runners choose some.
#[test]
fn image_means_agree_with_several_points_a_pixel() {
    let scenes = [("glossy-room", load("glossy-room"))];
    image_means_agree(&scenes, &RenderConfig { collection_points: MAX_POINTS, ..frames() });
}

/// Indirect light that collection points share, also between points in a mirror and points that are seen directly.
#[test]
fn image_means_agree_with_shared_indirect_light() {
    let scenes = [("mirror-room", load("mirror-room"))];
    image_means_agree(&scenes, &RenderConfig { indirect_share: Some(IndirectShare::Points), ..frames() });
}

/// Camera paths that end in the radiance cache, as both runners fill it.
#[test]
fn image_means_agree_with_the_radiance_cache() {
    let scenes = [("mirror-room", load("mirror-room"))];
    image_means_agree(&scenes, &RenderConfig { indirect_end: Some(IndirectEnd::Cache), ..frames() });
}

fn frames() -> RenderConfig {
    RenderConfig { width: 80, height: 45, light_paths: Paths::Count(32_768), ..config() }
}

/// Compares by one gather per tracer: the others give the same bits, by `gathers_on_the_gpu_equal_each_other` and
/// `every_gather_on_the_gpu_matches_brute_force_to_the_bit`. All scenes use the same kernels, which are compiled once.
fn image_means_agree(scenes: &[(&str, Scene)], config: &RenderConfig) {
    let Some(gpu) = gpu() else { return };
    let features = needs(scenes.iter().map(|(_, scene)| scene), config);
    let by_gather = |gather| RenderConfig { gather: Some(gather), ..config.clone() };
    for (title, scene) in scenes {
        let cpu =
            means(&RunnerChoice::Cpu { threads: 0 }, scene, features, &by_gather(&variant::PHOTONS_GRID));
        for &hardware in gpu.tracers() {
            let variant = if hardware { &variant::POINTS_RT } else { &variant::PHOTONS_GRID };
            let gpu = means(&gpu.choice(hardware), scene, features, &by_gather(variant));
            for (layer, cpu, gpu) in [("caustics", cpu[0], gpu[0]), ("path", cpu[1], gpu[1])] {
                let sigmas = cpu.sigmas(&gpu);
                eprintln!(
                    "{title}, {layer}, {} (hardware {hardware}): CPU {:.6e} +- {:.1e}, GPU {:.6e}: {sigmas:.4} sigma",
                    variant.name, cpu.value, cpu.error, gpu.value
                );
                assert!(cpu.value > 0.0 && cpu.agrees(&gpu, 3.0), "{title}, {layer}: {sigmas} sigma");
            }
        }
    }
}

/// The reference traces whole paths, 0.2 % of which may diverge.
#[test]
fn reference_agrees_but_for_0_2_percent_of_the_paths() {
    reference_agrees(&load("glossy-room"), &config(), Features::default());
}

/// The light BVH samples the same lights on a GPU, but where rounding decides.
#[test]
fn reference_with_a_light_bvh_agrees_but_for_0_2_percent_of_the_paths() {
    let config = RenderConfig { light_sampler: LightSampler::Bvh, ..config() };
    reference_agrees(&room_of_lights(40).build(), &config, Features::LIGHT_BVH);
}

fn reference_agrees(scene: &Scene, config: &RenderConfig, features: Features) {
    let Some(gpu) = watched_gpu() else { return };
    for &hardware in gpu.tracers() {
        let mut runners = RunnerPair::with(&gpu, hardware, scene, config, features);
        let params = runners.params;
        runners.run(&params, &(PATH.steps)(Parts::from(&variant::PHOTONS_GRID), &params));
        let (cpu, gpu_records) = runners.records::<f32>("path_radiance");
        assert!(cpu.iter().filter(|value| **value > 0.0).count() > cpu.len() / 2);
        let reason = "the parity rule: 0.2 % of the paths may diverge";
        let tolerance = Tolerance::relative(1.0e-3, 0.0, reason).except(2.0e-3, reason);
        let mut table =
            Table::new(&format!("reference, CPU against {} (hardware {hardware})", gpu.info.name));
        table.add("reference", [floats("path_radiance", 3, &cpu, &gpu_records, tolerance)]);
        table.finish();
    }
}

#[test]
fn gathers_on_the_gpu_equal_each_other() {
    let Some(gpu) = gpu() else { return };
    for &hardware in gpu.tracers() {
        let scene = load("mirror-room");
        let (light_paths, caustics) = (16_384, Caustics::Any);
        let fewer = RenderConfig {
            width: 80,
            height: 45,
            light_paths: Paths::Count(light_paths),
            caustics,
            ..config()
        };
        let mut runners = RunnerPair::open(&gpu, hardware, &scene, &fewer);
        let params = runners.params;
        let mut table = Table::new(&format!("gathers against brute force on {}", gpu.info.name));
        let mut sums = |variant| {
            runners.gpu.run(&params, &basic::steps(variant, &params)).expect("the frame runs");
            parity::records::<u32>(&mut *runners.gpu, "accumulator")
        };
        let brute = sums(&variant::BRUTE);
        assert!(brute.chunks(WORDS as usize).map(|point| point[6]).sum::<u32>() > 2000);
        let others = variant::ALL.iter().filter(|variant| variant.name != "brute");
        for variant in others.filter(|variant| hardware || !variant.hardware) {
            // One device decides a pair by the same numbers in every gather, so that even pairs at the bound agree.
            let found = sums(variant);
            table.add(variant.name, [words("accumulator", WORDS as usize, &brute, &found, Tolerance::EXACT)]);
        }
        table.finish();
    }
}

#[test]
fn odd_sizes_run_and_the_validation_layer_is_silent() {
    let Some(gpu) = watched_gpu() else { return };
    let scene = load("mirror-room");
    for (width, height) in [(1, 1), (191, 107)] {
        for &hardware in gpu.tracers() {
            let config = RenderConfig { width, height, light_paths: Paths::Count(5000), ..config() };
            let mut runners = RunnerPair::open(&gpu, hardware, &scene, &config);
            for variant in variant::ALL.iter().filter(|variant| hardware || !variant.hardware) {
                runners.gpu.run(&runners.params, &basic::steps(variant, &runners.params)).unwrap_or_else(
                    |error| panic!("{width}x{height} {} (hardware {hardware}): {error:#}", variant.name),
                );
                let image = parity::records::<f32>(&mut *runners.gpu, "display_color");
                assert_eq!(image.len(), 3 * (width * height) as usize);
                assert!(image.iter().all(|value| (0.0..=1.0).contains(value)));
            }
        }
    }
}

#[test]
fn detects_another_seed() {
    let Some(gpu) = gpu() else { return };
    let scene = load("mirror-room");
    let small = RenderConfig { width: 48, height: 27, light_paths: Paths::Count(4096), ..config() };
    let mut runners = RunnerPair::open(&gpu, false, &scene, &small);
    let params = runners.params;
    let mut table = |seed| {
        let steps = basic::steps(&variant::PHOTONS_GRID, &params);
        runners.cpu.run(&params, &steps).unwrap();
        runners.gpu.run(&FrameParams { seed, ..params }, &steps).unwrap();
        let mut table = Table::new("frames of two seeds");
        for buffer in ["path_radiance", "caustic_radiance", "display_color"] {
            let (cpu, gpu) = runners.records::<f32>(buffer);
            let near =
                Tolerance::relative(1.0e-3, 1.0, "the parity rule").except(0.02, "whole paths may diverge");
            table.add(buffer, [floats(buffer, 3, &cpu, &gpu, near)]);
        }
        table
    };
    table(params.seed).finish();
    let other = table(params.seed + 1);
    assert_eq!(other.failures().len(), 3, "{other}");
}

#[test]
fn detects_one_perturbed_input() {
    let Some(gpu) = gpu() else { return };
    let scene = load("mirror-room");
    let mut runners = RunnerPair::open(&gpu, false, &scene, &config());
    let mut rays = caustics_tests::rays::through(&scene, 1000);
    runners.write("rays", &rays);
    rays[617].direction = -rays[617].direction;
    runners.gpu.write("rays", bytemuck::cast_slice(&rays)).unwrap();
    runners.step(&STEP_HIT, rays.len());
    let (cpu, gpu) = runners.head::<caustics_kernels::interface::ray::Hit>("hits", rays.len());
    let ids = |hits: &[caustics_kernels::interface::ray::Hit]| {
        hits.iter().map(|hit| hit.triangle).collect::<Vec<_>>()
    };
    let difference = words("triangle", 1, &ids(&cpu), &ids(&gpu), Tolerance::EXACT);
    assert!(!difference.passes() && difference.indices.contains(&617));
}

/// A device renders the same bits tile by tile, in buffers of the size of a tile.
#[test]
fn tiled_image_equals_the_whole_image_to_the_bit_on_a_device() {
    let Some(gpu) = gpu() else { return };
    let scene = load("mirror-room");
    let [whole, tiled] = [1, 3].map(|tiles| {
        let config = RenderConfig { width: 64, height: 40, tiles: Some(tiles), auxiliary: true, ..config() };
        // Take the features of other tests, whose kernels are compiled already.
        let features = needs([&scene], &config);
        let choice = gpu.choice(false);
        let camera = &scene.cameras[0];
        let mut session = Session::new(
            &choice,
            &scene,
            camera,
            &RenderConfig { gather: Some(&variant::PHOTONS_GRID), ..config.clone() },
            features,
        )
        .unwrap();
        session.frame(1).unwrap();
        (session.image().unwrap(), session.tiles())
    });
    assert_eq!((whole.1, tiled.1), (1, 3));
    assert!(whole.0 == tiled.0);
}
