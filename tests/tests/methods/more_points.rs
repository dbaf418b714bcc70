//! Several collection points a pixel: their numbers, what they leave alone, and their gain.

use caustics::render_config::{Paths, RenderConfig};
use caustics::rendered_image::RenderedImage;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::emission::{AIMED, GUIDED};
use caustics_kernels::interface::choice::{PixelFilter, Sampler};
use caustics_kernels::interface::point::{PointGeometry, PointShading};
use caustics_kernels::method::PROGRESSIVE;
use caustics_kernels::pass::more_points::MAX_POINTS;
use caustics_tests::frames::around;
use caustics_tests::scenes::committed;
use caustics_tests::statistics::Mean;

const CPU: RunnerChoice = RunnerChoice::Cpu { threads: 0 };
const SIZE: (usize, usize) = (80, 45);

fn config(collection_points: u32, seed: u32) -> RenderConfig {
    RenderConfig {
        width: SIZE.0 as u32,
        height: SIZE.1 as u32,
        method: &PROGRESSIVE,
        light_paths: Paths::Count(1800),
        pixel_filter: PixelFilter::Box,
        emission: &AIMED,
        sampler: Sampler::Sobol,
        collection_points,
        seed,
        ..RenderConfig::default()
    }
}

fn open(scene: &Scene, config: &RenderConfig) -> Session {
    let features = scene.features(config.specular_roughness);
    Session::new(&CPU, scene, &scene.cameras[0], config, features).expect("a session opens")
}

/// Runs a frame and returns its image.
fn image(session: &mut Session, frame: u32) -> RenderedImage {
    session.frame(frame).expect("a frame runs");
    session.image().expect("an image")
}

/// Caustics change in pixels with further points alone. Points, sums, and what the emission learns, remain those of one point.
#[test]
fn further_points_change_their_own_pixels_alone() {
    let scene = committed("glossy-room");
    for emission in [&AIMED, &GUIDED] {
        let [mut one, mut several] =
            [1, MAX_POINTS].map(|points| open(&scene, &RenderConfig { emission, ..config(points, 1) }));
        for frame in 0..6 {
            let [before, after] = [&mut one, &mut several].map(|session| image(session, frame));
            assert!(before.path == after.path, "{frame}: the path layer differs");
            let slots: Vec<[u32; 2]> = several.read("point_slots").expect("slots");
            let mut changed = 0;
            for (pixel, [_, further]) in slots.iter().enumerate() {
                let differs = before.caustics[pixel] != after.caustics[pixel];
                assert!(*further > 0 || !differs, "{frame}: pixel {pixel} differs");
                changed += usize::from(differs);
            }
            // Two frames must be known.
            let with_further = slots.iter().filter(|[_, further]| *further > 0).count();
            println!("{}, frame {frame}: {with_further} pixels, {changed} changed", emission.name);
            assert_eq!(with_further > 30 && changed > 15, frame >= 2, "{frame}: {with_further}, {changed}");
            let [geometry, kept] =
                [&mut one, &mut several].map(|s| s.read::<PointGeometry>("point_geometry").unwrap());
            assert!(geometry == kept, "{frame}: points differ");
            let [shading, kept] =
                [&mut one, &mut several].map(|s| s.read::<PointShading>("point_shading").unwrap());
            assert!(shading == kept, "{frame}: shading differs");
            let [sums, kept] = [&mut one, &mut several].map(|s| s.read::<u32>("accumulator").unwrap());
            assert!(sums == kept, "{frame}: sums differ");
        }
    }
}

/// The number of points is that of the formula over the variances of earlier frames. A row has no more further points than pixels,
/// each in a slot of its own.
#[test]
fn numbers_of_points_follow_from_the_variances_of_earlier_frames() {
    let scene = committed("glossy-room");
    let mut session = open(&scene, &config(MAX_POINTS, 1));
    (0..12).for_each(|frame| drop(session.frame(frame).expect("a frame runs")));
    let variances: Vec<[f32; 2]> = session.read("pixel_variances").expect("variances");
    session.frame(12).expect("a frame runs");
    let counts: Vec<u32> = session.read("point_counts").expect("counts");
    for (pixel, count) in counts.iter().enumerate() {
        let sum = |part: usize| around(pixel, 2, SIZE).iter().map(|at| f64::from(variances[*at][part])).sum();
        let (by_prefix, other): (f64, f64) = (sum(0), sum(1));
        let best = if by_prefix > 0.0 { (4.0 * by_prefix / other).sqrt() } else { 0.0 };
        let best = best.clamp(1.0, f64::from(MAX_POINTS));
        assert!((f64::from(*count) - best).abs() < 0.501, "{pixel}: {count} points, best {best}");
    }
    assert!(counts.iter().filter(|count| **count > 4).count() > 30);
    let slots: Vec<[u32; 2]> = session.read("point_slots").expect("slots");
    let prefixes: Vec<[u32; 2]> = session.read("slot_prefixes").expect("prefixes");
    let mut full_rows = 0;
    for row in 0..SIZE.1 {
        let pixels = row * SIZE.0..(row + 1) * SIZE.0;
        let wanted: u32 = counts[pixels.clone()].iter().map(|count| count - 1).sum();
        let mut next = pixels.start as u32;
        for pixel in pixels.clone() {
            let [first, further] = slots[pixel];
            assert_eq!(first, next, "{pixel}");
            let fits = wanted <= SIZE.0 as u32;
            assert!(if fits { further == counts[pixel] - 1 } else { further < counts[pixel] }, "{pixel}");
            for number in 1..=further {
                assert_eq!(prefixes[next as usize], [pixel as u32, number]);
                next += 1;
            }
        }
        full_rows += u32::from(wanted > SIZE.0 as u32);
        assert!(prefixes[next as usize..pixels.end].iter().all(|[pixel, _]| *pixel == u32::MAX), "{row}");
    }
    println!("{full_rows} rows want more points than they have slots");
}

/// Where pixels get several points, less than half of the variance is left, and the light is the same. A rough mirror shows caustics
/// there.
#[test]
fn several_points_halve_the_variance_of_caustics_in_a_rough_mirror() {
    let scene = committed("glossy-room");
    let (frames, seeds) = (24, 16);
    let pixels = 0..SIZE.0 * SIZE.1;
    let mut further = vec![0; pixels.len()];
    // Caustics of runs, as means over their frames.
    let mut runs = |points, first_seed| {
        let run = |seed| {
            let mut session = open(&scene, &config(points, seed));
            let mut caustics = vec![0.0; pixels.len()];
            for frame in 0..frames {
                let image = image(&mut session, frame);
                for pixel in pixels.clone() {
                    caustics[pixel] += f64::from(image.caustics[pixel].element_sum()) / f64::from(frames);
                }
            }
            if points > 1 {
                let slots: Vec<[u32; 2]> = session.read("point_slots").expect("slots");
                pixels.clone().for_each(|pixel| further[pixel] += slots[pixel][1]);
            }
            caustics
        };
        (first_seed..first_seed + seeds).map(run).collect()
    };
    let (one, control, several): (Vec<_>, Vec<_>, Vec<_>) =
        (runs(1, 0), runs(1, seeds), runs(MAX_POINTS, 2 * seeds));
    let region: Vec<usize> = pixels.filter(|pixel| further[*pixel] >= 4 * seeds).collect();
    assert!(region.len() > 10, "{}", region.len());

    // Average logarithms: in variances a few rare bright samples would decide.
    let of_pixel = |runs: &[Vec<f64>], pixel: usize| {
        Mean::from_samples(&runs.iter().map(|run| run[pixel]).collect::<Vec<f64>>()).error.powi(2)
    };
    let ratio = |runs: &[Vec<f64>], others: &[Vec<f64>]| {
        let logarithm = |pixel: &usize| (of_pixel(runs, *pixel) / of_pixel(others, *pixel)).ln();
        (region.iter().map(logarithm).sum::<f64>() / region.len() as f64).exp()
    };
    let (of_control, gain) = (ratio(&control, &one), ratio(&several, &one).max(ratio(&several, &control)));
    println!("{} pixels, ratio of variances {of_control}, {gain}", region.len());
    assert!((0.6..1.7).contains(&of_control), "{of_control}");
    assert!(gain < 0.5, "{gain}");

    let sums = |runs: &[Vec<f64>]| {
        let of_run = |run: &Vec<f64>| region.iter().map(|pixel| run[*pixel]).sum();
        Mean::from_samples(&runs.iter().map(of_run).collect::<Vec<f64>>())
    };
    let one = sums(&[one, control].concat());
    let several = sums(&several);
    println!("light {} +- {}, {} +- {}", one.value, one.error, several.value, several.error);
    assert!(one.agrees(&several, 3.0), "{} sigma", one.sigmas(&several));
}
