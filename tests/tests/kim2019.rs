//! The baseline `kim2019`: its energy and its error beside OurBasic's where a caustic is seen directly, and that it shows
//! none in a mirror.

use caustics::experiment::error::Look;
use caustics::method::Method;
use caustics::method::basic::BASIC;
use caustics::method::kim2019::{KIM2019, KIM2019_FACING};
use caustics::method::progressive::PROGRESSIVE;
use caustics::method::settings::Settings;
use caustics::picture::Picture;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::gather::variant::PHOTONS_GRID;
use caustics_tests::direct::mean_and_error;
use caustics_tests::gpu::gpu;
use caustics_tests::scenes::committed;
use glam::Vec3;

fn settings(seed: u32) -> Settings {
    Settings { width: 240, height: 135, light_paths: 16_402, seed, ..Settings::default() }
}

fn session(choice: &RunnerChoice, scene: &Scene, settings: &Settings, method: &'static Method) -> Session {
    let needs = scene.needs(settings.specular_roughness);
    Session::new(choice, scene, &scene.cameras[0], settings, method, &PHOTONS_GRID, needs).unwrap()
}

fn pictures(scene: &Scene, settings: &Settings, method: &'static Method, frames: u32) -> Vec<Picture> {
    let mut session = session(&RunnerChoice::Cpu { threads: 0 }, scene, settings, method);
    let mut picture = |frame| {
        session.frame(frame).unwrap();
        session.picture().unwrap()
    };
    (0..frames).map(&mut picture).collect()
}

fn sum(layer: &[Vec3]) -> f64 {
    layer.iter().map(|value| f64::from(value.element_sum())).sum()
}

/// Sums of the caustics that are seen directly, frame by frame.
fn direct(pictures: &[Picture]) -> Vec<f64> {
    let of_frame = |picture: &Picture| -> f64 {
        let pairs = picture.depth.iter().zip(&picture.caustics);
        pairs.filter(|(depth, _)| **depth == 1.0).map(|(_, caustics)| f64::from(caustics.element_sum())).sum()
    };
    pictures.iter().map(of_frame).collect()
}

/// The caustic of a ring on a floor, seen directly and whole.
#[test]
fn kim_conserves_the_energy_of_a_caustic_seen_directly() {
    let scene = committed("moving-caster");
    let many = Settings { light_paths: 200_000, ..settings(1) };
    let of_frames = |method| direct(&pictures(&scene, &many, method, 40));
    // The same light paths, so that ratios frame by frame have little noise.
    let truth = of_frames(&PROGRESSIVE);
    let ratio = |method| {
        let pairs = of_frames(method).into_iter().zip(&truth).map(|(own, truth)| own / truth);
        mean_and_error(&pairs.collect::<Vec<_>>())
    };
    let (kim, facing) = (ratio(&KIM2019), ratio(&KIM2019_FACING));
    println!("energy {:.4} +- {:.4}; with Kim's own area {:.4}", kim.0, kim.1, facing.0);
    // Kim's pixels and discs weigh single bright deposits differently.
    assert!(3.0 * kim.1 < 0.02 && (kim.0 - 1.0).abs() < 0.02, "{} +- {}", kim.0, kim.1);
    // The camera looks down at a slant: a pixel that faces it is smaller than its footprint.
    assert!(facing.0 > 1.05, "the areas differ: {}", facing.0);
}

/// Errors of single frames beside those of OurBasic with the same light paths.
#[test]
fn kim_is_as_good_as_our_basic_where_a_caustic_is_seen_directly() {
    let scene = committed("ring");
    let frames = pictures(&scene, &Settings { light_paths: 131_072, ..settings(9) }, &PROGRESSIVE, 128);
    let mean = |layer: fn(&Picture) -> &Vec<Vec3>| {
        let count = frames.len() as f32;
        (0..240 * 135).map(|pixel| frames.iter().map(|of| layer(of)[pixel]).sum::<Vec3>() / count).collect()
    };
    let (path, caustics) = (mean(|of| &of.path), mean(|of| &of.caustics));
    let truth = Picture { width: 240, height: 135, path, caustics, ..Picture::default() };
    let reference = Look::new(&truth, &truth);
    let flip = |method| {
        let errors = pictures(&scene, &settings(1), method, 6);
        let flip = |picture| Look::new(picture, &truth).errors(&reference, 0.0).flip_caustics.unwrap();
        mean_and_error(&errors.iter().map(flip).collect::<Vec<_>>())
    };
    let (kim, basic) = (flip(&KIM2019), flip(&BASIC));
    println!(
        "FLIP of the caustics: kim2019 {:.5} +- {:.5}, basic {:.5} +- {:.5}",
        kim.0, kim.1, basic.0, basic.1
    );
    assert!(basic.0 > 0.01, "the test has lost its subject");
    // A pixel is as large as a disc, but the noise of neighbouring discs that overlap is shared: seen are 1.5 % more.
    assert!(kim.0 <= 1.03 * basic.0, "{} {}", kim.0, basic.0);
}

/// The wall mirror of mirror-room: pixels whose collection point lies behind it.
#[test]
fn kim_shows_no_caustic_in_a_perfect_mirror() {
    let scene = committed("mirror-room");
    let many = Settings { light_paths: 100_000, ..settings(1) };
    let kim = pictures(&scene, &many, &KIM2019, 1).remove(0);
    let basic = pictures(&scene, &many, &BASIC, 1).remove(0);
    let behind = |picture: &Picture| -> (usize, f64) {
        let pairs = picture.depth.iter().zip(&picture.caustics);
        let layer: Vec<Vec3> =
            pairs.filter(|(depth, _)| **depth > 1.0).map(|(_, caustics)| *caustics).collect();
        (layer.len(), sum(&layer))
    };
    let ((pixels, dark), (_, light)) = (behind(&kim), behind(&basic));
    println!("{pixels} pixels behind mirrors and glass: kim2019 {dark}, basic {light}");
    assert!(pixels > 3000 && light > 1.0, "the test has lost its subject");
    assert_eq!(dark, 0.0);
    assert!(sum(&kim.caustics) > 0.0, "what is seen directly is there");
}

#[test]
fn a_gpu_splats_as_the_cpu_does() {
    let Some(gpu) = gpu() else { return };
    let scene = committed("ring");
    let small = Settings { width: 96, height: 54, light_paths: 40_000, ..settings(1) };
    let expected = direct(&pictures(&scene, &small, &KIM2019, 3)).iter().sum::<f64>();
    for &hardware in gpu.tracers() {
        let mut session = session(&gpu.choice(hardware), &scene, &small, &KIM2019);
        let mut frame = |frame| {
            session.frame(frame).unwrap();
            session.picture().unwrap()
        };
        let found = direct(&(0..3).map(&mut frame).collect::<Vec<_>>()).iter().sum::<f64>();
        println!("caustics: CPU {:.5}, GPU {:.5} (hardware {hardware})", expected, found);
        // The same light paths, of which 0.2 % may diverge.
        assert!((found / expected - 1.0).abs() < 2.0e-3);
    }
}
