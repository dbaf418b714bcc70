//! Light sampling of camera paths: all samplers have the same mean; their noise is compared.

use std::f64::consts::PI;

use caustics::render_config::RenderConfig;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::gather::variant::PHOTONS_GRID;
use caustics_kernels::interface::choice::{LightSampler, PixelFilter};
use caustics_kernels::method::path::PATH;
use caustics_tests::blocks::Blocks;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};

const CPU: RunnerChoice = RunnerChoice::Cpu { threads: 0 };

fn config(light_sampler: LightSampler, seed: u32) -> RenderConfig {
    RenderConfig { width: 64, height: 48, light_sampler, seed, ..RenderConfig::default() }
}

/// Blocks of frames of path tracing by a light sampler.
fn blocks(scene: &Scene, light_sampler: LightSampler, frames: u32) -> Blocks {
    let seed = light_sampler as u32;
    let config = RenderConfig { pixel_filter: PixelFilter::Box, ..config(light_sampler, seed) };
    Blocks::render(&CPU, scene, &config, &PATH, &PHOTONS_GRID, frames)
}

/// Few lights and many, of every type, seen by lobes of every width: equal light, block by block.
#[test]
fn every_light_sampler_finds_the_same_light() {
    // Two emitters of two triangles each; with a spot light more than four lights; with all types.
    let mut spot = room_of_lights(2);
    spot.spot(DVec3::new(0.0, 0.9, 0.0), -DVec3::Y, 0.2, 0.5, 2.0);
    let mut all = room_of_lights(7);
    all.light(DVec3::new(-0.5, 0.7, 0.5), 0.3);
    all.spot(DVec3::new(0.0, 0.9, 0.0), -DVec3::Y, 0.2, 0.5, 2.0);
    // Parallel light, under an open sky.
    let mut sky = open_air();
    for id in 0..4 {
        sky.light(DVec3::new(f64::from(id) - 1.5, 1.0, 0.5), 0.2);
    }
    for (name, scene, frames) in [
        ("few", room_of_lights(2).build(), 120),
        ("five", spot.build(), 120),
        ("many", all.build(), 400),
        ("sky", sky.build(), 50),
    ] {
        let power = blocks(&scene, LightSampler::Power, frames);
        for setting in [LightSampler::Resampled, LightSampler::Uniform, LightSampler::Bvh] {
            let rendered = blocks(&scene, setting, frames);
            let scores = rendered.scores(&power);
            println!("{name}, {setting:?}: {scores:?}");
            assert!(scores.ratio_error < 0.015, "the test is too noisy");
            assert_eq!(rendered.failure(&power), None, "{name}, {setting:?}");
        }
    }
}

/// Two lights of different colours over a floor: without occluders nothing is left to sample.
#[test]
fn resampled_sampling_of_two_visible_point_lights_has_no_noise() {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.6));
    b.panel(floor, DVec3::ZERO, 9.0 * DVec3::Z, 9.0 * DVec3::X);
    let lights = [
        (DVec3::new(-0.6, 1.0, 0.2), Vec3::new(4.0, 1.0, 0.5)),
        (DVec3::new(0.7, 1.4, 0.0), Vec3::splat(2.0)),
    ];
    for (position, intensity) in lights {
        b.colored_light(position, intensity);
    }
    b.camera(DVec3::new(0.0, 1.0, 2.0), DVec3::ZERO, 0.6);
    let scene = b.build();
    for (setting, is_clean) in [(LightSampler::Resampled, true), (LightSampler::Power, false)] {
        let config = config(setting, 1);
        let features = scene.features(config.specular_roughness);
        let camera = &scene.cameras[0];
        let mut session =
            Session::new(&CPU, &scene, camera, &RenderConfig { method: &PATH, ..config.clone() }, features)
                .expect("a session");
        let mut worst = 0.0f64;
        for frame in 0..2 {
            session.frame(frame).expect("a frame runs");
            let image = session.image().expect("an image");
            let params = session.params(frame);
            for (pixel, found) in image.path.iter().enumerate() {
                let (column, row) = ((pixel % 64) as f32 + 0.5, (pixel / 64) as f32 + 0.5);
                let direction = params.camera.direction_of(column, row, &params).as_dvec3();
                let at =
                    camera.position.as_dvec3() - direction * (f64::from(camera.position.y) / direction.y);
                let light = |(position, intensity): (DVec3, Vec3)| {
                    let along = position - at;
                    intensity.as_dvec3() * (along.y / along.length().powi(3))
                };
                let expected = (light(lights[0]) + light(lights[1])) * 0.6 / PI;
                worst = worst.max(((found.as_dvec3() - expected) / expected).abs().max_element());
            }
        }
        println!("{setting:?}: {worst:.1e}");
        assert_eq!(worst < 1.0e-4, is_clean, "{setting:?}: {worst}");
    }
}

/// A ceiling of a thousand emitters of very different powers. Candidates leave less than half of the variance of one light by power,
/// and candidates from the light BVH less than a fifth of that. One light at random leaves more.
#[test]
fn candidates_of_1000_emitters_halve_the_variance_and_those_of_the_light_bvh_leave_a_fifth() {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.6));
    let lights = [1.0, 2.0, 3.0, 12.0].map(|radiance| b.material(emitter(radiance)));
    b.panel(floor, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    for id in 0..500 {
        let light = lights[id * 7 % 4];
        let id = id as u32;
        let (x, z) = (f64::from(id % 25) * 0.1 - 1.2, f64::from(id / 25) * 0.1 - 0.95);
        b.panel(light, DVec3::new(x, 0.4, z), 0.03 * DVec3::X, 0.03 * DVec3::Z);
    }
    b.camera(DVec3::new(0.0, 0.35, 1.0), DVec3::ZERO, 0.6);
    let scene = b.build();
    let [bvh, resampled, power, uniform] =
        [LightSampler::Bvh, LightSampler::Resampled, LightSampler::Power, LightSampler::Uniform]
            .map(|setting| blocks(&scene, setting, 800));
    let variance = |rendered: &Blocks| (0..48).map(|block| rendered.block(block).error.powi(2)).sum::<f64>();
    for rendered in [&bvh, &resampled, &uniform] {
        let scores = rendered.scores(&power);
        println!("{scores:?}, variance {:.3} of that by power", variance(rendered) / variance(&power));
        assert_eq!(rendered.failure(&power), None);
    }
    assert!(variance(&bvh) < 0.2 * variance(&resampled));
    assert!(variance(&resampled) < 0.5 * variance(&power));
    assert!(variance(&power) < variance(&uniform));
}
