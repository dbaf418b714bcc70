//! The baseline `kim2019`: its energy and its error beside OurBasic's where a caustic is seen directly, and no caustics
//! in a mirror.

use caustics::render_config::{Paths, RenderConfig};
use caustics::rendered_image::RenderedImage;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_bench::error::{FLIP_CAUSTICS, MeasuredImage, Seen};
use caustics_kernels::interface::choice::PixelFilter;
use caustics_kernels::method::Method;
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::method::kim2019::{KIM2019, KIM2019_FACING};
use caustics_kernels::method::progressive::PROGRESSIVE;
use caustics_tests::direct::mean_and_error;
use caustics_tests::gpu::watched_gpu;
use caustics_tests::scenes::{Builder, committed, lambert, metal};
use glam::{DVec3, Vec3};

fn config(seed: u32) -> RenderConfig {
    RenderConfig {
        width: 240,
        height: 135,
        light_paths: Paths::Count(16_402),
        seed,
        ..RenderConfig::default()
    }
}

fn session(choice: &RunnerChoice, scene: &Scene, config: &RenderConfig, method: &'static Method) -> Session {
    let features = scene.features(config.specular_roughness);
    Session::new(choice, scene, &scene.cameras[0], &RenderConfig { method, ..config.clone() }, features)
        .unwrap()
}

fn images(scene: &Scene, config: &RenderConfig, method: &'static Method, frames: u32) -> Vec<RenderedImage> {
    let mut session = session(&RunnerChoice::Cpu { threads: 0 }, scene, config, method);
    let mut image = |frame| {
        session.frame(frame).unwrap();
        session.image().unwrap()
    };
    (0..frames).map(&mut image).collect()
}

fn sum(layer: &[Vec3]) -> f64 {
    layer.iter().map(|value| f64::from(value.element_sum())).sum()
}

/// Sums of the directly seen caustics, frame by frame.
fn direct(images: &[RenderedImage]) -> Vec<f64> {
    let of_frame = |image: &RenderedImage| -> f64 {
        let pairs = image.depth.iter().zip(&image.caustics);
        pairs.filter(|(depth, _)| **depth == 1.0).map(|(_, caustics)| f64::from(caustics.element_sum())).sum()
    };
    images.iter().map(of_frame).collect()
}

/// The caustic of a ring on a floor, seen directly and whole.
#[test]
fn kim_conserves_the_energy_of_a_caustic_seen_directly() {
    let scene = committed("moving-caster");
    let many = RenderConfig { light_paths: Paths::Count(200_000), ..config(1) };
    let of_frames = |method| direct(&images(&scene, &many, method, 40));
    // Use the same light paths, so that ratios frame by frame have little noise.
    let reference = of_frames(&PROGRESSIVE);
    let ratio = |method| {
        let pairs = of_frames(method).into_iter().zip(&reference).map(|(own, reference)| own / reference);
        mean_and_error(&pairs.collect::<Vec<_>>())
    };
    let (kim, facing) = (ratio(&KIM2019), ratio(&KIM2019_FACING));
    println!("energy {:.4} +- {:.4}; with Kim's own area {:.4}", kim.0, kim.1, facing.0);
    // Kim's pixels and discs weigh single bright photons differently.
    assert!(3.0 * kim.1 < 0.02 && (kim.0 - 1.0).abs() < 0.02, "{} +- {}", kim.0, kim.1);
    // The camera looks down at a slant: a pixel that faces it is smaller than its footprint.
    assert!(facing.0 > 1.05, "the areas differ: {}", facing.0);
}

/// A caustic on a floor seen at 8 to 20 degrees: one pixel of the small image reaches over a tenth of its distance. At
/// any size the splatted energy is that of discs, which lose nothing in the middle of a plane.
#[test]
fn kim_conserves_the_energy_of_a_grazing_caustic() {
    let mut b = Builder::default();
    let (floor, mirror) = (b.material(lambert(0.6)), b.material(metal(0.9, 0.0)));
    b.panel(floor, DVec3::ZERO, 6.0 * DVec3::Z, 6.0 * DVec3::X);
    // A small mirror high above sends the light of a spot light below it to the middle of the floor.
    b.panel(mirror, DVec3::new(0.0, 3.0, 0.0), 0.2 * DVec3::X, 0.3 * DVec3::Z);
    b.spot(DVec3::new(0.0, 1.5, 0.0), DVec3::Y, 0.25, 0.3, 1.0);
    b.camera(DVec3::new(0.0, 0.6, 3.0), DVec3::new(0.0, 0.0, 0.0), 0.7);
    let scene = b.build();
    for (width, height) in [(128, 80), (512, 320)] {
        let size = |seed| RenderConfig { width, height, light_paths: Paths::Count(50_000), ..config(seed) };
        let jittered = RenderConfig { pixel_filter: PixelFilter::Box, ..size(1) };
        let reference = direct(&images(&scene, &jittered, &BASIC, 8));
        let kim = direct(&images(&scene, &size(1), &KIM2019, 8));
        // Use the same light paths, so that ratios frame by frame have little noise.
        let ratios: Vec<f64> = kim.iter().zip(&reference).map(|(own, reference)| own / reference).collect();
        let (ratio, error) = mean_and_error(&ratios);
        println!("{width}x{height}: energy {ratio:.4} +- {error:.4}");
        assert!(3.0 * error < 0.02 && (ratio - 1.0).abs() < 0.02, "{width}x{height}: {ratio} +- {error}");
    }
}

/// Errors of single frames beside OurBasic's with the same light paths, on the floor and the outside of the ring. Kim's
/// method does not show the caustics that the ring's inside mirrors.
#[test]
fn kim_has_at_most_the_error_of_our_basic_on_a_caustic_seen_directly() {
    let scene = committed("ring");
    let (kim, basic) = (images(&scene, &config(1), &KIM2019, 12), images(&scene, &config(1), &BASIC, 12));
    let depth = &basic[0].depth;
    let caustics = |image: &RenderedImage| -> Vec<Vec3> {
        let pairs = depth.iter().zip(&image.caustics);
        pairs.map(|(depth, value)| if *depth == 1.0 { *value } else { Vec3::ZERO }).collect()
    };
    let frames =
        images(&scene, &RenderConfig { light_paths: Paths::Count(131_072), ..config(9) }, &PROGRESSIVE, 128);
    let mean = |layer: &dyn Fn(&RenderedImage) -> Vec<Vec3>| {
        let mut mean = vec![Vec3::ZERO; depth.len()];
        for frame in &frames {
            mean.iter_mut().zip(layer(frame)).for_each(|(sum, value)| *sum += value / frames.len() as f32);
        }
        mean
    };
    let path = mean(&|image| image.path.clone());
    let with = |caustics| RenderedImage {
        width: 240,
        height: 135,
        path: path.clone(),
        caustics,
        ..RenderedImage::default()
    };
    let reference = with(mean(&caustics));
    let measured_reference = MeasuredImage::new(&reference, &reference);
    let flip = |images: &[RenderedImage]| -> Vec<f64> {
        let error = |image| {
            let measured = MeasuredImage::new(&with(caustics(image)), &reference);
            (FLIP_CAUSTICS.compute)(&Seen::one(&measured, &measured_reference)).unwrap().value
        };
        images.iter().map(error).collect()
    };
    let (kim, basic) = (flip(&kim), flip(&basic));
    // With the same light paths, their noise cancels in a frame's ratio.
    let ratios: Vec<f64> = kim.iter().zip(&basic).map(|(kim, basic)| kim / basic).collect();
    let (ratio, error) = mean_and_error(&ratios);
    println!("FLIP of the caustics: kim2019 / basic = {ratio:.4} +- {error:.4}; basic {:.5}", basic[0]);
    assert!(basic[0] > 0.01, "the test has nothing to check");
    assert!(3.0 * error < 0.02 && ratio <= 1.0 + 3.0 * error, "{ratio} +- {error}");
}

/// The wall mirror of mirror-room: pixels with their collection point behind it.
#[test]
fn kim_shows_no_caustic_in_a_perfect_mirror() {
    let scene = committed("mirror-room");
    let many = RenderConfig { light_paths: Paths::Count(100_000), ..config(1) };
    let kim = images(&scene, &many, &KIM2019, 1).remove(0);
    let basic = images(&scene, &many, &BASIC, 1).remove(0);
    let behind = |image: &RenderedImage| -> (usize, f64) {
        let pairs = image.depth.iter().zip(&image.caustics);
        let layer: Vec<Vec3> =
            pairs.filter(|(depth, _)| **depth > 1.0).map(|(_, caustics)| *caustics).collect();
        (layer.len(), sum(&layer))
    };
    let ((pixels, dark), (_, light)) = (behind(&kim), behind(&basic));
    println!("{pixels} pixels behind mirrors and glass: kim2019 {dark}, basic {light}");
    assert!(pixels > 3000 && light > 1.0, "the test has nothing to check");
    assert_eq!(dark, 0.0);
    assert!(sum(&kim.caustics) > 0.0, "directly seen caustics are missing");
}

#[test]
fn a_gpu_splats_as_the_cpu_does() {
    let Some(gpu) = watched_gpu() else { return };
    let scene = committed("ring");
    let small = RenderConfig { width: 96, height: 54, light_paths: Paths::Count(40_000), ..config(1) };
    let expected = direct(&images(&scene, &small, &KIM2019, 3)).iter().sum::<f64>();
    for &hardware in gpu.tracers() {
        let mut session = session(&gpu.choice(hardware), &scene, &small, &KIM2019);
        let mut frame = |frame| {
            session.frame(frame).unwrap();
            session.image().unwrap()
        };
        let found = direct(&(0..3).map(&mut frame).collect::<Vec<_>>()).iter().sum::<f64>();
        println!("caustics: CPU {:.5}, GPU {:.5} (hardware {hardware})", expected, found);
        // The same light paths, of which 0.2 % may diverge.
        assert!((found / expected - 1.0).abs() < 2.0e-3);
    }
}
