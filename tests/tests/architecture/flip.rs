//! FLIP against NVIDIA's: LDR against their C++ code (crate nv-flip), HDR against golden files of their tool.

use std::path::Path;

use caustics::image_file::{Channels, Encoding};
use caustics::metric::error_map::ErrorMap;
use caustics::metric::flip::PIXELS_PER_DEGREE;
use caustics::metric::flip_hdr::{Exposures, expose, flip_hdr};
use caustics::metric::flip_ldr::flip_ldr;
use caustics::metric::pixels::{Pixels, Region};
use glam::DVec3;
use nv_flip::FlipImageRgb8;

/// Bound on the mean and on each pixel of the error map. NVIDIA's code is f32, ours f64.
const TOLERANCE: f64 = 1e-4;

/// An image of bytes.
#[derive(Clone)]
struct Bytes {
    width: usize,
    height: usize,
    values: Vec<[u8; 3]>,
}

impl Bytes {
    fn new(width: usize, height: usize, at: impl Fn(usize, usize) -> [u8; 3]) -> Bytes {
        let values = (0..width * height).map(|pixel| at(pixel % width, pixel / width)).collect();
        Bytes { width, height, values }
    }

    /// Independent uniform bytes.
    fn noise(width: usize, height: usize, seed: u64) -> Bytes {
        Bytes::new(width, height, |x, y| {
            let mut state = seed ^ ((y * width + x) as u64) << 8;
            // SplitMix64.
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            [state >> 16, state >> 32, state >> 48].map(|value| value as u8)
        })
    }

    fn pixels(&self) -> Pixels {
        let channel =
            |channel: usize| self.values.iter().map(|value| f32::from(value[channel]) / 255.0).collect();
        let channels = [("R", channel(0)), ("G", channel(1)), ("B", channel(2))];
        let image = Channels {
            width: self.width,
            height: self.height,
            channels: channels.into_iter().map(|(name, values)| (name.to_string(), values)).collect(),
            encoding: Encoding::Srgb,
            ..Channels::default()
        };
        Pixels::from_layer(&image, "", Region::whole(&image)).unwrap()
    }

    fn nvidia(&self) -> FlipImageRgb8 {
        FlipImageRgb8::with_data(self.width as u32, self.height as u32, self.values.as_flattened())
    }
}

/// Our error map and NVIDIA's.
fn maps(image: &Bytes, reference: &Bytes, pixels_per_degree: f64) -> (ErrorMap, Vec<f64>) {
    let ours = flip_ldr(&image.pixels(), &reference.pixels(), Encoding::Srgb, 0.0, pixels_per_degree);
    let theirs = nv_flip::flip(reference.nvidia(), image.nvidia(), pixels_per_degree as f32);
    (ours, theirs.to_vec().into_iter().map(f64::from).collect())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn largest_difference(ours: &ErrorMap, theirs: &[f64]) -> f64 {
    assert_eq!(ours.values.len(), theirs.len());
    ours.values.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Pairs of images with a name: noise, edges, points, gradients, shifts.
fn pairs(width: usize, height: usize) -> Vec<(&'static str, Bytes, Bytes)> {
    let noise = Bytes::noise(width, height, 1);
    let less = |amplitude: u8| {
        let other = Bytes::noise(width, height, 2);
        Bytes::new(width, height, |x, y| {
            let (a, b) = (noise.values[y * width + x], other.values[y * width + x]);
            [0, 1, 2].map(|channel| a[channel].saturating_add(b[channel] % (amplitude + 1)))
        })
    };
    let grey = |value: u8| Bytes::new(width, height, |_, _| [value; 3]);
    let edges = |shift: usize| {
        Bytes::new(width, height, |x, y| {
            if ((x + shift) / 5 + y / 7).is_multiple_of(2) { [230, 40, 20] } else { [20, 90, 200] }
        })
    };
    let points = |period: usize| {
        Bytes::new(width, height, |x, y| if x % period == 3 && y % period == 1 { [255; 3] } else { [12; 3] })
    };
    let gradient = |gain: usize| {
        Bytes::new(width, height, |x, y| [x * gain, y * 3, x + y].map(|value| value.min(255) as u8))
    };
    vec![
        ("independent noise", Bytes::noise(width, height, 3), noise.clone()),
        ("faint noise", less(4), noise.clone()),
        ("strong noise", less(60), noise.clone()),
        ("black and white", grey(255), grey(0)),
        ("one step of grey", grey(129), grey(128)),
        (
            "green and blue",
            Bytes::new(width, height, |_, _| [0, 255, 0]),
            Bytes::new(width, height, |_, _| [0, 0, 255]),
        ),
        ("shifted edges", edges(1), edges(0)),
        ("points", points(9), points(6)),
        ("points on noise", points(9), noise),
        ("gradients", gradient(2), gradient(1)),
    ]
}

#[test]
fn ldr_flip_equals_nvidias_on_every_pixel_to_1e_4() {
    let mut worst: f64 = 0.0;
    for (width, height) in [(1, 1), (2, 1), (1, 5), (7, 3), (64, 48), (131, 97)] {
        for (name, image, reference) in pairs(width, height) {
            let (ours, theirs) = maps(&image, &reference, PIXELS_PER_DEGREE);
            let difference = largest_difference(&ours, &theirs);
            println!(
                "{width}x{height} {name}: mean {:.6}, theirs {:.6}, {difference:.2e}",
                ours.mean(),
                mean(&theirs)
            );
            assert!(difference <= TOLERANCE, "{width}x{height} {name}");
            assert!((ours.mean() - mean(&theirs)).abs() <= TOLERANCE, "{width}x{height} {name}");
            worst = worst.max(difference);
        }
    }
    println!("largest difference {worst:.2e}");
}

#[test]
fn ldr_flip_equals_nvidias_at_other_viewing_distances_to_5e_4() {
    for pixels_per_degree in [12.0, 33.5, 120.0] {
        for (name, image, reference) in pairs(61, 47) {
            let (ours, theirs) = maps(&image, &reference, pixels_per_degree);
            let difference = largest_difference(&ours, &theirs);
            // Where features agree, f32's rounding of 1e-7 enters NVIDIA's result by its square root, in an exponent.
            assert!(difference <= 5e-4, "{name} at {pixels_per_degree}: {difference}");
            let means = (ours.mean(), mean(&theirs));
            assert!((means.0 - means.1).abs() <= TOLERANCE, "{name} at {pixels_per_degree}: {means:?}");
        }
    }
}

#[test]
fn default_viewing_distance_equals_nvidias() {
    assert!((PIXELS_PER_DEGREE - f64::from(nv_flip::DEFAULT_PIXELS_PER_DEGREE)).abs() < 0.03);
}

#[test]
fn flip_maps_have_nvidias_colours_to_one_step_of_a_byte() {
    let values: Vec<f64> = (0..256).map(|step| f64::from(step) / 255.0).collect();
    let ours = ErrorMap { width: 256, height: 1, values: values.clone() }.to_colors();
    let data: Vec<f32> = values.iter().map(|&value| value as f32).collect();
    let ramp = nv_flip::FlipImageFloat::with_data(256, 1, &data);
    let theirs = ramp.apply_color_lut(&nv_flip::magma_lut()).to_vec();
    let ours: Vec<u8> =
        ours.iter().flat_map(|color| (*color * 255.0 + 0.5).to_array()).map(|v| v as u8).collect();
    // Both round the same table to a byte.
    let far = ours.iter().zip(&theirs).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    assert_eq!(far, 0);
}

#[test]
fn equal_images_have_zero_flip() {
    for (name, image, _) in pairs(33, 17) {
        let map = flip_ldr(&image.pixels(), &image.pixels(), Encoding::Srgb, 0.0, PIXELS_PER_DEGREE);
        assert!(map.values.iter().all(|&value| value == 0.0), "{name}");
        let map = flip_hdr(&image.pixels(), &image.pixels(), PIXELS_PER_DEGREE).unwrap();
        assert!(map.values.iter().all(|&value| value == 0.0), "{name}");
    }
}

/// Image, reference and NVIDIA's error map of a golden file.
fn golden(name: &str) -> (Pixels, Pixels, Vec<f64>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/flip").join(name);
    let image = Channels::read(&file).unwrap();
    let pixels = |layer| Pixels::from_layer(&image, layer, Region::whole(&image)).unwrap();
    let map = image.channels["flip"].iter().map(|&value| f64::from(value)).collect();
    (pixels("image"), pixels("reference"), map)
}

#[test]
fn hdr_flip_equals_nvidias_golden_maps_to_1e_4() {
    for name in ["noise.exr", "structure.exr", "small.exr"] {
        let (image, reference, theirs) = golden(name);
        let ours = flip_hdr(&image, &reference, PIXELS_PER_DEGREE).unwrap();
        let difference = largest_difference(&ours, &theirs);
        println!("{name}: mean {:.6}, theirs {:.6}, {difference:.2e}", ours.mean(), mean(&theirs));
        assert!(difference <= TOLERANCE, "{name}");
        assert!((ours.mean() - mean(&theirs)).abs() <= TOLERANCE, "{name}");
    }
}

/// HDR-FLIP composed here of NVIDIA's LDR-FLIP; their crate takes bytes, so the images are rounded to bytes first.
#[test]
fn hdr_flip_is_the_maximum_of_nvidias_ldr_flip_over_the_exposures() {
    let (image, reference, _) = golden("structure.exr");
    let mut largest = vec![0.0_f64; image.values.len()];
    for stops in Exposures::from_reference(&reference).unwrap().all() {
        let shown = |image: &Pixels| {
            let encode =
                |x: f64| if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
            Bytes::new(image.width, image.height, |x, y| {
                let color = expose(image.values[y * image.width + x], stops);
                color.to_array().map(|value| (encode(value) * 255.0).round() as u8)
            })
        };
        let map = nv_flip::flip(shown(&reference).nvidia(), shown(&image).nvidia(), PIXELS_PER_DEGREE as f32);
        largest
            .iter_mut()
            .zip(map.to_vec())
            .for_each(|(largest, value)| *largest = largest.max(f64::from(value)));
    }
    let ours = flip_hdr(&image, &reference, PIXELS_PER_DEGREE).unwrap();
    // Half a byte is 0.2 % of the scale. Differences of features enter by a square root, and so do the roundings.
    println!(
        "mean {:.4}, composed {:.4}, {:.3}",
        ours.mean(),
        mean(&largest),
        largest_difference(&ours, &largest)
    );
    assert!((ours.mean() - mean(&largest)).abs() < 0.005);
    assert!(largest_difference(&ours, &largest) < 0.06);
}

#[test]
fn hdr_flip_does_not_depend_on_the_unit_of_radiance() {
    let (image, reference, _) = golden("noise.exr");
    let map = flip_hdr(&image, &reference, PIXELS_PER_DEGREE).unwrap();
    for scale in [1e-3, 512.0] {
        let scaled = [&image, &reference].map(|image| image.map(|value: DVec3| value * scale));
        let other = flip_hdr(&scaled[0], &scaled[1], PIXELS_PER_DEGREE).unwrap();
        // Exposures are differences of logarithms: 1e-15, times the slopes of the filters.
        assert!(largest_difference(&other, &map.values) < 1e-6, "{scale}");
    }
}

#[test]
fn flip_of_one_differing_pixel_ends_10_columns_from_it() {
    let (mut image, reference, _) = golden("structure.exr");
    image.values.clone_from(&reference.values);
    let at = 15 * image.width + 20;
    image.values[at] *= 3.0;
    let map = flip_hdr(&image, &reference, PIXELS_PER_DEGREE).unwrap();
    let worst = (0..map.values.len()).max_by(|&a, &b| map.values[a].total_cmp(&map.values[b])).unwrap();
    let (x, y): (usize, usize) = (worst % map.width, worst / map.width);
    assert!(map.mean() > 0.0 && x.abs_diff(20) <= 1 && y.abs_diff(15) <= 1, "{x}, {y}");
    // Its error reaches as far as the filters do.
    assert!(
        map.values
            .iter()
            .enumerate()
            .all(|(pixel, &value)| (pixel % map.width).abs_diff(20) <= 10 || value == 0.0)
    );
}
