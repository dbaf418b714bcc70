//! Indirect light that collection points share: the means that they take, its gain, and what it leaves alone.

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::emission::GUIDED;
use caustics_kernels::interface::NONE;
use caustics_kernels::interface::balance::{Balance, ShareBalance};
use caustics_kernels::interface::choice::{IndirectShare, PixelFilter, Sampler};
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::packed::{from_bfloats, from_rgbe};
use caustics_kernels::interface::point::{IndirectSample, PointGeometry, PointShading, SharingPoint};
use caustics_kernels::method::PROGRESSIVE;
use caustics_kernels::method::progressive::share_shrinkage;
use caustics_kernels::pass::share::SHARE_RADIUS_PX;
use caustics_kernels::path::camera_path::CameraPathLight;
use caustics_tests::scenes::{Builder, committed, emitter, lambert, metal};
use caustics_tests::statistics::Mean;
use glam::{DVec3, Vec3};
use std::collections::HashSet;

pub const CPU: RunnerChoice = RunnerChoice::Cpu { threads: 0 };
const SHARES: [IndirectShare; 2] = [IndirectShare::None, IndirectShare::Points];

pub fn config(indirect_share: IndirectShare, seed: u32) -> RenderConfig {
    RenderConfig {
        width: 80,
        height: 45,
        method: &PROGRESSIVE,
        light_paths: Paths::Count(1800),
        pixel_filter: PixelFilter::Box,
        sampler: Sampler::Sobol,
        indirect_share: Some(indirect_share),
        seed,
        ..RenderConfig::default()
    }
}

pub fn open(choice: &RunnerChoice, scene: &Scene, config: &RenderConfig) -> Session {
    let features = scene.features(config.specular_roughness);
    Session::new(choice, scene, &scene.cameras[0], config, features).expect("a session opens")
}

/// The path layer after some frames.
fn path_layer(choice: &RunnerChoice, scene: &Scene, config: &RenderConfig, frames: u32) -> Vec<Vec3> {
    let mut session = open(choice, scene, config);
    let mut sum = vec![Vec3::ZERO; (config.width * config.height) as usize];
    for frame in 0..frames {
        session.frame(frame).expect("a frame runs");
        let path = session.image().expect("an image").path;
        sum.iter_mut().zip(path).for_each(|(sum, light)| *sum += light / frames as f32);
    }
    sum
}

/// A room of matte walls under a lamp, with a mirror in one half of the view.
pub fn room_with_a_mirror() -> Scene {
    room_with_a_mirror_of(0.0)
}

/// The room with a mirror of this roughness.
fn room_with_a_mirror_of(roughness: f32) -> Scene {
    let mut b = Builder::default();
    let (wall, lamp, mirror) =
        (b.material(lambert(0.7)), b.material(emitter(10.0)), b.material(metal(0.9, roughness)));
    b.block(wall, DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 2.0, 1.0), true);
    b.panel(lamp, DVec3::new(0.0, 1.99, 0.0), 0.3 * DVec3::X, 0.3 * DVec3::Z);
    b.panel(mirror, DVec3::new(0.5, 0.9, -0.98), 0.5 * DVec3::X, 0.7 * DVec3::Y);
    b.camera(DVec3::new(0.0, 1.0, 0.95), DVec3::new(0.0, 0.9, -1.0), 0.9);
    b.build()
}

/// A search over all pairs in f64 finds the mean of the samples around each point. The change of its pixel is the throughput, times
/// the albedo, times the difference between that mean and its own sample.
#[test]
fn points_take_the_mean_of_the_samples_on_their_own_surface_within_the_radius() {
    let scene = room_with_a_mirror();
    let frame = 2;
    let [mut none, mut points] = SHARES.map(|share| open(&CPU, &scene, &config(share, 3)));
    // The frames before leave points in the index that must not count again.
    for index in 0..=frame {
        none.frame(index).expect("a frame runs");
        points.frame(index).expect("a frame runs");
    }
    let [before, after] = [&mut none, &mut points].map(|session| session.image().expect("an image").path);
    let geometry: Vec<PointGeometry> = points.read("point_geometry").expect("points");
    let shading: Vec<PointShading> = points.read("point_shading").expect("shading");
    let samples: Vec<IndirectSample> = points.read("point_indirect").expect("samples");
    let indexed: Vec<SharingPoint> = points.read("sharing_points").expect("an index");
    let bits = |position: Vec3| position.to_array().map(f32::to_bits);
    let indexed: HashSet<[u32; 3]> = indexed.iter().map(|point| bits(point.position)).collect();
    let has_sample = |i: &usize| geometry[*i].exists() && samples[*i].light[0] != NONE;
    // Of crowded cells the index leaves some points out.
    let gives = |i: &usize| has_sample(i) && indexed.contains(&bits(geometry[*i].position));
    let (with_sample, giving) =
        ((0..geometry.len()).filter(has_sample).count(), (0..geometry.len()).filter(gives).count());
    assert!(giving < with_sample && giving > with_sample * 3 / 4, "{giving} of {with_sample}");
    // The radii of points shrink as those of progressive photon mapping, those of sharing more slowly.
    let radius_px = caustics_kernels::method::progressive::shrinkage(frame);
    let scale = SHARE_RADIUS_PX * share_shrinkage(frame) / radius_px;
    let (mut most, mut from_mirrors, mut changed, mut halved) = (0, 0, 0, 0);
    for i in (0..geometry.len()).filter(has_sample) {
        let point = &geometry[i];
        let share_radius = |j: usize| from_bfloats(samples[j].radius_and_proximity).0 * scale;
        let radius = share_radius(i);
        let level = radius.to_bits() >> 23;
        let within_levels = |radius: f32, levels: u32| -> Vec<usize> {
            let takes = |&j: &usize| {
                let (along, other) = (geometry[j].position - point.position, &geometry[j]);
                along.length() <= radius
                    && along.dot(point.normal).abs() <= 0.1 * radius
                    && shading[j].shading_normal.dot(shading[i].shading_normal) > 0.9
                    && shading[j].material == shading[i].material
                    && other.depth <= point.depth
                    && (share_radius(j).to_bits() >> 23).abs_diff(level) <= levels
            };
            (0..geometry.len()).filter(gives).filter(takes).collect()
        };
        // Below four samples of its own level a point takes those of the lower one, and below four still those of the higher one.
        let within = |radius: f32| {
            let own_level = within_levels(radius, 0);
            if own_level.len() >= 4 {
                return own_level;
            }
            let all = within_levels(radius, 1);
            let is_lower = |&j: &usize| share_radius(j).to_bits() >> 23 <= level;
            let lower: Vec<usize> = all.iter().copied().filter(is_lower).collect();
            if lower.len() >= 4 { lower } else { all }
        };
        // The first of the halved radii that is at most a quarter of the harmonic mean distance of surfaces.
        let is_far = |radius: f32| {
            let steps = |j: &usize| {
                ((radius * from_bfloats(samples[*j].radius_and_proximity).1).min(1.0) * 1024.0) as u32
            };
            let near = within(radius);
            near.iter().map(steps).sum::<u32>() as f32 <= 0.25 * 1024.0 * near.len() as f32
        };
        let found =
            [1.0, 0.5, 0.25, 0.125].map(|part| part * radius).into_iter().find(|&radius| is_far(radius));
        halved += u32::from(found.is_some_and(|found| found < radius));
        let taken = found.map_or(vec![i], within);
        let (mut sum, mut count) = (glam::DVec3::ZERO, 0);
        for j in taken {
            let deeper = (point.depth - geometry[j].depth) as usize;
            sum += from_rgbe(samples[j].light[deeper]).as_dvec3();
            count += 1;
            from_mirrors += u32::from(deeper > 0);
        }
        let own = from_rgbe(samples[i].light[0]).as_dvec3();
        let mean = if count > 1 { sum / f64::from(count) } else { own };
        let change = shading[i].throughput.as_dvec3() * 0.7 * (mean - own);
        let found = (after[i] - before[i]).as_dvec3();
        let size = before[i].as_dvec3().max_element() + own.max_element() + sum.max_element();
        assert!(
            (found - change).abs().max_element() <= 1e-5 * size,
            "{i}: {found} instead of {change}, {count}"
        );
        most = most.max(count);
        changed += u32::from(count > 1);
    }
    println!(
        "up to {most} samples, {from_mirrors} of shallower points, {changed} points changed, {halved} radii halved"
    );
    assert!(most > 60 && from_mirrors > 100, "{most} {from_mirrors}");
    assert!(changed > 3000 && halved > 300, "{changed} {halved}");
}

/// A rough mirror widens the discs of photons. The distance between points that are seen in it stays that of a smooth mirror, and
/// so does the radius within which they share.
#[test]
fn a_rough_mirror_does_not_widen_the_radius_of_sharing() {
    let radii = |roughness| {
        let scene = room_with_a_mirror_of(roughness);
        let mut session = open(&CPU, &scene, &config(IndirectShare::Points, 1));
        session.frame(0).expect("a frame runs");
        let geometry: Vec<PointGeometry> = session.read("point_geometry").expect("points");
        let samples: Vec<IndirectSample> = session.read("point_indirect").expect("samples");
        let of_depth = |depth: u32| {
            let points = geometry.iter().zip(&samples).filter(move |(point, _)| point.depth == depth);
            let radii =
                points.map(|(point, sample)| [point.radius, from_bfloats(sample.radius_and_proximity).0]);
            let mut radii: Vec<[f32; 2]> = radii.collect();
            assert!(radii.len() > 100, "{}", radii.len());
            [0, 1].map(|which| {
                radii.sort_by(|a, b| a[which].total_cmp(&b[which]));
                radii[radii.len() / 2][which]
            })
        };
        [1, 2].map(of_depth)
    };
    let ([direct, seen_smooth], [_, seen_rough]) = (radii(0.0), radii(0.25));
    println!("{direct:?}, in the mirror {seen_smooth:?} {seen_rough:?}");
    // Radii of sharing are rounded to eight bits.
    for [disc, share] in [direct, seen_smooth] {
        assert!(share <= disc && share > 0.99 * disc, "{share} {disc}");
    }
    assert!(seen_rough[0] > 1.3 * seen_smooth[0], "{seen_rough:?}");
    assert!((seen_rough[1] / seen_smooth[1] - 1.0).abs() < 0.1, "{seen_rough:?} {seen_smooth:?}");
}

/// A room whose right half is dark behind a wall without thickness at this x, on the same floor and before the same back wall.
pub fn rooms_beside_a_thin_wall(x: f64) -> Scene {
    let mut b = Builder::default();
    let (wall, lamp) = (b.material(lambert(0.7)), b.material(emitter(10.0)));
    b.panel(wall, DVec3::ZERO, 2.0 * DVec3::X, -DVec3::Z);
    b.panel(wall, DVec3::new(0.0, 1.0, -1.0), 2.0 * DVec3::X, DVec3::Y);
    b.panel(wall, DVec3::new(0.0, 2.0, 0.0), 2.0 * DVec3::X, DVec3::Z);
    b.panel(wall, DVec3::new(-2.0, 1.0, 0.0), -DVec3::Z, DVec3::Y);
    for side in [-1.0, 1.0] {
        b.panel(wall, DVec3::new(x, 1.0, 0.0), side * DVec3::Z, DVec3::Y);
    }
    b.panel(lamp, DVec3::new(-1.0, 1.99, 0.0), 0.3 * DVec3::X, 0.3 * DVec3::Z);
    b.camera(DVec3::new(0.0, 1.6, 4.2), DVec3::new(0.0, 0.8, 0.0), 0.75);
    b.build()
}

/// Half of a room is dark behind a wall without thickness, on the same floor and before the same back wall. The dark half takes less
/// than a thousandth of the light of the other one.
#[test]
fn little_light_is_shared_through_a_thin_wall() {
    let scene = rooms_beside_a_thin_wall(0.0);
    for frames in [1, 16] {
        let [none, points] = SHARES.map(|share| path_layer(&CPU, &scene, &config(share, 1), frames));
        let is_dark = |pixel: &usize| pixel % 80 >= 41;
        let sum = |layer: &[Vec3], side: bool| -> f64 {
            let of_side = (0..layer.len()).filter(|pixel| is_dark(pixel) == side);
            of_side.map(|pixel| f64::from(layer[pixel].element_sum())).sum()
        };
        assert_eq!(sum(&none, true), 0.0);
        let leak = sum(&points, true) / sum(&points, false);
        println!("{frames} frames: {leak:.1e}");
        assert!(leak < 1e-3, "{frames}: {leak}");
    }
}

/// Directly and in the mirror, light has as many bounces as without sharing. One bounce more would be noticed.
#[test]
fn shared_light_has_the_bounces_of_unshared_light() {
    let scene = room_with_a_mirror();
    let halves = |share, max_bounces| {
        let means = (0..24).map(|seed| {
            let config = RenderConfig { max_bounces, ..config(share, seed) };
            let layer = path_layer(&CPU, &scene, &config, 4);
            [0..40, 40..80].map(|columns: std::ops::Range<usize>| {
                let own = layer.iter().enumerate().filter(|(i, _)| columns.contains(&(i % 80)));
                own.map(|(_, light)| f64::from(light.y)).sum::<f64>() / 1800.0
            })
        });
        let means: Vec<[f64; 2]> = means.collect();
        [0, 1].map(|half| Mean::from_samples(&means.iter().map(|mean| mean[half]).collect::<Vec<_>>()))
    };
    for max_bounces in [2, 3, 5, 9] {
        let [none, points] = SHARES.map(|share| halves(share, max_bounces));
        let more = halves(IndirectShare::None, max_bounces + 1);
        for half in [0, 1] {
            let (none, points, more) = (none[half], points[half], more[half]);
            println!("{max_bounces}, half {half}: {none:?} {points:?}");
            assert!(none.agrees(&points, 4.0), "{max_bounces}: {} sigma", none.sigmas(&points));
            assert!(max_bounces == 9 || more.sigmas(&points) > 6.0, "{max_bounces} {}", more.sigmas(&points));
        }
    }
}

/// In four frames sharing leaves less than half of the variance. Light is the same, caustics keep their bits, and so does the number
/// of light paths that is chosen by the noise.
#[test]
fn sharing_halves_the_variance_and_leaves_caustics_alone() {
    for name in ["cornell-box", "mirror-room"] {
        let scene = committed(name);
        let runs = |share| -> Vec<Vec<Vec3>> {
            (0..8).map(|seed| path_layer(&CPU, &scene, &config(share, seed), 4)).collect()
        };
        let [none, points] = SHARES.map(runs);
        // Average logarithms: in variances a few rare bright samples would decide.
        let variance = |runs: &[Vec<Vec3>], pixel: usize| {
            let values: Vec<f64> = runs.iter().map(|run| f64::from(run[pixel].element_sum())).collect();
            Mean::from_samples(&values).error.powi(2)
        };
        let noisy: Vec<usize> = (0..none[0].len()).filter(|&pixel| variance(&none, pixel) > 0.0).collect();
        let logarithm = |&pixel: &usize| (variance(&points, pixel) / variance(&none, pixel)).ln();
        let gain = (noisy.iter().map(logarithm).sum::<f64>() / noisy.len() as f64).exp();
        let light = |runs: &[Vec<Vec3>]| {
            let sums = runs.iter().map(|run| run.iter().map(|light| f64::from(light.element_sum())).sum());
            Mean::from_samples(&sums.collect::<Vec<f64>>())
        };
        println!("{name}: {gain} of the variance, light {:?} {:?}", light(&none), light(&points));
        assert!(gain < 0.5, "{name}: {gain}");
        assert!(light(&none).agrees(&light(&points), 3.0), "{name}");

        let mut sessions = SHARES.map(|share| {
            let config = RenderConfig { light_paths: Paths::Auto, emission: &GUIDED, ..config(share, 1) };
            open(&CPU, &scene, &config)
        });
        for frame in 0..4 {
            let frames = sessions.each_mut().map(|session| {
                session.frame(frame).expect("a frame runs");
                let balance: Vec<Balance> = session.read("balance").expect("a number of light paths");
                (session.image().expect("an image").caustics, balance)
            });
            assert!(
                frames[0] == frames[1],
                "{name}, frame {frame}: caustics or their number of light paths differ"
            );
        }
    }
}

#[test]
fn shared_light_has_the_same_bits_with_one_thread_and_with_many() {
    for scene in [committed("mirror-room"), room_with_a_mirror()] {
        let choices = [1, 4].map(|threads| RunnerChoice::Cpu { threads });
        let [one, many] =
            choices.map(|choice| path_layer(&choice, &scene, &config(IndirectShare::Points, 5), 3));
        assert!(one == many);
    }
}

#[test]
fn sharing_pauses_where_it_does_not_pay() {
    // A floor under the open sky, with little indirect light beside the ring
    let ring = committed("ring");
    let config_of = |share| RenderConfig { width: 320, height: 180, ..config(share, 1) };
    let mut sessions = SHARES.map(|share| open(&CPU, &ring, &config_of(share)));
    let shared = [0, 1, 2, 3].map(|frame| {
        let [none, points] = sessions.each_mut().map(|session| {
            session.frame(frame).expect("a frame runs");
            session.image().expect("an image").path
        });
        none != points
    });
    // The first frame does not decide; the second one may have no light to share.
    assert!(shared[0] && !shared[2] && !shared[3], "frames that share: {shared:?}");

    // A room, in which it pays from the first frame on
    let mut room = open(&CPU, &committed("mirror-room"), &config(IndirectShare::Points, 1));
    for frame in 0..8 {
        room.frame(frame).expect("a frame runs");
        let balance = room.read::<ShareBalance>("share_balance").expect("a balance")[0];
        assert!(balance.pause == 0 && (frame == 0 || balance.worth() > 1.0), "frame {frame}: {balance:?}");
    }
}

#[test]
fn sharing_is_worth_its_time_if_it_lowers_variance_times_cost() {
    let balance = |gain| ShareBalance { gain, variance: 8.0, cost: 1.0, other_cost: 3.0, pause: 0 };
    // (8 - gain) (3 + 1) = 8 * 3 at a gain of 2.
    assert_eq!(balance(2.0).worth(), 1.0);
    assert!(balance(1.9).worth() < 1.0 && balance(2.1).worth() > 1.0);
}

/// A path without a finite light leaves no sample.
#[test]
fn the_default_light_of_a_camera_path_gives_no_sample() {
    assert_eq!(CameraPathLight::default().indirect.light, [NONE; 3]);
}

/// Emission that the eye sees is not indirect light: sharing must not spread it over a texture.
#[test]
fn emission_seen_by_the_eye_is_not_shared() {
    let mut b = Builder::default();
    let lamp = b.material(Material { emission: Vec3::new(2.0, 1.0, 0.5), ..lambert(0.5) });
    b.panel(lamp, DVec3::new(0.0, 0.0, -2.0), 3.0 * DVec3::X, 3.0 * DVec3::Y);
    b.light(DVec3::new(0.0, 1.0, 0.0), 1.0);
    b.camera(DVec3::ZERO, DVec3::NEG_Z, 0.9);
    let mut session = open(&CPU, &b.build(), &config(IndirectShare::Points, 1));
    session.frame(0).expect("a frame runs");
    let samples: Vec<IndirectSample> = session.read("point_indirect").expect("samples");
    let given = samples.iter().filter(|sample| sample.light[0] != NONE);
    assert!(given.clone().count() > 1000, "points give samples");
    assert!(given.clone().all(|sample| from_rgbe(sample.light[0]) == Vec3::ZERO), "a plane lights nothing");
}
