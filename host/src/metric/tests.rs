//! Tests of the metrics against known values. Noisy images have fixed seeds.

use glam::DVec3;

use super::METRICS;
use super::comparison::{NoValue, Viewing};
use super::energy::energy;
use super::mse::mse;
use super::percentile::{percentile, quantile};
use super::pixels::{Estimate, Pixels};
use super::relmse;
use super::report::MetricReport;
use super::smape::smape;
use super::split::split;
use super::z_test::z_test;
use caustics_files::image_file::Encoding;

fn pixels(width: usize, height: usize, at: impl FnMut(usize) -> DVec3) -> Pixels {
    Pixels { width, height, values: (0..width * height).map(at).collect() }
}

fn constant(value: f64) -> Pixels {
    pixels(9, 5, |_| DVec3::splat(value))
}

/// Returns an image of many different values.
fn varied() -> Pixels {
    pixels(40, 30, |i| DVec3::new(i as f64 % 7.0, 0.1 + (i as f64 * 0.37).sin().abs(), 2.0))
}

/// Standard normal numbers: Box-Muller transform of SplitMix64.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }

    /// Returns a new sample of an image with independent noise of a relative deviation, and its variance.
    fn sample(&mut self, expected: &Pixels, deviation: f64) -> Estimate {
        let mut noisy = |value: f64| value + deviation * value * self.normal();
        let mean = pixels(expected.width, expected.height, |i| {
            DVec3::from_array(expected.values[i].to_array().map(&mut noisy))
        });
        Estimate {
            mean,
            variance: Some(expected.map(|value| value * value * deviation * deviation)),
            caustics: None,
        }
    }
}

fn without_variance(runs: Vec<Estimate>) -> Vec<Estimate> {
    runs.into_iter().map(|run| Estimate { variance: None, ..run }).collect()
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * b.abs()
}

#[test]
fn constant_images_have_known_errors() {
    let (image, reference) = (constant(3.0), constant(2.0));
    assert!(close(mse(&image, &reference), 1.0));
    let errors = relmse::errors(&image, &reference);
    let expected = 1.0 / (4.0 + 0.2 * 0.2);
    assert!(close(relmse::relmse(&errors), expected));
    assert!(close(relmse::trimmed(&errors), expected));
    assert!(close(percentile(&errors, 0.999), expected));
    assert!(close(smape(&image, &reference), 0.2));
    let estimate = |mean| Estimate { mean, ..Estimate::default() };
    assert!(close(energy(&[estimate(image)], &estimate(reference)).ratio, 1.5));
}

#[test]
fn a_shift_has_its_square_as_error() {
    let reference = varied();
    let image = reference.map(|value| value + DVec3::new(1.0, -2.0, 3.0));
    assert!(close(mse(&image, &reference), 14.0 / 3.0));
    assert_eq!(mse(&reference, &reference), 0.0);
    assert_eq!(relmse::relmse(&relmse::errors(&reference, &reference)), 0.0);
    assert_eq!(smape(&reference, &reference), 0.0);
}

#[test]
fn relative_metrics_do_not_change_with_the_unit() {
    let (image, reference) = (Noise(1).sample(&varied(), 0.3).mean, varied());
    let metrics = |image: &Pixels, reference: &Pixels| {
        let errors = relmse::errors(image, reference);
        let estimate = |mean: &Pixels| Estimate { mean: mean.clone(), ..Estimate::default() };
        let ratio = energy(&[estimate(image)], &estimate(reference)).ratio;
        [
            relmse::relmse(&errors),
            relmse::trimmed(&errors),
            percentile(&errors, 0.999),
            smape(image, reference),
            ratio,
        ]
    };
    let expected = metrics(&image, &reference);
    for scale in [1e-6, 3.0, 1e6] {
        let scaled = metrics(&image.map(|value| value * scale), &reference.map(|value| value * scale));
        assert!(scaled.iter().zip(expected).all(|(a, b)| close(*a, b)), "{scale}: {scaled:?}, {expected:?}");
    }
    let doubled = mse(&image.map(|value| value * 2.0), &reference.map(|value| value * 2.0));
    assert!(close(doubled, 4.0 * mse(&image, &reference)));
}

#[test]
fn smape_is_symmetric_and_at_most_one() {
    let (a, b) = (varied(), Noise(2).sample(&varied(), 0.5).mean);
    assert_eq!(smape(&a, &b), smape(&b, &a));
    assert_eq!(smape(&constant(0.0), &constant(0.0)), 0.0);
    assert_eq!(smape(&constant(0.0), &constant(5.0)), 1.0);
}

#[test]
fn percentiles_are_values_of_nearest_rank() {
    let values = |count: usize| (1..=count).rev().map(|value| value as f64).collect::<Vec<_>>();
    assert_eq!(percentile(&values(1000), 0.999), 999.0);
    assert_eq!(percentile(&values(1001), 0.999), 1000.0);
    assert_eq!(percentile(&values(2), 0.5), 1.0);
    assert_eq!(percentile(&[4.0], 0.999), 4.0);
    assert!(percentile(&[1.0, f64::NAN], 0.5).is_nan());
}

#[test]
fn quantiles_lie_between_values() {
    assert_eq!(quantile(&[1.25, 0.75], 0.5), 1.0);
    assert_eq!(quantile(&[4.0, 1.0, 3.0, 2.0, 5.0], 0.25), 2.0);
    assert_eq!(quantile(&[4.0, 1.0, 3.0, 2.0], 0.25), 1.75);
    assert_eq!([0.0, 1.0].map(|part| quantile(&[3.0, 2.0], part)), [2.0, 3.0]);
    assert_eq!(quantile(&[4.0], 0.95), 4.0);
    assert!(quantile(&[], 0.5).is_nan() && quantile(&[1.0, f64::NAN], 0.0).is_nan());
}

#[test]
fn a_firefly_counts_in_relmse_and_is_left_out_of_relmse_trimmed() {
    let mut errors = vec![0.25; 2000];
    (errors[17], errors[1203]) = (1e6, 5e5);
    assert!(relmse::relmse(&errors) > 700.0);
    assert!(close(relmse::trimmed(&errors), 0.25));
    // A third large error exceeds the trimmed part.
    errors[5] = 1e3;
    assert!(close(relmse::trimmed(&errors), (1997.0 * 0.25 + 1e3) / 1998.0));
    // With fewer than 1000 pixels, no pixel is trimmed.
    assert!(close(relmse::trimmed(&[1.0, 2.0, 6.0]), 3.0));
}

#[test]
fn energy_standard_error_matches_the_scatter_of_ratios() {
    let expected = pixels(32, 32, |_| DVec3::new(1.0, 2.0, 0.5));
    let mut noise = Noise(3);
    let reference = noise.sample(&expected, 0.01);
    let tries = 400;
    for runs in [1, 8] {
        let mut squares = 0.0;
        let mut estimated = 0.0;
        for _ in 0..tries {
            let images: Vec<_> = (0..runs).map(|_| noise.sample(&expected, 0.2)).collect();
            let energy = energy(&images, &reference);
            squares += (energy.ratio - 1.0).powi(2);
            estimated += energy.standard_error.unwrap().powi(2);
        }
        let ratio = estimated / squares;
        println!("{runs} runs: the estimated variance is {ratio:.3} of the true one");
        // A variance of 400 tries is known to 7 %. A variance layer counts channels as correlated, and these are
        // independent. The estimate is then larger by (1 + 2 + 0.5)^2 / (1 + 4 + 0.25) = 2.33.
        let exact = if runs == 1 { 12.25 / 5.25 } else { 1.0 };
        assert!((ratio / exact - 1.0).abs() < 0.28, "{ratio}");
    }
}

#[test]
fn squared_errors_split_into_bias_and_variance() {
    let exact = pixels(64, 64, |_| DVec3::ONE);
    let biased = exact.map(|value| value * 1.1);
    let (deviation, deviation_reference) = (0.3, 0.05);
    for runs in [1, 2, 16] {
        let mut noise = Noise(10 + runs as u64);
        let reference = noise.sample(&exact, deviation_reference);
        let mut images: Vec<_> = (0..runs).map(|_| noise.sample(&biased, deviation)).collect();
        if runs > 1 {
            images = without_variance(images);
        }
        let found = split(&images, &reference, |_| DVec3::ONE).unwrap();
        let whole: f64 =
            images.iter().map(|run| mse(&run.mean, &reference.mean)).sum::<f64>() / f64::from(runs);
        // The parts add up, apart from rounding.
        assert!(close(found.bias2 + found.variance + found.reference_variance, whole));
        // Bias 0.1, deviations 0.33 and 0.05: 12288 squared normal numbers, four standard errors.
        let of_mean = (1.1 * deviation).powi(2) / f64::from(runs) + deviation_reference.powi(2);
        let error = (4.0 * 0.01 * of_mean + 2.0 * of_mean * of_mean).sqrt() / 12288_f64.sqrt();
        println!("{runs} runs: bias^2 {:.5} +- {error:.5}, variance {:.5}", found.bias2, found.variance);
        assert!((found.bias2 - 0.01).abs() < 4.0 * error, "{found:?}");
        // The variance of one run is known from its layer, or estimated from 12288 (runs - 1) squares.
        let error = 0.1089 * (2.0 / f64::from(12288 * (runs - 1).max(1))).sqrt();
        assert!((found.variance - 0.1089).abs() < 4.0 * error, "{found:?}");
        assert!(close(found.reference_variance, 0.0025), "{found:?}");
    }
    let silent = without_variance(vec![Estimate { mean: exact.clone(), ..Estimate::default() }]);
    assert_eq!(split(&silent, &silent[0], |_| DVec3::ONE), None);
}

/// Returns the z-tests of `tries` pairs of images. The tested image is brighter by a factor.
fn z_tests(runs: usize, tries: usize, size: (usize, usize), gain: f64) -> Vec<super::z_test::ZTest> {
    let expected = pixels(size.0, size.1, |i| DVec3::new(1.0, 2.0, 0.5) * (1.0 + (i % 13) as f64));
    let mut noise = Noise(99 + runs as u64);
    let brighter = expected.map(|value| value * gain);
    let mut test = || {
        let reference = noise.sample(&expected, 0.05);
        let mut images: Vec<_> = (0..runs).map(|_| noise.sample(&brighter, 0.1)).collect();
        if runs > 1 {
            images = without_variance(images);
        }
        z_test(&images, &reference).unwrap()
    };
    (0..tries).map(|_| test()).collect()
}

#[test]
fn z_test_accepts_equal_expectations() {
    for (runs, size) in [(1, (64, 48)), (1, (37, 21)), (4, (64, 48)), (16, (37, 21))] {
        let tests = z_tests(runs, 200, size, 1.0);
        let mean_square = tests.iter().map(|test| test.mean_square).sum::<f64>() / 200.0;
        let rejected = |limit: f64| tests.iter().filter(|test| test.probability < limit).count();
        println!("{runs} runs, {size:?}: mean z^2 {mean_square:.3}, below 5 %: {} of 200", rejected(0.05));
        // A test has 144 or 45 values of z. Over 200 tests one deviation is 0.8 to 1.5 %. Welch's degrees of freedom are an
        // approximation.
        assert!((mean_square - 1.0).abs() < 0.06, "{mean_square}");
        // Bonferroni: at most 10 of 200 are expected below 5 %; 22 are four deviations more.
        assert!(rejected(0.05) <= 22 && rejected(1e-4) == 0);
        assert_eq!(tests[0].blocks, size.0.div_ceil(8) * size.1.div_ceil(8));
    }
}

#[test]
fn z_test_rejects_two_percent_more_or_less_light() {
    for (runs, size) in [(1, (64, 48)), (1, (61, 53)), (4, (64, 48)), (16, (61, 53))] {
        for gain in [1.02, 0.98] {
            let tests = z_tests(runs, 20, size, gain);
            let min_surprise = tests.iter().map(super::z_test::ZTest::surprise).fold(f64::INFINITY, f64::min);
            // The image's z is 10 with one run and 14 with many: 6 deviations above the limit.
            println!("{runs} runs, {size:?}: surprise at least {min_surprise:.1}, z {:.1}", tests[0].z_image);
            assert!(min_surprise > 4.0, "{min_surprise}");
            assert!(tests.iter().all(|test| (test.z_image > 0.0) == (gain > 1.0)));
        }
    }
}

#[test]
fn z_test_detects_a_block_that_differs() {
    let expected = pixels(64, 64, |_| DVec3::ONE);
    let mut noise = Noise(5);
    let (reference, mut image) = (noise.sample(&expected, 0.05), noise.sample(&expected, 0.1));
    let before = z_test(std::slice::from_ref(&image), &reference).unwrap();
    for y in 24..32 {
        image.mean.values[y * 64 + 40..][..8].iter_mut().for_each(|value| value.y += 0.2);
    }
    let after = z_test(std::slice::from_ref(&image), &reference).unwrap();
    // The difference is 0.2, the deviation sqrt(0.01 + 0.0025) / 8.
    assert!((after.largest - 0.2 * 8.0 / 0.0125_f64.sqrt()).abs() < 4.0, "{after:?}");
    assert!(before.surprise() < 3.0 && after.surprise() > 20.0);
}

#[test]
fn z_test_requires_known_noise_of_both_images() {
    let known = Noise(6).sample(&constant(1.0), 0.1);
    let unknown = Estimate { variance: None, ..known.clone() };
    let one = |run: &Estimate, reference: &Estimate| z_test(std::slice::from_ref(run), reference);
    assert_eq!(one(&known, &unknown), Err(NoValue::NoReferenceNoise));
    assert_eq!(one(&unknown, &known), Err(NoValue::NoImageNoise));
    assert!(z_test(&[unknown.clone(), unknown], &known).is_ok());
    let mut wrong = known.clone();
    wrong.variance.as_mut().unwrap().values[3].y = -1.0;
    assert_eq!(one(&known, &wrong), Err(NoValue::BadVariance));

    // Blocks without noise are tested only if they differ.
    let silent =
        |value: f64| Estimate { mean: constant(value), variance: Some(constant(0.0)), caustics: None };
    let test = one(&silent(1.0), &silent(1.0)).unwrap();
    assert_eq!((test.blocks, test.probability), (0, 1.0));
    let test = one(&silent(1.001), &silent(1.0)).unwrap();
    assert!(test.surprise() > 100.0);
}

#[test]
fn reports_hold_every_metric_once_and_in_order() {
    let mut noise = Noise(7);
    let expected = pixels(20, 18, |i| DVec3::splat(1.0 + (i % 5) as f64));
    let (reference, image) = (noise.sample(&expected, 0.05), noise.sample(&expected, 0.1));
    let reference = Estimate { caustics: Some(expected.clone()), ..reference };
    let runs = [image.clone(), noise.sample(&expected, 0.1)];
    let full = MetricReport::new(&runs, &reference, &Viewing::default());
    let names: Vec<_> = full.values.iter().map(|(metric, _)| metric.name).collect();
    assert_eq!(names, METRICS.iter().map(|metric| metric.name).collect::<Vec<_>>());
    assert!(full.values.iter().all(|(_, value)| value.is_ok()), "{:?}", full.values);
    let get = |name: &str| full.get(name).unwrap();
    for metric in ["mse", "relmse"] {
        let parts = ["bias2", "variance", "reference"].map(|part| get(&format!("{metric}_{part}")));
        assert!(close(parts.iter().sum(), get(metric)), "{metric}");
    }
    assert_eq!(full.map.unwrap().values.len(), 20 * 18);

    // A missing value has a reason.
    let blind = Estimate { variance: None, ..reference.clone() };
    let lonely = MetricReport::new(&[Estimate { variance: None, ..image }], &blind, &Viewing::default());
    for name in
        ["relmse_bias2", "relmse_variance", "mse_bias2", "mse_reference", "z_image", "energy_standard_error"]
    {
        assert!(lonely.get(name).unwrap_err().to_string().contains("variance"), "{name}");
    }
    assert!(lonely.get("relmse").is_ok());
    let display = Viewing { encoding: Encoding::Srgb, ..Viewing::default() };
    assert!(
        MetricReport::new(&runs, &reference, &display)
            .get("flip_hdr")
            .unwrap_err()
            .to_string()
            .contains("EXR")
    );
    let black = Estimate { mean: expected.map(|_| DVec3::ZERO), ..Estimate::default() };
    let black = MetricReport::new(&runs, &black, &Viewing::default());
    for name in ["flip_hdr", "relmse", "relmse_p999", "relmse_bias2", "energy_ratio"] {
        assert!(black.get(name).is_err(), "{name}");
    }
    assert!(black.get("mse").is_ok() && black.get("smape").unwrap() == 1.0);
}

#[test]
fn no_metric_has_a_value_if_a_pixel_is_not_finite() {
    let good = Noise(8).sample(&constant(1.0), 0.1);
    for value in [f64::NAN, f64::INFINITY] {
        let mut bad = good.clone();
        bad.mean.values[4].z = value;
        bad.mean.values[9].x = value;
        for (image, reference) in [(&bad, &good), (&good, &bad)] {
            let report = MetricReport::new(std::slice::from_ref(image), reference, &Viewing::default());
            assert_eq!(report.values.len(), METRICS.len());
            for (metric, value) in &report.values {
                assert_eq!(*value, Err(NoValue::NonFinite(2)), "{}", metric.name);
            }
        }
    }
}

#[test]
fn errors_outside_the_caustic_region_do_not_count() {
    // Caustics are half of the light in every second column, and a tenth in the others.
    let mean = constant(2.0);
    let caustics = pixels(9, 5, |i| DVec3::splat(if i % 9 % 2 == 0 { 1.0 } else { 0.2 }));
    let reference = Estimate { mean, caustics: Some(caustics), variance: None };
    let report_for = |wrong: usize| {
        let mean = pixels(9, 5, |i| DVec3::splat(if i % 9 % 2 == wrong { 3.0 } else { 2.0 }));
        MetricReport::new(&[Estimate { mean, ..Estimate::default() }], &reference, &Viewing::default())
    };
    let expected = 1.0 / (4.0 + 0.2 * 0.2);
    for name in ["relmse_caustic_region", "relmse_trimmed_caustic_region"] {
        assert!(
            close(report_for(0).get(name).unwrap(), expected),
            "{name}: all pixels of the region are wrong"
        );
        assert_eq!(report_for(1).get(name), Ok(0.0), "{name}: the errors are outside of the region");
    }
    let flip = |wrong| {
        report_for(wrong).get("flip_ldr_caustic_region").unwrap() / report_for(wrong).get("flip_ldr").unwrap()
    };
    assert!(flip(0) > 1.0 && flip(1) < 1.0, "FLIP of the region is larger only if the region is wrong");
    for caustics in [None, Some(constant(0.3))] {
        let reference = Estimate { caustics, ..reference.clone() };
        let report = MetricReport::new(std::slice::from_ref(&reference), &reference, &Viewing::default());
        for name in ["flip_ldr_caustic_region", "relmse_caustic_region", "relmse_trimmed_caustic_region"] {
            assert_eq!(report.get(name), Err(NoValue::NoCausticRegion), "{name}");
        }
    }
}
