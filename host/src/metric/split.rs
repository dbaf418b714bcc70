//! Split of a weighted squared error into bias and variance.
//!
//! Let x_i be n runs of one estimator, m their mean and s^2 their variance, and r a reference of variance v. Then
//! `mean (x_i - r)^2 = bias^2 + variance of a run + v`.
//! The equation holds exactly for the unbiased estimates `s^2` of the variance and `(m - r)^2 - s^2 / n - v` of bias^2. A
//! negative estimate of bias^2 means that the bias is below the noise.

use glam::DVec3;

use super::comparison::{Better, Comparison, Metric, MetricValue, NoValue};
use super::pixels::{Estimate, Pixels, mean_of};
use super::relmse;

/// Squared bias in the relative mean squared error.
pub static RELMSE_BIAS2: Metric = Metric {
    name: "relmse_bias2",
    description: "Squared bias in the relative mean squared error",
    unit: "1",
    better: Better::Lower,
    limitations: "it may be negative: then the bias is lost in noise; without a variance of the reference it holds that too",
    compute: |comparison| Ok(relative(comparison)?.bias2),
};

/// Variance of one run in the relative mean squared error.
pub static RELMSE_VARIANCE: Metric = Metric {
    name: "relmse_variance",
    description: "Variance of one run in the relative mean squared error",
    unit: "1",
    better: Better::Lower,
    limitations: "of few runs it is itself uncertain",
    compute: |comparison| Ok(relative(comparison)?.variance),
};

/// Variance of the reference in the relative mean squared error.
pub static RELMSE_REFERENCE: Metric = Metric {
    name: "relmse_reference",
    description: "Variance of the reference in the relative mean squared error",
    unit: "1",
    better: Better::Lower,
    limitations: "it says how good the reference is, not the image",
    compute: |comparison| reference_variance(comparison, relative(comparison)?),
};

/// Squared bias in the mean squared error.
pub static MSE_BIAS2: Metric = Metric {
    name: "mse_bias2",
    description: "Squared bias in the mean squared error",
    unit: "unit^2",
    better: Better::Lower,
    limitations: "it may be negative: then the bias is lost in noise; without a variance of the reference it holds that too",
    compute: |comparison| Ok(absolute(comparison)?.bias2),
};

/// Variance of one run in the mean squared error.
pub static MSE_VARIANCE: Metric = Metric {
    name: "mse_variance",
    description: "Variance of one run in the mean squared error",
    unit: "unit^2",
    better: Better::Lower,
    limitations: "of few runs it is itself uncertain",
    compute: |comparison| Ok(absolute(comparison)?.variance),
};

/// Variance of the reference in the mean squared error.
pub static MSE_REFERENCE: Metric = Metric {
    name: "mse_reference",
    description: "Variance of the reference in the mean squared error",
    unit: "unit^2",
    better: Better::Lower,
    limitations: "it says how good the reference is, not the image",
    compute: |comparison| reference_variance(comparison, absolute(comparison)?),
};

/// Split of relative errors, computed once per comparison.
struct Relative(Option<Split>);

/// Split of absolute errors, computed once per comparison.
struct Absolute(Option<Split>);

fn relative(comparison: &Comparison<'_>) -> Result<Split, NoValue> {
    let eps = relmse::min_square(&comparison.reference.mean);
    let split = comparison.shared(|Comparison { runs, reference, .. }| {
        Relative(split(runs, reference, |b| DVec3::ONE / (b * b + eps)))
    });
    let split = split.0.ok_or(NoValue::NoImageNoise)?;
    if eps > 0.0 { Ok(split) } else { Err(NoValue::BlackReference) }
}

fn absolute(comparison: &Comparison<'_>) -> Result<Split, NoValue> {
    let split = comparison
        .shared(|Comparison { runs, reference, .. }| Absolute(split(runs, reference, |_| DVec3::ONE)));
    split.0.ok_or(NoValue::NoImageNoise)
}

fn reference_variance(comparison: &Comparison<'_>, split: Split) -> MetricValue {
    match comparison.reference.variance {
        Some(_) => Ok(split.reference_variance),
        None => Err(NoValue::NoSplitReference),
    }
}

/// Parts of a squared error, averaged over pixels and channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// Squared bias.
    pub bias2: f64,
    /// Variance of one run.
    pub variance: f64,
    /// Variance of the reference. If it is unknown, it is 0 here and part of `bias2`.
    pub reference_variance: f64,
}

/// Splits the mean of `weight(reference) * (x - reference)^2`. `None` if the image's noise is unknown: it takes two runs or
/// a variance layer.
pub fn split(runs: &[Estimate], reference: &Estimate, weight: impl Fn(DVec3) -> DVec3) -> Option<Split> {
    let mean = mean_of(runs);
    let of_mean = variance_of_mean(runs, &mean)?;
    let count = 3.0 * mean.values.len() as f64;
    let (mut bias2, mut variance, mut reference_variance) = (0.0, 0.0, 0.0);
    for (pixel, &expected) in reference.mean.values.iter().enumerate() {
        let weight = weight(expected);
        let noise = reference.variance.as_ref().map_or(DVec3::ZERO, |variance| variance.values[pixel]);
        let difference = mean.values[pixel] - expected;
        bias2 += weight.dot(difference * difference - of_mean.values[pixel] - noise);
        variance += weight.dot(of_mean.values[pixel]) * runs.len() as f64;
        reference_variance += weight.dot(noise);
    }
    Some(Split {
        bias2: bias2 / count,
        variance: variance / count,
        reference_variance: reference_variance / count,
    })
}

/// Returns the variance of the mean of runs, pixel by pixel. It comes from the runs if there are several, else from the
/// variance layer.
fn variance_of_mean(runs: &[Estimate], mean: &Pixels) -> Option<Pixels> {
    if let [run] = runs {
        return run.variance.clone();
    }
    let mut variance = mean.map(|_| DVec3::ZERO);
    for run in runs {
        let pairs = run.mean.values.iter().zip(&mean.values);
        variance.values.iter_mut().zip(pairs).for_each(|(sum, (x, m))| *sum += (*x - *m) * (*x - *m));
    }
    let scale = 1.0 / ((runs.len() - 1) * runs.len()) as f64;
    variance.values.iter_mut().for_each(|value| *value *= scale);
    Some(variance)
}
