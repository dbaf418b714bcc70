//! Symmetric mean absolute percentage error: mean of |a - b| / (|a| + |b|) over pixels and channels, without a unit; 0 / 0
//! is 0.
//!
//! The definition is that of [Vogels et al. 2018] without the constant in the denominator, so that scaling both images does
//! not change it. The maximum is 1, the error of a pixel that is black in one image only.

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

/// Returns the symmetric mean absolute percentage error.
pub fn smape(image: &Pixels, reference: &Pixels) -> f64 {
    let error = |(a, b): (f64, f64)| if a == b { 0.0 } else { (a - b).abs() / (a.abs() + b.abs()) };
    let pairs = image.values.iter().zip(&reference.values);
    let errors = pairs.map(|(a, b)| a.to_array().into_iter().zip(b.to_array()).map(error).sum::<f64>());
    errors.sum::<f64>() / (3 * image.values.len()) as f64
}
