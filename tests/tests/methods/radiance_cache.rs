//! The radiance cache: the means that its cells hold, its gain, and what it leaves alone.

use std::collections::BTreeMap;

use caustics::render_config::RenderConfig;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::interface::NONE;
use caustics_kernels::interface::choice::{IndirectEnd, IndirectShare};
use caustics_kernels::interface::counters::Counter;
use caustics_kernels::interface::packed::from_rgbe;
use caustics_kernels::interface::radiance_cache::{CacheCell, CacheKey, CacheSample};
use caustics_tests::scenes::committed;
use caustics_tests::statistics::Mean;
use glam::{DVec3, Vec3};

use crate::share::{self, CPU, open, room_with_a_mirror, rooms_beside_a_thin_wall};

const ENDS: [IndirectEnd; 2] = [IndirectEnd::Path, IndirectEnd::Cache];

/// In smaller images no surface of the test room is four cells from another.
fn config(indirect_end: IndirectEnd, seed: u32) -> RenderConfig {
    let config = share::config(IndirectShare::None, seed);
    RenderConfig { indirect_end: Some(indirect_end), width: 160, height: 90, ..config }
}

/// Sum of the path layer over frames.
fn path_layer(session: &mut Session, frames: std::ops::Range<u32>) -> Vec<Vec3> {
    let mut sum: Vec<Vec3> = Vec::new();
    for frame in frames {
        session.frame(frame).expect("a frame runs");
        let path = session.image().expect("an image").path;
        sum.resize(path.len(), Vec3::ZERO);
        sum.iter_mut().zip(path).for_each(|(sum, light)| *sum += light);
    }
    sum
}

fn words(key: CacheKey) -> [u32; 3] {
    [key.xy, key.z_edge_side_depth, key.material]
}

/// After three frames each cell holds the samples of its own key, and of no other. Most keys have a cell.
#[test]
fn cells_hold_the_sums_of_the_samples_with_their_key() {
    let mut session = open(&CPU, &room_with_a_mirror(), &config(IndirectEnd::Cache, 3));
    let mut sums: BTreeMap<[u32; 3], ([DVec3; 3], f64)> = BTreeMap::new();
    let mut firsts = BTreeMap::new();
    let mut given = Vec::new();
    for frame in 0..3 {
        session.frame(frame).expect("a frame runs");
        let samples: Vec<CacheSample> = session.read("cache_samples").expect("samples");
        let samples: Vec<CacheSample> =
            samples.into_iter().filter(|sample| sample.light[0] != NONE).collect();
        given.push(samples.len());
        let cells: Vec<CacheCell> = session.read("cache_cells").expect("cells");
        for cell in cells.iter().filter(|cell| cell.count > 0.0) {
            firsts.entry(words(cell.key)).or_insert(frame);
        }
        // A key whose cell is another's gives nothing, until the cell is free.
        for sample in samples.iter().filter(|sample| firsts.contains_key(&words(sample.key))) {
            let (light, count) = sums.entry(words(sample.key)).or_default();
            for (sum, light) in light.iter_mut().zip(sample.light) {
                *sum += from_rgbe(light).as_dvec3();
            }
            *count += 1.0;
        }
    }
    let cells: Vec<CacheCell> = session.read("cache_cells").expect("cells");
    let mut held = 0.0;
    for cell in cells.iter().filter(|cell| cell.count > 0.0) {
        let (light, count) = &sums[&words(cell.key)];
        assert_eq!(f64::from(cell.count), *count);
        held += count;
        for (found, expected) in cell.light.iter().zip(light) {
            let error = (found.as_dvec3() - *expected).abs().max_element();
            assert!(error <= 1e-5 * expected.max_element(), "{found} instead of {expected}");
        }
    }
    let all: usize = given.iter().sum();
    println!("samples by frame {given:?}, of which cells hold {held}");
    assert!(given[0] > 1000, "every path with a long second segment gives a sample at first: {given:?}");
    assert!(given[2] < given[0] / 2, "most paths of later frames end in a cell: {given:?}");
    assert!(held > 0.75 * all as f64, "{held} of {all}");
}

/// Directly and in the mirror, light has as many bounces as without the cache, also where points share it. One bounce more would be
/// noticed.
#[test]
fn cached_light_has_the_bounces_of_whole_paths() {
    let scene = room_with_a_mirror();
    let halves = |end, share, max_bounces| {
        let means = (0..12).map(|seed| {
            let config = RenderConfig { max_bounces, indirect_share: Some(share), ..config(end, seed) };
            let mut session = open(&CPU, &scene, &config);
            let layer = path_layer(&mut session, 0..6);
            [0..80, 80..160].map(|columns: std::ops::Range<usize>| {
                let own = layer.iter().enumerate().filter(|(i, _)| columns.contains(&(i % 160)));
                own.map(|(_, light)| f64::from(light.y)).sum::<f64>() / 43_200.0
            })
        });
        let means: Vec<[f64; 2]> = means.collect();
        [0, 1].map(|half| Mean::from_samples(&means.iter().map(|mean| mean[half]).collect::<Vec<_>>()))
    };
    for max_bounces in [2, 3, 5, 9] {
        let paths = halves(IndirectEnd::Path, IndirectShare::None, max_bounces);
        let more = halves(IndirectEnd::Path, IndirectShare::None, max_bounces + 1);
        for share in [IndirectShare::None, IndirectShare::Points] {
            let cached = halves(IndirectEnd::Cache, share, max_bounces);
            for half in [0, 1] {
                let (paths, cached, more) = (paths[half], cached[half], more[half]);
                println!("{max_bounces}, {share:?}, half {half}: {paths:?} {cached:?}");
                assert!(paths.agrees(&cached, 4.0), "{max_bounces}: {} sigma", paths.sigmas(&cached));
                let sigmas = more.sigmas(&cached);
                assert!(max_bounces == 9 || sigmas > 6.0, "{max_bounces} {sigmas}");
            }
        }
    }
}

/// From the second frame on, paths trace far fewer rays. Caustics keep their bits.
#[test]
fn the_cache_saves_rays_and_leaves_caustics_alone() {
    for (name, most) in [("glossy-room", 0.85), ("mirror-room", 0.85)] {
        let scene = committed(name);
        let mut sessions =
            ENDS.map(|end| open(&CPU, &scene, &RenderConfig { width: 320, height: 180, ..config(end, 1) }));
        for frame in 0..6 {
            let [paths, cached] = sessions.each_mut().map(|session| {
                session.frame(frame).expect("a frame runs");
                let counters = session.counters().expect("counters");
                let rays = counters.get(Counter::CameraRays) + counters.get(Counter::ShadowRays);
                (session.image().expect("an image").caustics, rays as f64)
            });
            assert!(paths.0 == cached.0, "{name}, frame {frame}: caustics differ");
            let share = cached.1 / paths.1;
            println!("{name}, frame {frame}: {share:.3} of the rays");
            assert!(frame != 0 || share == 1.0, "{name}: {share}");
            assert!(frame < 4 || share < most, "{name}, {frame}: {share}");
        }
    }
}

/// Half of a room is dark behind a wall without thickness, on the same floor and before the same back wall. The dark half takes less
/// than a thousandth of the light of the other one.
#[test]
fn little_light_leaks_through_a_thin_wall() {
    let scene = rooms_beside_a_thin_wall(0.05);
    let [paths, cached] = ENDS.map(|end| path_layer(&mut open(&CPU, &scene, &config(end, 1)), 0..16));
    let sum = |layer: &[Vec3], side: bool| -> f64 {
        let of_side = (0..layer.len()).filter(|pixel| (pixel % 160 >= 84) == side);
        of_side.map(|pixel| f64::from(layer[pixel].element_sum())).sum()
    };
    assert_eq!(sum(&paths, true), 0.0);
    let leak = sum(&cached, true) / sum(&cached, false);
    println!("{leak:.1e}");
    assert!(leak < 1e-3, "{leak}");
}

/// Frames after a restart, and after the state was moved to another session, have the bits of those before.
#[test]
fn cached_frames_repeat_to_the_bit() {
    let scene = committed("mirror-room");
    let choices = [1, 4].map(|threads| RunnerChoice::Cpu { threads });
    let [mut one, mut many] =
        choices.each_ref().map(|choice| open(choice, &scene, &config(IndirectEnd::Cache, 5)));
    let start = path_layer(&mut one, 0..3);
    assert!(start == path_layer(&mut many, 0..3));
    let state = one.state().expect("a state");
    let state: Vec<(String, Vec<u8>)> =
        state.into_iter().map(|(name, bytes)| (name.to_string(), bytes)).collect();
    let next = path_layer(&mut one, 3..5);
    let mut resumed = open(&CPU, &scene, &config(IndirectEnd::Cache, 5));
    resumed.restore(2, &state).expect("a state");
    assert!(path_layer(&mut resumed, 3..5) == next);
    // A cut empties the cache.
    one.jump();
    let mut cut = open(&CPU, &scene, &config(IndirectEnd::Path, 5));
    assert!(path_layer(&mut one, 5..6) == path_layer(&mut cut, 5..6));
    one.restart().expect("a restart");
    assert!(path_layer(&mut one, 0..3) == start);
}

/// The frame in which a light has moved has the bits of whole paths: no light of before is left.
#[test]
fn the_cache_forgets_a_light_in_the_frame_in_which_it_moves() {
    let mut scene = committed("animated-light");
    let mut sessions = ENDS.map(|end| open(&CPU, &scene, &config(end, 1)));
    for (pose, time) in [0.0, 0.5, 0.0].into_iter().enumerate() {
        scene.pose(time).expect("a pose");
        let is_cached = [0, 1, 2, 3, 4, 5].map(|frame| {
            let index = 6 * pose as u32 + frame;
            let [paths, cached] = sessions.each_mut().map(|session| {
                if frame == 0 {
                    session.pose(&scene, &scene.cameras[0]).expect("a pose");
                }
                path_layer(session, index..index + 1)
            });
            paths != cached
        });
        assert!(!is_cached[0] && is_cached[5], "{time} s: {is_cached:?}");
    }
}
