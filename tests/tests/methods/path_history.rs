//! Path history: what it must equal, which changes it must notice, and what it must not lose.

use caustics::accumulation::Accumulation;
use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::denoiser;
use caustics_kernels::history::path::MAX_FRAMES;
use caustics_kernels::interface::choice::{PathHistory, PixelFilter, Sampler};
use caustics_kernels::interface::history::{HistoryPoint, PathHistoryLight, Retraced};
use caustics_kernels::interface::material::Material;
use caustics_tests::frames::sums;
use caustics_tests::moving::Moving;
use caustics_tests::scenes::{Builder, blended_room, coated, committed, emitter, flint, lambert};
use caustics_tests::statistics::Mean;
use glam::{DVec3, Vec2, Vec3};

const FPS: f64 = 24.0;
const ALL: [PathHistory; 2] = [PathHistory::None, PathHistory::Validated];

fn config(path_history: PathHistory, seed: u32) -> RenderConfig {
    RenderConfig {
        width: 96,
        height: 54,
        light_paths: Paths::Count(100),
        path_history,
        seed,
        ..RenderConfig::default()
    }
}

fn session(scene: &Scene, config: &RenderConfig, threads: usize) -> Session {
    let features = scene.features(config.specular_roughness);
    let choice = RunnerChoice::Cpu { threads };
    Session::new(&choice, scene, &scene.cameras[0], config, features).expect("a session opens")
}

/// Path-traced light of `count` frames of an animation.
fn animation(scene: &Scene, config: &RenderConfig, count: u32) -> Vec<Vec<Vec3>> {
    let mut scene = scene.clone();
    scene.pose(0.0).expect("a pose");
    let mut session = session(&scene, config, 0);
    let frame = |frame: u32| {
        scene.pose(f64::from(frame) / FPS).expect("a pose");
        session.pose(&scene, &scene.cameras[0].clone()).expect("a pose");
        session.frame(frame).expect("a frame runs");
        session.read("path_radiance").expect("path-traced light")
    };
    (0..count).map(frame).collect()
}

fn total(layer: &[Vec3]) -> f64 {
    sums(layer).iter().sum()
}

/// A corner of two colours beneath a square light: nothing specular.
fn corner() -> Scene {
    let mut b = Builder::default();
    let (floor, wall, light) = (b.material(lambert(0.6)), b.material(lambert(0.3)), b.material(emitter(5.0)));
    b.panel(floor, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    b.panel(wall, -1.5 * DVec3::Z, 3.0 * DVec3::X, 3.0 * DVec3::Y);
    b.panel(light, DVec3::new(0.3, 1.5, 0.0), 0.4 * DVec3::X, 0.4 * DVec3::Z);
    b.camera(DVec3::new(0.0, 1.0, 2.0), DVec3::ZERO, 0.6);
    b.build()
}

/// Known answer: without specular choices, frame n of a still view is the mean of the first n frames without a history.
#[test]
fn path_history_of_a_still_view_is_the_mean_of_its_frames() {
    let scene = corner();
    for pixel_filter in PixelFilter::ALL.iter().copied() {
        let [mut raw, mut kept] = ALL.map(|path_history| {
            session(&scene, &RenderConfig { pixel_filter, ..config(path_history, 3) }, 0)
        });
        let mut mean = Accumulation::default();
        for frame in 0..24 {
            for session in [&mut raw, &mut kept] {
                session.frame(frame).expect("a frame runs");
            }
            mean.add(&raw.image().expect("an image"));
            let (shown, mean) = (kept.image().expect("an image").path, mean.mean().path);
            let points: Vec<HistoryPoint> = kept.read("path_points").expect("points");
            let (mut same, mut seen) = (0_u32, 0_u32);
            for (pixel, point) in points.iter().enumerate().filter(|(_, point)| point.samples > 0.0) {
                seen += 1;
                // 24 additions of f32.
                let close = (shown[pixel] - mean[pixel]).length() <= 4e-6 * mean[pixel].length();
                same += u32::from(close && point.samples == frame as f32 + 1.0);
            }
            // Rays over the whole pixel meet two surfaces along an edge, where the history is a neighbour's.
            let min_share = if pixel_filter == PixelFilter::Box { 0.95 } else { 1.0 };
            assert!(
                seen > 3000 && f64::from(same) >= min_share * f64::from(seen),
                "frame {frame}: {same} of {seen}"
            );
        }
    }
}

/// In a scene at rest every retraced path finds the same bits under any motion of the camera, and light counts long.
#[test]
fn retraced_paths_of_a_still_scene_match_to_the_bit() {
    for sampler in [Sampler::Independent, Sampler::Sobol] {
        let config = RenderConfig { sampler, ..config(PathHistory::Validated, 1) };
        let mut scene = committed("animated-camera");
        let mut session = session(&scene, &config, 0);
        for frame in 0..6 {
            scene.pose(f64::from(frame) / FPS).expect("a pose");
            session.pose(&scene, &scene.cameras[0].clone()).expect("a pose");
            session.frame(frame).expect("a frame runs");
        }
        let retraced: Vec<Retraced> = session.read("path_retraced").expect("paths traced again");
        let lit = retraced.iter().filter(|path| path.before.x > 0.0).count();
        assert!(lit > retraced.len() / 2, "{lit} of {}", retraced.len());
        assert!(retraced.iter().all(|path| path.before == path.now));
        let max_frames: Vec<Vec2> = session.read("path_max_frames").expect("frames that blocks allow");
        assert!(max_frames.iter().all(|frames| *frames == Vec2::splat(MAX_FRAMES)));
        let light: Vec<PathHistoryLight> = session.read("path_light").expect("a history");
        let long = light.iter().filter(|light| light.direct_samples > 3.0).count();
        assert!(long > light.len() / 2, "{long} of {} pixels have a history", light.len());
    }
}

/// A retraced path through blended surfaces meets the surfaces that it met before.
#[test]
fn retraced_paths_through_blended_surfaces_match_to_the_bit() {
    let scene = blended_room().build();
    let mut session = session(&scene, &config(PathHistory::Validated, 1), 0);
    let mut camera = scene.cameras[0].clone();
    for frame in 0..4 {
        camera.position.x += 0.02;
        session.pose(&scene, &camera).expect("a pose");
        session.frame(frame).expect("a frame runs");
    }
    let retraced: Vec<Retraced> = session.read("path_retraced").expect("paths traced again");
    let lit = retraced.iter().filter(|path| path.before.x > 0.0).count();
    assert!(lit > retraced.len() / 4, "{lit} of {}", retraced.len());
    assert!(retraced.iter().all(|path| path.before == path.now));
}

/// Paths that found a light notice that it goes out, also where it is a part of all light. Less than a hundredth of the
/// lost light is left in the third frame.
#[test]
fn path_history_keeps_less_than_1_percent_of_a_light_that_went_out_3_frames_ago() {
    let (scene, step, count) = (committed("light-off"), 12, 18);
    let [none, kept] = ALL.map(|path_history| animation(&scene, &config(path_history, 0), count));
    let mean = |layers: &[Vec<Vec3>]| layers.iter().map(|l| total(l)).sum::<f64>() / layers.len() as f64;
    let (on, off) = (mean(&none[..step]), mean(&none[step..]));
    assert!(off < 0.9 * on, "the light is too weak: {off} of {on}");
    for k in 0..count as usize - step {
        // Without a history, frames since the step have the same paths.
        let residual = (total(&kept[step + k]) - mean(&none[step..=step + k])) / (on - off);
        println!("frame {k} after the step: {residual:.4}");
        assert!(k < 2 || residual.abs() < 0.01, "frame {k}: {residual}");
    }
}

/// Energy of moving scenes with the history over that without, and its squared error to the reference. One scene has a
/// light that is noise. In the others direct light has almost none, and edges of moving shadows may blur.
#[test]
fn path_history_keeps_the_energy_of_moving_scenes_to_1_percent() {
    let moving = |moving: Moving| (format!("{moving:?}"), moving.scene());
    let scenes = [
        (("animated-light".into(), committed("animated-light")), 0.85),
        (moving(Moving::Camera), 1.0),
        (moving(Moving::Light), 1.1),
        (moving(Moving::MetalCaster), 1.1),
        (moving(Moving::GlassCaster), 1.1),
        (moving(Moving::Receiver), 1.1),
    ];
    for ((name, scene), max_error) in scenes {
        let (frames, seeds) = (16, 4);
        let reference = reference(&scene, 128, frames);
        let (mut energies, mut errors) = (Vec::new(), [0.0; 2]);
        for seed in 0..seeds {
            let [none, kept] = ALL.map(|path_history| animation(&scene, &config(path_history, seed), frames));
            let energy = |frames: &[Vec<Vec3>]| frames.iter().map(|layer| total(layer)).sum::<f64>();
            energies.push(energy(&kept) / energy(&none));
            for (error, run) in errors.iter_mut().zip([&none, &kept]) {
                *error += squares(&run[frames as usize - 1], &reference);
            }
        }
        let (energy, error) = (Mean::from_samples(&energies), errors[1] / errors[0]);
        println!("{name}: energy {:.4} +- {:.4}, squared error {error:.3}", energy.value, energy.error);
        assert!((energy.value - 1.0).abs() < 0.01 && energy.error < 0.003, "{name}: {energy:?}");
        assert!(error < max_error, "{name}: squared error {error} of none");
    }
}

/// The light of the last frame, over whole pixels.
fn reference(scene: &Scene, samples: u32, frames: u32) -> Vec<Vec3> {
    let mut scene = scene.clone();
    scene.pose(f64::from(frames - 1) / FPS).expect("a pose");
    let config = RenderConfig {
        pixel_filter: PixelFilter::Box,
        sampler: Sampler::Sobol,
        ..config(PathHistory::None, 77)
    };
    let mut session = session(&scene, &config, 0);
    let mut sum = Accumulation::default();
    for frame in 0..samples {
        session.frame(frame).expect("a frame runs");
        sum.add(&session.image().expect("an image"));
    }
    sum.mean().path
}

/// Sum of squared differences of displayable values; only lights are brighter.
fn squares(layer: &[Vec3], reference: &[Vec3]) -> f64 {
    let pairs = layer.iter().zip(reference);
    pairs.map(|(a, b)| f64::from((a.min(Vec3::ONE) - b.min(Vec3::ONE)).length_squared())).sum()
}

/// Below a ring that moves, light changes in every frame, so that no mean of frames shows its noise. Two pixels inside of the umbra
/// the denoiser leaves 0.5 % of the light beside it. It would leave 1.1 % if it knew the noise of long means alone.
#[test]
fn the_denoiser_leaves_the_umbra_of_a_moving_caster_dark() {
    let scene = committed("moving-caster");
    let last = |denoiser| {
        let base = config(PathHistory::Validated, 0);
        let config = RenderConfig { width: 160, height: 90, sampler: Sampler::Sobol, denoiser, ..base };
        animation(&scene, &config, 20).pop().expect("frames")
    };
    let (raw, smooth) = (last(&denoiser::NONE), last(&denoiser::ATROUS));
    let is_dark = |x: usize, y: usize| raw[y * 160 + x] == Vec3::ZERO;
    let is_inside = |x: usize, y: usize| (y - 2..=y + 2).all(|y| (x - 2..=x + 2).all(|x| is_dark(x, y)));
    let (mut count, mut light) = (0_u32, 0.0);
    // Beside the floor, which fills the rows below, the background is black, too.
    for y in 12..88 {
        for x in (2..158).filter(|&x| is_inside(x, y)) {
            count += 1;
            light += f64::from(smooth[y * 160 + x].element_sum());
        }
    }
    let lit = raw.iter().filter(|light| **light != Vec3::ZERO).count() as f64;
    let share = light / f64::from(count) / (total(&raw) / lit);
    assert!(count > 400 && share < 0.008, "{count} pixels, {share}");
}

/// In the frame after a cut nothing is reused, to the bit, and one thread gives the result of two.
#[test]
fn path_history_is_unused_in_the_frame_after_a_cut() {
    let scene = committed("camera-cut");
    let [none, kept] = ALL.map(|path_history| animation(&scene, &config(path_history, 0), 14));
    assert!(none[0] == kept[0] && none[12] == kept[12]);
    assert!(none[11] != kept[11] && none[13] != kept[13], "other frames have no history");
}

/// Behind dispersive glass a pixel sees another channel in every frame, which tells nothing of the others: nothing is
/// reused.
#[test]
fn path_history_reuses_nothing_behind_dispersive_glass() {
    let mut b = Builder::default();
    let (floor, pane) = (b.material(lambert(0.6)), b.material(flint(1.5)));
    let light = b.material(Material { emission: Vec3::new(9.0, 3.0, 1.0), ..emitter(0.0) });
    // All of it lies behind the pane, which reflects nothing to the camera: a reflection keeps its channels.
    b.panel(floor, -1.9 * DVec3::Z, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    b.panel(light, DVec3::new(0.3, 1.5, 0.0), 0.4 * DVec3::X, 0.4 * DVec3::Z);
    b.block(pane, DVec3::new(-1.5, 0.05, 1.2), DVec3::new(1.5, 1.4, 1.4), false);
    b.camera(DVec3::new(0.0, 1.0, 2.0), DVec3::ZERO, 0.6);
    let scene = b.build();
    let [none, kept] = ALL.map(|path_history| {
        let mut session = session(&scene, &config(path_history, 0), 0);
        (0..6).for_each(|frame| drop(session.frame(frame).expect("a frame runs")));
        session.image().expect("an image").path
    });
    let lit = |channel| none.iter().filter(|seen| seen[channel] > 0.0).count();
    assert!([0, 1, 2].map(lit).iter().all(|lit| *lit > none.len() / 6), "each pixel has a channel");
    assert!(none == kept, "light of other frames is reused");
}

/// Light of a class that is chosen at random, as below a coat, is unbiased. Direct light is reused without the
/// probability of the class, all other light with it.
#[test]
fn path_history_keeps_the_energy_below_a_coat() {
    let mut b = Builder::default();
    let floor = b.material(coated(0.6, 0.1));
    let (wall, light) = (b.material(lambert(0.5)), b.material(emitter(5.0)));
    b.panel(floor, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    b.panel(wall, -1.5 * DVec3::Z, 3.0 * DVec3::X, 3.0 * DVec3::Y);
    b.panel(light, DVec3::new(0.3, 1.5, 0.0), 0.4 * DVec3::X, 0.4 * DVec3::Z);
    // Seen at a slant: the coat is chosen often.
    b.camera(DVec3::new(0.0, 0.3, 2.0), DVec3::ZERO, 0.6);
    let scene = b.build();
    let mean = |path_history| {
        let run = |seed| {
            let mut session = session(&scene, &config(path_history, seed), 0);
            (0..6).for_each(|frame| drop(session.frame(frame).expect("a frame runs")));
            total(&session.image().expect("an image").path)
        };
        Mean::from_samples(&(0..48).map(run).collect::<Vec<f64>>())
    };
    let [none, kept] = ALL.map(mean);
    println!("{none:?} {kept:?}");
    assert!(none.agrees(&kept, 3.0) && kept.error < 0.002 * kept.value, "{none:?} {kept:?}");
}
