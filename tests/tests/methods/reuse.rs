//! Histories: reused light of the last frame, in scenes at rest and under a moving camera.

mod curved;

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::{Scene, SceneCamera};
use caustics_kernels::history::{NONE, PAPER, VALIDATED};
use caustics_tests::frames::{Frames, sums};
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};

/// A floor seen head on, under a point light and beside a mirror that reflects its light.
fn lit_floor() -> Scene {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.5));
    let mirror = b.material(metal(0.8, 0.0));
    b.panel(floor, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    b.panel(mirror, DVec3::new(1.0, 1.01, 0.0), DVec3::Z, DVec3::Y);
    b.light(DVec3::new(0.0, 1.0, 0.0), 5.0);
    b.camera(DVec3::new(-0.2, 3.0, 0.1), DVec3::new(-0.2, 0.0, 0.1), 0.4);
    b.build()
}

fn config(width: u32, height: u32, light_paths: u32) -> RenderConfig {
    RenderConfig { width, height, light_paths: Paths::Count(light_paths), ..RenderConfig::default() }
}

/// O8: the paper's history blends 0.2 of a frame into 0.8 of the mean.
#[test]
fn paper_history_blends_a_fifth_of_each_frame() {
    papers_moments(0, 40);
}

/// Checks that formula pixel by pixel; returns the moments of a frame and of the paper's history over `count` frames
/// after `warm`.
fn papers_moments(warm: u32, count: u32) -> [Vec<(f64, f64)>; 2] {
    let (scene, config) = (lit_floor(), config(48, 32, 40_000));
    let (mut none, mut paper) = (Frames::new(&scene, &config, &NONE), Frames::new(&scene, &config, &PAPER));
    let pixels = (config.width * config.height) as usize;
    let mut moments = [vec![(0.0, 0.0); pixels], vec![(0.0, 0.0); pixels]];
    let mut mean = vec![0.0; pixels];
    for frame in 0..warm + count {
        let layers = [sums(&none.render()), sums(&paper.render())];
        for pixel in 0..pixels {
            // Blend by the formula, pixel by pixel: head on, no point has a neighbour in its disc.
            let fresh = layers[0][pixel];
            mean[pixel] = if frame == 0 { fresh } else { 0.8 * mean[pixel] + 0.2 * fresh };
            assert!((layers[1][pixel] - mean[pixel]).abs() <= 1e-4 * mean[pixel].max(1e-3));
            if frame >= warm {
                for (moments, layer) in moments.iter_mut().zip(&layers) {
                    moments[pixel].0 += layer[pixel];
                    moments[pixel].1 += layer[pixel] * layer[pixel];
                }
            }
        }
    }
    moments
}

/// In a scene at rest the validated history is the mean of all frames: its variance falls as 1/n.
#[test]
fn validated_history_of_a_still_scene_is_the_mean_of_its_frames() {
    let (scene, config) = (committed("mirror-room"), config(80, 45, 20_000));
    let (mut none, mut validated) =
        (Frames::new(&scene, &config, &NONE), Frames::new(&scene, &config, &VALIDATED));
    let mut mean: Vec<f64> = Vec::new();
    let frames = 64;
    for frame in 0..frames {
        let (fresh, blended) = (none.render(), validated.render());
        if frame == 0 {
            assert_eq!(fresh, blended, "the first frame has no history");
            mean = sums(&fresh);
        }
        let n = f64::from(frame + 1);
        mean.iter_mut().zip(sums(&fresh)).for_each(|(mean, fresh)| *mean += (fresh - *mean) / n);
    }
    let history = validated.history();
    let points: Vec<_> = history.iter().filter(|point| point.samples > 0.0).collect();
    let dropped = points.iter().filter(|point| point.samples < frames as f32).count();
    println!("{dropped} of {} points dropped history", points.len());
    assert!(points.len() > 3000 && dropped * 20 <= points.len());

    let blended = sums(&validated.session.read("caustic_radiance").unwrap());
    let whole: f64 = mean.iter().sum();
    let error: f64 = blended.iter().zip(&mean).map(|(a, b)| (a - b).abs()).sum();
    println!("relative distance to the mean of {frames} frames: {:.2e}", error / whole);
    // Coats choose one lobe per frame: there a point's history skips frames.
    assert!(error < 0.02 * whole, "{error} of {whole}");
}

/// After 64 frames of a scene at rest the variance between runs is more than 30 times below that of a frame.
#[test]
fn validated_history_of_64_still_frames_lowers_the_variance_30_times() {
    let (scene, seeds) = (committed("mirror-room"), 6);
    let last = |history, frames: u32| -> Vec<Vec<f64>> {
        let run = |seed| {
            let config = RenderConfig { seed, ..config(64, 36, 10_000) };
            let mut all = Frames::new(&scene, &config, history);
            (1..frames).for_each(|_| drop(all.render()));
            sums(&all.render())
        };
        (0..seeds).map(run).collect()
    };
    let variance = |runs: &[Vec<f64>]| -> f64 {
        let of_pixel = |pixel: usize| {
            let mean = runs.iter().map(|run| run[pixel]).sum::<f64>() / runs.len() as f64;
            runs.iter().map(|run| (run[pixel] - mean).powi(2)).sum::<f64>()
        };
        (0..runs[0].len()).map(of_pixel).sum()
    };
    let gain = variance(&last(&NONE, 1)) / variance(&last(&VALIDATED, 64));
    println!("variance of a frame over that after 64 frames: {gain:.1}");
    assert!(gain >= 30.0, "{gain}");
}

/// A narrow line of light that crosses the floor at an angle.
fn line_of_light() -> Scene {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.5));
    let mirror = b.material(metal(0.9, 0.0));
    b.panel(floor, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    // A narrow strip of mirror reflects a narrow line of light.
    let across = DVec3::new(0.25, 0.0, 1.0).normalize();
    b.panel(mirror, DVec3::new(1.0, 1.0, 0.0), across, 0.006 * DVec3::Y);
    b.light(DVec3::new(0.0, 2.0, 0.0), 5.0);
    b.camera(DVec3::new(-0.3, 2.0, 0.0), DVec3::new(-0.3, 0.0, 0.0), 0.5);
    b.build()
}

fn moved(camera: &SceneCamera, by: Vec3) -> SceneCamera {
    SceneCamera { position: camera.position + by, ..camera.clone() }
}

/// Root mean square width of the line (px), row by row.
fn width_of_line(layer: &[f64], width: usize) -> f64 {
    let (mut variance, mut weight) = (0.0, 0.0);
    for row in layer.chunks(width) {
        let sum: f64 = row.iter().sum();
        if sum > 0.0 {
            let moment =
                |p: i32| row.iter().enumerate().map(|(x, v)| v * (x as f64).powi(p)).sum::<f64>() / sum;
            variance += sum * (moment(2) - moment(1).powi(2));
            weight += sum;
        }
    }
    (variance / weight).sqrt()
}

/// A line of light is no wider after 100 frames: exactly where nothing moves, and under a camera that pans by fractions
/// of a pixel. There the paper's means over neighbours blur.
#[test]
fn validated_history_widens_a_line_of_light_by_less_than_0_1_px() {
    line_stays_narrow(Vec3::new(0.0061, 0.0, 0.0013));
}

/// Compares widths under a camera that moves by `step` (m) per frame.
fn line_stays_narrow(step: Vec3) {
    let (scene, config) = (line_of_light(), config(96, 64, 60_000));
    let camera = &scene.cameras[0];
    let last = moved(camera, step * 100.0);
    // The line itself: one frame of very many light paths.
    let many = RenderConfig { light_paths: Paths::Count(100 * config.max_light_paths()), ..config.clone() };
    let width = |layer: &[Vec3]| width_of_line(&sums(layer), config.width as usize);
    let line = width(&Frames::new(&scene, &many, &NONE).pose(&scene, &last));
    let [paper, validated] = [&PAPER, &VALIDATED].map(|history| {
        let mut frames = Frames::new(&scene, &config, history);
        (0..100).for_each(|frame| drop(frames.pose(&scene, &moved(camera, step * frame as f32))));
        width(&frames.pose(&scene, &last))
    });
    println!("step {step}: line {line:.3} px, paper {paper:.3}, validated {validated:.3}");
    assert!(validated < line + 0.1, "the line widened");
    // Where discs overlap those of the last frame by fractions, each mean is over neighbours.
    assert!(step == Vec3::ZERO || paper > line + 0.5, "the published history has changed");
}

/// A newly visible pixel has no history: it equals OurBasic to the bit.
#[test]
fn disoccluded_pixels_equal_our_basic_to_the_bit() {
    let (scene, config) = (committed("mirror-room"), config(80, 45, 20_000));
    let camera = &scene.cameras[0];
    let turned = SceneCamera { right: -camera.right, forward: -camera.forward, ..camera.clone() };
    for history in [&PAPER, &VALIDATED] {
        let (mut none, mut other) =
            (Frames::new(&scene, &config, &NONE), Frames::new(&scene, &config, history));
        for _ in 0..4 {
            none.pose(&scene, camera);
            other.pose(&scene, camera);
        }
        let (fresh, blended) = (none.pose(&scene, &turned), other.pose(&scene, &turned));
        let samples: Vec<_> =
            other.session.read::<caustics_kernels::interface::history::Reprojected>("reprojected").unwrap();
        let mut unseen = 0;
        for (pixel, reprojected) in samples.iter().enumerate() {
            if reprojected.samples == 0.0 {
                unseen += 1;
                assert_eq!(fresh[pixel], blended[pixel], "{}", history.name);
            }
        }
        println!("{}: {unseen} of {} pixels unseen", history.name, samples.len());
        assert!(unseen > samples.len() / 2);
    }
}

mod long {
    use super::*;

    /// O8: blending 0.2 of a frame into 0.8 of the mean leaves 0.2 / 1.8 of the variance of a frame.
    #[test]
    #[ignore = "600 frames: ten seconds and more"]
    fn paper_history_keeps_a_ninth_of_the_variance() {
        let count = 600;
        let moments = papers_moments(24, count);
        let n = f64::from(count);
        let variance = |moments: &[(f64, f64)]| -> f64 {
            moments.iter().map(|(sum, squares)| squares / n - (sum / n).powi(2)).sum()
        };
        // The mean over time of the blended frames has the noise of nine frames. Its variance is 1/n (1 + 0.8) / (1 -
        // 0.8) times a blended frame's, and is missing above.
        let ratio = variance(&moments[1]) / variance(&moments[0]) / (1.0 - 9.0 / n);
        println!("variance of the paper's history: {ratio:.4} of a frame's, expected {:.4}", 0.2 / 1.8);
        assert!((ratio / (0.2 / 1.8) - 1.0).abs() < 0.05, "{ratio}");
    }

    #[test]
    #[ignore = "200 frames: ten seconds"]
    fn validated_history_widens_a_line_of_light_by_less_than_0_1_px_under_a_still_camera() {
        line_stays_narrow(Vec3::ZERO);
    }
}
