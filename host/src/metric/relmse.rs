//! Relative mean squared error: mean of (a - b)^2 / (b^2 + eps) over pixels and channels, without a unit.
//!
//! With eps = (0.1 mean of the reference)^2, scaling both images does not change the metric. [Rousselle et al. 2011] add
//! 0.01, which is the same for images whose mean is 1. The mean includes all pixels.
//! [`trimmed`] leaves out the worst pixels, since one firefly can outweigh all other pixels.

use glam::DVec3;

use super::comparison::{Better, Comparison, Metric, MetricValue, NoValue};
use super::percentile::percentile;
use super::pixels::{Estimate, Pixels};

/// Relative mean squared error.
pub static RELMSE: Metric = Metric {
    name: "relmse",
    description: "Relative mean squared error",
    unit: "1",
    better: Better::Lower,
    limitations: "one firefly can be more than all other pixels together",
    compute: |comparison| means(comparison, |means| means.mean),
};

/// Relative mean squared error without the worst 0.1 % of the pixels.
pub static RELMSE_TRIMMED: Metric = Metric {
    name: "relmse_trimmed",
    description: "Relative mean squared error without the worst 0.1 % of the pixels",
    unit: "1",
    better: Better::Lower,
    limitations: "fireflies are left out",
    compute: |comparison| means(comparison, |means| means.trimmed),
};

/// Relative squared error that 0.1 % of the pixels exceed.
pub static RELMSE_P999: Metric = Metric {
    name: "relmse_p999",
    description: "Relative squared error that 0.1 % of the pixels exceed",
    unit: "1",
    better: Better::Lower,
    limitations: "it says nothing of the other pixels",
    compute: |comparison| means(comparison, |means| means.p999),
};

/// Means over runs.
struct Means {
    mean: f64,
    trimmed: f64,
    p999: f64,
}

/// Returns one of the means. All of them share the errors of the pixels.
fn means(comparison: &Comparison<'_>, pick: fn(&Means) -> f64) -> MetricValue {
    if min_square(&comparison.reference.mean) <= 0.0 {
        return Err(NoValue::BlackReference);
    }
    let means = comparison.shared(|Comparison { runs, reference, .. }| {
        let of_run = |run: &Estimate| {
            let errors = errors(&run.mean, &reference.mean);
            DVec3::new(relmse(&errors), trimmed(&errors), percentile(&errors, 1.0 - TRIMMED))
        };
        let sum: DVec3 = runs.iter().map(of_run).sum();
        let [mean, trimmed, p999] = (sum / runs.len() as f64).to_array();
        Means { mean, trimmed, p999 }
    });
    Ok(pick(&means))
}

/// Part of the pixels that [`trimmed`] leaves out.
pub const TRIMMED: f64 = 0.001;

/// Returns eps, the minimum square that an error is related to; 0 if the reference is black.
pub fn min_square(reference: &Pixels) -> f64 {
    (0.1 * reference.mean()).powi(2)
}

/// Returns the relative squared error of each pixel, averaged over channels.
pub fn errors(image: &Pixels, reference: &Pixels) -> Vec<f64> {
    let eps = DVec3::splat(min_square(reference));
    let pairs = image.values.iter().zip(&reference.values);
    pairs.map(|(&a, &b)| ((a - b) * (a - b) / (b * b + eps)).element_sum() / 3.0).collect()
}

/// Returns the relative mean squared error: the mean of [`errors`].
pub fn relmse(errors: &[f64]) -> f64 {
    errors.iter().sum::<f64>() / errors.len() as f64
}

/// Returns the mean of [`errors`] without the largest 0.1 %. All of fewer than 1000 pixels are kept.
pub fn trimmed(errors: &[f64]) -> f64 {
    let limit = percentile(errors, 1.0 - TRIMMED);
    let (mut kept, mut sum) = (0_usize, 0.0);
    for &error in errors.iter().filter(|error| **error < limit) {
        kept += 1;
        sum += error;
    }
    // Keep as many of the errors that equal the limit as the rank requires.
    let equal = rank(errors.len()) - kept;
    (sum + equal as f64 * limit) / (kept + equal) as f64
}

/// Returns the number of pixels that are kept.
fn rank(count: usize) -> usize {
    count - (count as f64 * TRIMMED) as usize
}
