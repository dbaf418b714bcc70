//! The history of path-traced light: what it must equal, what it must notice, and what it must not lose.

use caustics::accumulation::Accumulation;
use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
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

/// The path-traced light of so many frames of an animation.
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

/// A corner of two colours beneath a square lamp: nothing specular.
fn corner() -> Scene {
    let mut b = Builder::default();
    let (floor, wall, light) = (b.material(lambert(0.6)), b.material(lambert(0.3)), b.material(emitter(5.0)));
    b.panel(floor, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    b.panel(wall, -1.5 * DVec3::Z, 3.0 * DVec3::X, 3.0 * DVec3::Y);
    b.panel(light, DVec3::new(0.3, 1.5, 0.0), 0.4 * DVec3::X, 0.4 * DVec3::Z);
    b.camera(DVec3::new(0.0, 1.0, 2.0), DVec3::ZERO, 0.6);
    b.build()
}

/// Known answer: where no choice is specular, frame n of a still view is the mean of the first n frames without a history.
#[test]
fn a_still_view_shows_the_mean_of_its_frames() {
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
            // Rays over the whole pixel meet two surfaces along an edge: there the history is a neighbour's.
            let min_share = if pixel_filter == PixelFilter::Box { 0.95 } else { 1.0 };
            assert!(
                seen > 3000 && f64::from(same) >= min_share * f64::from(seen),
                "frame {frame}: {same} of {seen}"
            );
        }
    }
}

/// In a scene at rest every path that is traced again finds the same bits, however the camera moves, and light counts long.
#[test]
fn what_rests_is_found_again_to_the_bit() {
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
        let max_frames: Vec<Vec2> = session.read("path_max_frames").expect("what blocks allow");
        assert!(max_frames.iter().all(|frames| *frames == Vec2::splat(MAX_FRAMES)));
        let light: Vec<PathHistoryLight> = session.read("path_light").expect("a history");
        let long = light.iter().filter(|light| light.direct_samples > 3.0).count();
        assert!(long > light.len() / 2, "{long} of {} pixels have a history", light.len());
    }
}

/// So does what blends: a path that is traced again meets the surfaces that it met.
#[test]
fn what_blends_is_found_again_to_the_bit() {
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

/// Light that goes out is noticed by the paths that found it, also where it is a part of all: less than a hundredth of what went
/// out is left in the third frame.
#[test]
fn a_lamp_that_goes_out_leaves_no_ghost() {
    let (scene, step, count) = (committed("light-off"), 12, 18);
    let [none, kept] = ALL.map(|path_history| animation(&scene, &config(path_history, 0), count));
    let mean = |layers: &[Vec<Vec3>]| layers.iter().map(|l| total(l)).sum::<f64>() / layers.len() as f64;
    let (on, off) = (mean(&none[..step]), mean(&none[step..]));
    assert!(off < 0.9 * on, "the lamp makes a part of the light: {off} of {on}");
    for k in 0..count as usize - step {
        // Frames since the step are the same paths without a history.
        let residual = (total(&kept[step + k]) - mean(&none[step..=step + k])) / (on - off);
        println!("frame {k} after the step: {residual:.4}");
        assert!(k < 2 || residual.abs() < 0.01, "frame {k}: {residual}");
    }
}

/// What the history keeps of the light of scenes where something moves, over that without, and its squared error to the reference. One
/// has a lamp whose light is noise; in the others direct light has next to none, and the edges of shadows that move may blur.
#[test]
fn what_moves_keeps_its_light() {
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

/// Sum of squared differences of what displays can show: brighter than that are lamps alone.
fn squares(layer: &[Vec3], reference: &[Vec3]) -> f64 {
    let pairs = layer.iter().zip(reference);
    pairs.map(|(a, b)| f64::from((a.min(Vec3::ONE) - b.min(Vec3::ONE)).length_squared())).sum()
}

/// In the frame behind a cut nothing is reused, to the bit, and one thread finds what two do.
#[test]
fn a_cut_equals_no_history() {
    let scene = committed("camera-cut");
    let [none, kept] = ALL.map(|path_history| animation(&scene, &config(path_history, 0), 14));
    assert!(none[0] == kept[0] && none[12] == kept[12]);
    assert!(none[11] != kept[11] && none[13] != kept[13], "there is a history elsewhere");
}

/// Behind dispersive glass a pixel sees another channel in every frame, which says nothing of the others: nothing is reused.
#[test]
fn behind_dispersive_glass_nothing_is_lent() {
    let mut b = Builder::default();
    let (floor, pane) = (b.material(lambert(0.6)), b.material(flint(1.5)));
    let light = b.material(Material { emission: Vec3::new(9.0, 3.0, 1.0), ..emitter(0.0) });
    // All of it behind the pane, which reflects nothing to the eye: a reflection keeps its channels.
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
    assert!(none == kept, "and it is what this frame found");
}

/// Light of a class that is chosen at random, as below a coat, is unbiased: direct light is reused without the probability of the
/// class, all other light with it.
#[test]
fn what_lies_below_a_coat_keeps_its_light() {
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
