//! Every metric of an image, or of several runs of it, against a reference.

use glam::DVec3;

use super::energy::energy;
use super::error_map::ErrorMap;
use super::flip::PIXELS_PER_DEGREE;
use super::flip_hdr::flip_hdr;
use super::flip_ldr::flip_ldr;
use super::pixels::{Estimate, Pixels};
use super::split::split;
use super::z_test::{ZTest, z_test};
use super::{mse, percentile, relmse, smape};
use crate::image::Encoding;

/// Names of all metrics, in the order of a report, and their units.
pub const METRICS: [(&str, &str); 20] = [
    ("flip_ldr", "1"),
    ("flip_hdr", "1"),
    ("relmse", "1"),
    ("relmse_trimmed", "1"),
    ("relmse_p999", "1"),
    ("relmse_bias2", "1"),
    ("relmse_variance", "1"),
    ("relmse_reference", "1"),
    ("mse", "unit^2"),
    ("mse_bias2", "unit^2"),
    ("mse_variance", "unit^2"),
    ("mse_reference", "unit^2"),
    ("smape", "1"),
    ("energy_ratio", "1"),
    ("energy_error", "1"),
    ("energy_standard_error", "1"),
    ("z_mean_square", "1"),
    ("z_largest", "1"),
    ("z_picture", "1"),
    ("z_surprise", "1"),
];

/// How the pictures are looked at: encoding, exposure and distance, for FLIP.
#[derive(Clone, Copy, Debug)]
pub struct Viewing {
    /// What the pictures were read from.
    pub encoding: Encoding,
    /// Exposure of scene-linear pictures for `flip_ldr` (stops).
    pub exposure: f64,
    /// Pixels per degree of visual angle.
    pub pixels_per_degree: f64,
}

impl Default for Viewing {
    fn default() -> Viewing {
        Viewing { encoding: Encoding::Linear, exposure: 0.0, pixels_per_degree: PIXELS_PER_DEGREE }
    }
}

/// A metric: its value, or why there is none.
pub type Value = Result<f64, String>;

/// The values of all metrics of one comparison, with the z-test and FLIP's map.
#[derive(Clone, Debug)]
pub struct Report {
    /// Value of each of [`METRICS`], in their order.
    pub values: Vec<(&'static str, Value)>,
    /// The test for equal expectations, if there is one.
    pub z_test: Option<ZTest>,
    /// FLIP's map: `flip_hdr` of scene-linear pictures, else `flip_ldr`; the mean over runs.
    pub map: Option<ErrorMap>,
}

impl Report {
    /// The value of a metric, or why it has none.
    pub fn get(&self, name: &str) -> Value {
        let found = self.values.iter().find(|(known, _)| *known == name);
        found.map_or_else(|| Err(format!("no metric is called {name}")), |(_, value)| value.clone())
    }

    fn set(&mut self, name: &'static str, value: Value) {
        let finite =
            value.and_then(
                |value| {
                    if value.is_finite() { Ok(value) } else { Err(format!("its value is {value}")) }
                },
            );
        self.values.push((name, finite));
    }
}

/// Computes all metrics of at least one run against a reference of the same size. All but the energy ratio and the z-test
/// are means over the runs. If a pixel is NaN or infinite no metric has a value.
pub fn report(runs: &[Estimate], reference: &Estimate, viewing: &Viewing) -> Report {
    let mut report = Report { values: Vec::new(), z_test: None, map: None };
    let bad: usize = runs.iter().chain([reference]).map(|picture| picture.mean.non_finite_count()).sum();
    if bad > 0 {
        let why = format!("{bad} pixels are not finite");
        report.values = METRICS.iter().map(|(name, _)| (*name, Err(why.clone()))).collect();
        return report;
    }
    seen(&mut report, runs, reference, viewing);
    squares(&mut report, runs, reference);
    let mean = |metric: &dyn Fn(&Pixels) -> f64| mean(runs.iter().map(|run| metric(&run.mean)));
    report.set("smape", Ok(mean(&|image| smape::smape(image, &reference.mean))));
    let energy = energy(runs, reference);
    report.set("energy_ratio", Ok(energy.ratio));
    report.set("energy_error", Ok((energy.ratio - 1.0).abs()));
    report.set("energy_standard_error", energy.standard_error.ok_or_else(|| NO_NOISE.into()));
    let test = z_test(runs, reference);
    let value = |value: &dyn Fn(&ZTest) -> f64| test.as_ref().map(value).map_err(ToString::to_string);
    report.set("z_mean_square", value(&|test| test.mean_square));
    report.set("z_largest", value(&|test| test.largest));
    report.set("z_picture", value(&|test| test.picture));
    report.set("z_surprise", value(&ZTest::surprise));
    report.z_test = test.ok();
    report
}

const NO_NOISE: &str =
    "it takes a variance layer of the reference, and several runs or a variance layer of the image";

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// What a person sees.
fn seen(report: &mut Report, runs: &[Estimate], reference: &Estimate, viewing: &Viewing) {
    let ppd = viewing.pixels_per_degree;
    let ldr = |run: &Estimate| flip_ldr(&run.mean, &reference.mean, viewing.encoding, viewing.exposure, ppd);
    let ldr = ErrorMap::mean_of(runs.iter().map(ldr));
    report.set("flip_ldr", ldr.as_ref().map(ErrorMap::mean).ok_or_else(|| "there is no image".into()));
    if viewing.encoding == Encoding::Srgb {
        report.set("flip_hdr", Err("display colours have no high dynamic range; compare EXR files".into()));
        report.map = ldr;
        return;
    }
    // A reference without exposures has none for any run.
    let hdr = runs.iter().map_while(|run| flip_hdr(&run.mean, &reference.mean, ppd));
    report.map = ErrorMap::mean_of(hdr);
    report.set(
        "flip_hdr",
        report.map.as_ref().map(ErrorMap::mean).ok_or_else(|| "the reference is black".into()),
    );
}

/// Squared errors, relative and absolute, and their split.
fn squares(report: &mut Report, runs: &[Estimate], reference: &Estimate) {
    let eps = relmse::least_square(&reference.mean);
    let relative = |value: f64| if eps > 0.0 { Ok(value) } else { Err("the reference is black".to_string()) };
    let of_run = |run: &Estimate| {
        let errors = relmse::errors(&run.mean, &reference.mean);
        let p999 = percentile::percentile(&errors, 1.0 - relmse::TRIMMED);
        DVec3::new(relmse::relmse(&errors), relmse::trimmed(&errors), p999)
    };
    let sum: DVec3 = runs.iter().map(of_run).sum();
    for (name, value) in ["relmse", "relmse_trimmed", "relmse_p999"].into_iter().zip(sum.to_array()) {
        report.set(name, relative(value / runs.len() as f64));
    }
    let split_relative = split(runs, reference, |b| DVec3::ONE / (b * b + eps));
    let split_absolute = split(runs, reference, |_| DVec3::ONE);
    let no_split = || "it takes several runs of the image, or a variance layer of it".to_string();
    let no_reference = || "the reference has no variance layer; bias2 holds its variance too".to_string();
    let known = reference.variance.is_some();
    let part = |split: Option<super::split::Split>| {
        let split = split.ok_or_else(no_split)?;
        Ok::<_, String>((split, if known { Ok(split.reference_variance) } else { Err(no_reference()) }))
    };
    let parts = part(split_relative).and_then(|parts| relative(0.0).map(|_| parts));
    report.set("relmse_bias2", parts.clone().map(|(split, _)| split.bias2));
    report.set("relmse_variance", parts.clone().map(|(split, _)| split.variance));
    report.set("relmse_reference", parts.and_then(|(_, reference)| reference));
    report.set("mse", Ok(mean(runs.iter().map(|run| mse::mse(&run.mean, &reference.mean)))));
    let parts = part(split_absolute);
    report.set("mse_bias2", parts.clone().map(|(split, _)| split.bias2));
    report.set("mse_variance", parts.clone().map(|(split, _)| split.variance));
    report.set("mse_reference", parts.and_then(|(_, reference)| reference));
}
