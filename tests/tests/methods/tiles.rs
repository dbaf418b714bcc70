//! A render tile by tile equals the whole image: to the bit where neither frames nor pixels depend on each other, and
//! in expectation elsewhere.

use caustics::render_config::{Paths, Radius, RenderConfig};
use caustics::rendered_image::RenderedImage;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session, SessionError};
use caustics_kernels::emission::{AIMED, GUIDED, POWER};
use caustics_kernels::interface::choice::{Fireflies, PathHistory, PixelFilter, Sampler};
use caustics_kernels::interface::counters::Counter;
use caustics_kernels::interface::features::Features;
use caustics_kernels::method::Method;
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::method::kim2019::KIM2019;
use caustics_kernels::method::path::PATH;
use caustics_kernels::method::progressive::PROGRESSIVE;
use caustics_kernels::method::yang2021::YANG2021;
use caustics_tests::parity::load;
use caustics_tests::statistics::Mean;
use glam::Vec3;

/// Images of 45 rows: five tiles of nine, or four, of twelve and of nine at the end.
fn config(tiles: u32) -> RenderConfig {
    let light_paths = Paths::Count(20_000);
    RenderConfig {
        width: 80,
        height: 45,
        light_paths,
        radius: Radius::Px(3.0),
        tiles: Some(tiles),
        ..RenderConfig::default()
    }
}

fn open(scene: &Scene, config: &RenderConfig, method: &'static Method) -> Session {
    let features = scene.features(config.specular_roughness) | Features::LEDGER;
    let choice = RunnerChoice::Cpu { threads: 0 };
    Session::new(&choice, scene, &scene.cameras[0], &RenderConfig { method, ..config.clone() }, features)
        .expect("a session opens")
}

fn frame(session: &mut Session, index: u32) -> RenderedImage {
    session.frame(index).expect("a frame runs");
    session.image().expect("an image")
}

#[test]
fn tiled_image_equals_the_whole_image_to_the_bit() {
    let scene = load("mirror-room");
    for (method, sampler) in
        [(&BASIC, Sampler::Blue), (&PROGRESSIVE, Sampler::Sobol), (&PATH, Sampler::Independent)]
    {
        let emission = if method.gathers { &AIMED } else { &POWER };
        let with_tiles = |tiles| RenderConfig {
            emission,
            sampler,
            pixel_filter: PixelFilter::Box,
            auxiliary: true,
            ..config(tiles)
        };
        let mut whole = open(&scene, &with_tiles(1), method);
        let images = [0, 1].map(|index| frame(&mut whole, index));
        assert!(method.name == "path" || images[0].caustics.iter().any(|light| *light != Vec3::ZERO));
        for tiles in [4, 5] {
            let mut tiled = open(&scene, &with_tiles(tiles), method);
            assert_eq!(tiled.tiles(), tiles);
            assert_eq!([0, 1].map(|index| frame(&mut tiled, index)), images, "{} {tiles}", method.name);
            assert_eq!(tiled.display(&images[1]).unwrap(), whole.display(&images[1]).unwrap());

            // Each pixel belongs to one tile, each light path to all; their flux counts once.
            let [a, b] = [&mut whole, &mut tiled].map(|session| session.counters().unwrap());
            assert_eq!(a.get(Counter::CameraRays), b.get(Counter::CameraRays));
            assert_eq!(u64::from(tiles) * a.get(Counter::LightPaths), b.get(Counter::LightPaths));
            let [a, b] = [&mut whole, &mut tiled].map(|session| session.energy().unwrap().emitted);
            assert!((a - b).abs() <= 1e-9 * a, "{a} {b}");
        }
    }
}

/// Settings with which frames learn from those before them, and are reused by those after.
fn learning(tiles: u32) -> RenderConfig {
    RenderConfig {
        light_paths: Paths::Auto,
        radius: Radius::Auto,
        emission: &GUIDED,
        path_history: PathHistory::Validated,
        fireflies: Fireflies::Bounded,
        ..config(tiles)
    }
}

#[test]
fn tiles_keep_states_of_their_own_and_continue_from_restored_ones() {
    let scene = load("mirror-room");
    let mut session = open(&scene, &learning(4), &BASIC);
    let first = [0, 1].map(|index| frame(&mut session, index));
    let state = session.state().unwrap().into_iter().map(|(name, bytes)| (name.to_string(), bytes));
    let state: Vec<_> = state.collect();
    let later = [2, 3].map(|index| frame(&mut session, index));

    let mut resumed = open(&scene, &learning(4), &BASIC);
    resumed.restore(1, &state).unwrap();
    assert_eq!([2, 3].map(|index| frame(&mut resumed, index)), later);
    // Without the learnt state these frames differ.
    let mut fresh = open(&scene, &learning(4), &BASIC);
    assert_ne!(frame(&mut fresh, 2), later[0]);
    session.restart().unwrap();
    assert_eq!([0, 1].map(|index| frame(&mut session, index)), first);

    // The state of another number of tiles does not fit this session.
    let of_others = open(&scene, &learning(3), &BASIC).restore(1, &state);
    assert!(matches!(of_others, Err(SessionError::State { .. })));
}

/// Mean light over all pixels of the path layer and of the caustics.
fn light(image: &RenderedImage) -> [f64; 2] {
    let mean = |light: &[Vec3]| {
        light.iter().map(|light| f64::from(light.element_sum())).sum::<f64>() / light.len() as f64
    };
    [mean(&image.path), mean(&image.caustics)]
}

#[test]
fn tiles_with_adaptive_emission_keep_the_mean() {
    let scene = load("cornell-box");
    for method in [&BASIC, &YANG2021] {
        let [whole, tiled] = [1, 4].map(|tiles| {
            let emission = if method.name == "basic" { &GUIDED } else { &POWER };
            let config =
                RenderConfig { seed: tiles, emission, light_paths: Paths::Count(30_000), ..config(tiles) };
            let mut session = open(&scene, &config, method);
            let frames: Vec<[f64; 2]> = (0..12).map(|index| light(&frame(&mut session, index))).collect();
            [0, 1].map(|part| Mean::from_samples(&frames.iter().map(|light| light[part]).collect::<Vec<_>>()))
        });
        for (whole, tiled) in whole.iter().zip(&tiled) {
            assert!(whole.agrees(tiled, 4.0), "{}: {whole:?} {tiled:?}", method.name);
            assert!(tiled.error < 0.06 * tiled.value, "{}: the test is too noisy: {tiled:?}", method.name);
        }
    }
}

/// At the edge of a tile a pixel has fewer neighbours to search.
#[test]
fn splatted_light_of_tiles_is_within_1_percent_of_the_whole_image() {
    let scene = load("cornell-box");
    let [whole, tiled] = [1, 4].map(|tiles| light(&frame(&mut open(&scene, &config(tiles), &KIM2019), 0)));
    assert!(whole[1] > 0.0 && whole[0] == tiled[0], "{whole:?} {tiled:?}");
    assert!((whole[1] - tiled[1]).abs() < 0.01 * whole[1], "{whole:?} {tiled:?}");
}

#[test]
fn inspection_of_a_tiled_frame_is_refused() {
    let scene = load("mirror-room");
    let mut session = open(&scene, &config(2), &BASIC);
    session.frame(0).unwrap();
    assert!(matches!(session.inspect(&scene, 3, 3, 1), Err(SessionError::Tiles)));
}
