//! Clamping of rare bright camera samples by the pixels around: the light that it takes, its gain and its cost.

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::interface::choice::Fireflies;
use caustics_kernels::method::Method;
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::method::progressive::PROGRESSIVE;
use caustics_kernels::pass::bound::BOUND;
use caustics_kernels::pass::bound::MAX_OVER_MEAN;
use caustics_tests::frames::around;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};

const CPU: RunnerChoice = RunnerChoice::Cpu { threads: 0 };
const SIZE: (usize, usize) = (160, 90);

fn config(fireflies: Fireflies, seed: u32) -> RenderConfig {
    let (width, height) = (SIZE.0 as u32, SIZE.1 as u32);
    RenderConfig {
        width,
        height,
        light_paths: Paths::Count(1000),
        fireflies,
        seed,
        ..RenderConfig::default()
    }
}

fn open(scene: &Scene, config: &RenderConfig, method: &'static Method) -> Session {
    let features = scene.features(config.specular_roughness);
    Session::new(&CPU, scene, &scene.cameras[0], &RenderConfig { method, ..config.clone() }, features)
        .expect("a session opens")
}

/// The path layer of one frame.
fn layer(scene: &Scene, fireflies: Fireflies, seed: u32) -> Vec<Vec3> {
    let mut session = open(scene, &config(fireflies, seed), &BASIC);
    session.frame(0).expect("a frame runs");
    session.image().expect("an image").path
}

/// A pixel loses light above eight times the mean of the 24 pixels around. Only light behind a non-delta bounce is
/// compared and lost, and no other pixel loses any.
#[test]
fn samples_are_clamped_to_8_times_the_mean_of_24_neighbours() {
    let scene = committed("mirror-room");
    let kept = layer(&scene, Fireflies::Kept, 1);
    let mut session = open(&scene, &config(Fireflies::Bounded, 1), &BASIC);
    session.frame(0).expect("a frame runs");
    let bounded = session.image().expect("an image").path;
    let delta_prefix: Vec<Vec3> = session.read("delta_prefix_radiance").expect("radiance of delta prefixes");
    let mean = |value: Vec3| f64::from(value.element_sum()) / 3.0;
    let non_delta = |pixel: usize| mean(kept[pixel] - delta_prefix[pixel]);
    let mut taken = 0;
    for pixel in 0..kept.len() {
        let others = around(pixel, 2, SIZE).into_iter().filter(|other| *other != pixel);
        let around: Vec<f64> = others.map(non_delta).collect();
        let limit = f64::from(MAX_OVER_MEAN) * around.iter().sum::<f64>() / around.len() as f64;
        let expected = mean(delta_prefix[pixel]) + non_delta(pixel).min(limit.max(0.0));
        let found = mean(bounded[pixel]);
        assert!((found - expected).abs() <= 1.0e-3 * expected + 1.0e-6, "{pixel}: {found}, {expected}");
        if bounded[pixel] == kept[pixel] {
            continue;
        }
        taken += 1;
        // Its colour stays.
        let (was, is) = (kept[pixel] - delta_prefix[pixel], bounded[pixel] - delta_prefix[pixel]);
        assert!((was.normalize() - is.normalize()).length() < 1.0e-2, "{pixel}: {was}, {is}");
    }
    println!("{taken} of {} pixels", kept.len());
    assert!((50..kept.len() / 20).contains(&taken));
}

/// Where samples are rare and bright, clamping takes much of the variance and little of the light.
#[test]
fn clamping_lowers_the_variance_and_loses_at_most_2_percent_of_the_light() {
    for (name, max_variance, max_light) in
        [("mirror-room", 0.7, 0.02), ("glossy-room", 0.7, 0.02), ("cornell-box", 1.0, 0.01)]
    {
        let scene = committed(name);
        let [kept, bounded] = [Fireflies::Kept, Fireflies::Bounded].map(|setting| {
            let frames: Vec<Vec<Vec3>> = (0..24).map(|seed| layer(&scene, setting, seed)).collect();
            let value = |frame: &[Vec3], pixel: usize| f64::from(frame[pixel].element_sum());
            let mean = |pixel| frames.iter().map(|frame| value(frame, pixel)).sum::<f64>() / 24.0;
            let means: Vec<f64> = (0..frames[0].len()).map(mean).collect();
            let square = |pixel: usize| {
                frames.iter().map(|frame| (value(frame, pixel) - means[pixel]).powi(2)).sum::<f64>()
            };
            (means.iter().sum::<f64>(), (0..means.len()).map(square).sum::<f64>())
        });
        let (light, variance) = (1.0 - bounded.0 / kept.0, bounded.1 / kept.1);
        println!("{name}: {:.2} % of the light is lost, {variance:.3} of the variance stays", 100.0 * light);
        assert!(variance < max_variance && (0.0..max_light).contains(&light), "{name}");
    }
}

/// A light as small as a pixel, seen directly or in a smooth mirror, is no firefly. Progressive renders have no bounds.
#[test]
fn directly_seen_lights_and_progressive_renders_are_not_clamped() {
    let mut b = Builder::default();
    let (floor, mirror, light) =
        (b.material(lambert(0.5)), b.material(metal(0.9, 0.0)), b.material(emitter(500.0)));
    b.panel(floor, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    b.panel(mirror, DVec3::new(0.0, 1.0, -2.0), DVec3::X, DVec3::Y);
    b.panel(light, DVec3::new(0.3, 0.8, 0.0), 0.012 * DVec3::X, 0.012 * DVec3::Y);
    // It shines into the mirror alone.
    b.panel(light, DVec3::new(-0.6, 0.8, 0.0), -0.03 * DVec3::X, 0.03 * DVec3::Y);
    b.camera(DVec3::new(0.0, 1.0, 2.0), DVec3::new(0.0, 0.7, 0.0), 0.8);
    let scene = b.build();
    let [kept, bounded] = [Fireflies::Kept, Fireflies::Bounded].map(|setting| layer(&scene, setting, 1));
    let bright: Vec<usize> = (0..kept.len()).filter(|pixel| kept[*pixel].x > 400.0).collect();
    let columns = || bright.iter().map(|pixel| pixel % SIZE.0);
    // The bright pixels lie in two areas.
    assert!(columns().max() > columns().min().map(|first| first + 5), "{bright:?}");
    assert!(bright.iter().all(|&pixel| bounded[pixel] == kept[pixel]));
    let config = config(Fireflies::Bounded, 1);
    for (method, bounds) in [(&BASIC, true), (&PROGRESSIVE, false)] {
        let parts = RenderConfig { method, ..config.clone() }.parts();
        assert_eq!(parts.stages.has(&BOUND), bounds, "{}", method.name);
    }
}
