//! Symmetric mean absolute percentage error: mean of |a - b| / (|a| + |b|) over pixels and channels, no unit; 0 / 0 is 0.
//!
//! As [Vogels et al. 2018] have it, without their constant in the denominator: scaling both images changes nothing. The
//! largest value is 1, the error of a pixel that is black in one image alone.

use super::comparison::{Better, Metric};
use super::pixels::Pixels;

/// Symmetric mean absolute percentage error.
pub static SMAPE: Metric = Metric {
    name: "smape",
    description: "Symmetric mean absolute percentage error",
    unit: "1",
    better: Better::Lower,
    limitations: "an error in the dark counts as much as one in the light",
    compute: |comparison| Ok(comparison.mean(smape)),
};

/// The symmetric mean absolute percentage error.
pub fn smape(image: &Pixels, reference: &Pixels) -> f64 {
    let error = |(a, b): (f64, f64)| if a == b { 0.0 } else { (a - b).abs() / (a.abs() + b.abs()) };
    let pairs = image.values.iter().zip(&reference.values);
    let errors = pairs.map(|(a, b)| a.to_array().into_iter().zip(b.to_array()).map(error).sum::<f64>());
    errors.sum::<f64>() / (3 * image.values.len()) as f64
}
