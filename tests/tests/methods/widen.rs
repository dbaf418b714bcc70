//! Discs that widen where photons were few: their radius, and their gain.

use caustics::render_config::{Paths, Radius, RenderConfig};
use caustics::rendered_image::RenderedImage;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::denoiser::ATROUS;
use caustics_kernels::emission::AIMED;
use caustics_kernels::gather::accumulator::WORDS;
use caustics_kernels::gather::variant::{self, PHOTONS_GRID, Variant};
use caustics_kernels::history::VALIDATED;
use caustics_kernels::interface::history::HistoryPoint;
use caustics_kernels::pass::widen::{ENOUGH, WIDEST};
use caustics_tests::frames::around;
use caustics_tests::scenes::*;

const CPU: RunnerChoice = RunnerChoice::Cpu { threads: 0 };
const SIZE: (usize, usize) = (160, 90);

fn config(light_paths: u32, seed: u32) -> RenderConfig {
    let (width, height) = (SIZE.0 as u32, SIZE.1 as u32);
    RenderConfig {
        width,
        height,
        light_paths: Paths::Count(light_paths),
        seed,
        emission: &AIMED,
        radius: Radius::Auto,
        ..RenderConfig::default()
    }
}

fn open(scene: &Scene, config: &RenderConfig, gather: &'static Variant) -> Session {
    let features = scene.features(config.specular_roughness);
    Session::new(
        &CPU,
        scene,
        &scene.cameras[0],
        &RenderConfig { gather: Some(gather), ..config.clone() },
        features,
    )
    .expect("a session opens")
}

/// Image of a frame; the frames before it are rendered too.
fn image(session: &mut Session, frame: u32) -> RenderedImage {
    (0..=frame).for_each(|frame| drop(session.frame(frame).expect("a frame runs")));
    session.image().expect("an image")
}

/// The radius of each disc follows from the photons that the discs around took in the last frame, by a sum in f64.
#[test]
fn widened_radius_follows_the_photon_counts_of_the_last_frame() {
    let scene = committed("cornell-box");
    let mut session = open(&scene, &config(3000, 1), &PHOTONS_GRID);
    let mut plain = open(&scene, &RenderConfig { radius: Radius::Px(1.0), ..config(3000, 1) }, &PHOTONS_GRID);
    for session in [&mut session, &mut plain] {
        session.frame(0).expect("a frame runs");
    }
    let (mut narrow, mut between, mut wide) = (0, 0, 0);
    for frame in 1..3 {
        let words: Vec<u32> = session.read("accumulator").expect("sums");
        let scale: Vec<f32> = session.read("radius_now").expect("radii");
        let before = plain.image().expect("an image").radius;
        let [radii, bases] = [&mut session, &mut plain].map(|session| {
            session.frame(frame).expect("a frame runs");
            session.image().expect("an image").radius
        });
        for (pixel, (radius, base)) in
            radii.iter().zip(&bases).enumerate().filter(|(_, (_, base))| **base > 0.0)
        {
            let taken = |pixel: &usize| {
                let count = words[pixel * WORDS as usize + WORDS as usize - 1];
                f64::from(count) / f64::from(scale[*pixel]).powi(2)
            };
            // Pixels without a disc do not count.
            let discs: Vec<f64> =
                around(pixel, 2, SIZE).iter().filter(|pixel| before[**pixel] > 0.0).map(taken).collect();
            let mean = discs.iter().sum::<f64>() / discs.len() as f64;
            let expected = (f64::from(ENOUGH) / mean).sqrt().clamp(1.0, f64::from(WIDEST));
            let found = f64::from(radius / base);
            assert!((found - expected).abs() < 1.0e-4, "{pixel}: {found}, {expected}");
            if found < 1.001 {
                narrow += 1;
            } else if found > 2.999 {
                wide += 1;
            } else {
                between += 1;
            }
        }
    }
    println!("{narrow} narrow, {between} between, {wide} wide");
    assert!(narrow > 100 && between > 1000 && wide > 1000);
}

/// The denoiser's planes and a history's reuse go by the radius of the settings, and ignore wider discs.
#[test]
fn widened_discs_change_neither_denoiser_nor_history() {
    let scene = committed("cornell-box");
    let run = |radius| {
        let config = RenderConfig { radius, denoiser: &ATROUS, history: &VALIDATED, ..config(3000, 1) };
        let mut session = open(&scene, &config, &PHOTONS_GRID);
        let found = image(&mut session, 3);
        let points: Vec<HistoryPoint> = session.read("history_points").expect("points");
        let samples: Vec<f32> = points.iter().map(|point| point.samples).collect();
        (found.path, samples, found.radius)
    };
    let (plain, wide) = (run(Radius::Px(1.0)), run(Radius::Auto));
    assert!(plain.0 == wide.0, "the denoised light differs");
    assert!(
        plain.1 == wide.1 && wide.1.iter().filter(|samples| **samples > 3.0).count() > 1000,
        "the reused light differs"
    );
    assert!(wide.2.iter().sum::<f32>() > 1.5 * plain.2.iter().sum::<f32>());
}

/// With few light paths the error is below that of either radius, the light is the same, and every gather agrees.
#[test]
fn widened_discs_have_less_error_than_fixed_radii_at_4096_light_paths() {
    let scene = committed("mirror-room");
    let fine = RenderConfig { radius: Radius::Px(0.5), ..config(1 << 19, 1000) };
    let mut session = open(&scene, &fine, &PHOTONS_GRID);
    let frames = 12;
    let (mut caustics, mut all) = (vec![0.0; SIZE.0 * SIZE.1], vec![0.0; SIZE.0 * SIZE.1]);
    for frame in 0..frames {
        session.frame(frame).expect("a frame runs");
        let image = session.image().expect("an image");
        for pixel in 0..caustics.len() {
            let per_frame = |value: glam::Vec3| f64::from(value.element_sum()) / f64::from(frames);
            caustics[pixel] += per_frame(image.caustics[pixel]);
            all[pixel] += per_frame(image.caustics[pixel]) + per_frame(image.path[pixel]);
        }
    }
    let dark = 0.1 * all.iter().sum::<f64>() / all.len() as f64;
    let error_and_light = |radius, light_paths, seeds: u32| {
        let count = f64::from(seeds);
        let (mut error, mut light) = (0.0, 0.0);
        for seed in 0..seeds {
            let config = RenderConfig { radius, ..config(light_paths, seed) };
            let found = image(&mut open(&scene, &config, &PHOTONS_GRID), 2).caustics;
            for (pixel, found) in found.iter().enumerate() {
                let found = f64::from(found.element_sum());
                error += (found - caustics[pixel]).powi(2) / (all[pixel] * all[pixel] + dark * dark);
                light += found;
            }
        }
        (error / count / caustics.len() as f64, light / count / caustics.iter().sum::<f64>())
    };
    let few = 1 << 12;
    let [narrow, wide, auto] =
        [Radius::Px(1.0), Radius::Px(WIDEST), Radius::Auto].map(|radius| error_and_light(radius, few, 32));
    println!("error and light: narrow {narrow:.4?}, wide {wide:.4?}, by photons {auto:.4?}");
    assert!(auto.0 < 0.95 * narrow.0.min(wide.0));
    // Wide discs take light beside narrow ones, which give none back. The effect falls with the number of paths.
    let many = 1 << 17;
    let [narrow_many, auto_many] =
        [Radius::Px(1.0), Radius::Auto].map(|radius| error_and_light(radius, many, 2));
    println!("of many paths: narrow {narrow_many:.4?}, by photons {auto_many:.4?}");
    assert!((auto.1 - narrow.1).abs() < 0.05 && (auto_many.1 - narrow_many.1).abs() < 0.01);
    let by = |gather| image(&mut open(&scene, &config(1 << 12, 1), gather), 2).caustics;
    let one = by(&PHOTONS_GRID);
    for gather in variant::ALL.iter().filter(|gather| !gather.hardware && gather.name != "brute") {
        assert!(one == by(gather), "{}", gather.name);
    }
}
