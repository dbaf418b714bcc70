//! Moving objects seen in mirrors: histories lower the error of caustics and of noisy path-traced light there.

use caustics::accumulation::Accumulation;
use caustics::render_config::{Paths, RenderConfig};
use caustics::rendered_image::RenderedImage;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::history::VALIDATED;
use caustics_kernels::interface::choice::{PathHistory, PixelFilter, Sampler};
use caustics_tests::moving::{Moving, moving_mirror};
use glam::Vec3;

const FPS: f64 = 24.0;
const WIDTH: u32 = 96;
const HEIGHT: u32 = 60;
/// Number of frames that are compared with the reference: the last ones.
const COMPARED: u32 = 4;
const FRAMES: u32 = 16;
/// Depth of a collection point that is seen in a mirror.
const MIRRORED: f32 = 2.0;

fn config(seed: u32) -> RenderConfig {
    RenderConfig {
        width: WIDTH,
        height: HEIGHT,
        light_paths: Paths::Count(WIDTH * HEIGHT / 2),
        seed,
        ..RenderConfig::default()
    }
}

fn with_histories(config: RenderConfig) -> RenderConfig {
    RenderConfig { history: &VALIDATED, path_history: PathHistory::Validated, ..config }
}

fn open(scene: &Scene, config: &RenderConfig) -> Session {
    let features = scene.features(config.specular_roughness);
    let cpu = RunnerChoice::Cpu { threads: 0 };
    Session::new(&cpu, scene, &scene.cameras[0], config, features).expect("a session opens")
}

/// The last frames of an animation.
fn animation(scene: &Scene, config: &RenderConfig) -> Vec<RenderedImage> {
    let mut scene = scene.clone();
    scene.pose(0.0).expect("a pose");
    let mut session = open(&scene, config);
    let frame = |frame: u32| {
        scene.pose(f64::from(frame) / FPS).expect("a pose");
        session.pose(&scene, &scene.cameras[0].clone()).expect("a pose");
        session.frame(frame).expect("a frame runs");
        session.image().expect("an image")
    };
    (0..FRAMES).map(frame).skip((FRAMES - COMPARED) as usize).collect()
}

/// A layer of an image.
type Layer = fn(&RenderedImage) -> &Vec<Vec3>;

/// Means of `samples` frames of each of the last poses, over whole pixels.
fn reference(scene: &Scene, samples: u32) -> Vec<RenderedImage> {
    let mut scene = scene.clone();
    let many = RenderConfig {
        light_paths: Paths::Count(4 * WIDTH * HEIGHT),
        pixel_filter: PixelFilter::Box,
        sampler: Sampler::Sobol,
        ..config(77)
    };
    let mean = |frame: u32| {
        scene.pose(f64::from(frame) / FPS).expect("a pose");
        let mut session = open(&scene, &many);
        let mut sum = Accumulation::default();
        for frame in 0..samples {
            session.frame(frame).expect("a frame runs");
            sum.add(&session.image().expect("an image"));
        }
        sum.mean()
    };
    (FRAMES - COMPARED..FRAMES).map(mean).collect()
}

/// Sum of squared differences of displayable values, where `seen` shows the mirror.
fn squares(
    images: &[RenderedImage],
    reference: &[RenderedImage],
    seen: &[RenderedImage],
    layer: Layer,
) -> f64 {
    let of_image = |((image, reference), seen): ((&RenderedImage, &RenderedImage), &RenderedImage)| -> f64 {
        let pixels = layer(image).iter().zip(layer(reference)).zip(&seen.depth);
        let mirrored = pixels.filter(|(_, depth)| **depth == MIRRORED);
        mirrored.map(|((a, b), _)| f64::from((a.min(Vec3::ONE) - b.min(Vec3::ONE)).length_squared())).sum()
    };
    images.iter().zip(reference).zip(seen).map(of_image).sum()
}

/// Squared error of caustics and of path-traced light in mirrors, with histories over without.
fn errors_over_none(scene: &Scene, samples: u32, seeds: u32) -> [f64; 2] {
    let reference = reference(scene, samples);
    let layers: [Layer; 2] = [|image| &image.caustics, |image| &image.path];
    let mut sums = [[0.0; 2]; 2];
    for seed in 0..seeds {
        let none = animation(scene, &config(seed));
        let kept = animation(scene, &with_histories(config(seed)));
        let mirrored = none[0].depth.iter().filter(|depth| **depth == MIRRORED).count();
        assert!(mirrored > none[0].depth.len() / 3, "{mirrored} pixels show the mirror");
        for (layer, sums) in layers.into_iter().zip(&mut sums) {
            sums[0] += squares(&none, &reference, &none, layer);
            sums[1] += squares(&kept, &reference, &none, layer);
        }
    }
    sums.map(|[none, kept]| kept / none)
}

/// Widths of the light over that in the file. Path-traced light has no noise under the first, and is noise under the
/// second.
const LIGHT_SCALES: [f64; 2] = [1.0, 16.0];

/// Largest squared error of path-traced light without noise, over that without a history. Edges of moving shadows blur
/// by a pixel or two. That costs about as much as the difference of pixel centres from whole pixels.
const MAX_WITHOUT_NOISE: f64 = 1.1;

/// Compares errors in scenes by their names.
fn cost_less_than_they_give(scenes: &[(&str, &dyn Fn(f64) -> Scene)], samples: u32, seeds: u32) {
    let mut wrong = Vec::new();
    for (name, scene) in scenes {
        for light_scale in LIGHT_SCALES {
            let [caustics, path] = errors_over_none(&scene(light_scale), samples, seeds);
            let line = format!(
                "{name}, light {light_scale}: squared error of caustics {caustics:.3}, of other light {path:.3}"
            );
            println!("{line}");
            let limit = if light_scale > 1.0 { 1.0 } else { MAX_WITHOUT_NOISE };
            if caustics >= 1.0 || path >= limit {
                wrong.push(line);
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn histories_lower_the_error_of_a_caster_that_moves_in_a_mirror() {
    let scene = |light_scale| Moving::MetalCaster.in_a_mirror(light_scale);
    cost_less_than_they_give(&[("MetalCaster", &scene)], 12, 1);
}

mod release {
    use super::*;

    #[test]
    #[ignore = "14 scenes: two minutes"]
    fn histories_lower_the_error_of_everything_that_moves_in_a_mirror() {
        for moving in Moving::ALL {
            cost_less_than_they_give(
                &[(&format!("{moving:?}"), &|light_scale| moving.in_a_mirror(light_scale))],
                128,
                3,
            );
        }
        cost_less_than_they_give(&[("Mirror", &moving_mirror)], 128, 3);
    }
}
