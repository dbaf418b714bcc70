//! Mean squared error: mean of (a - b)^2 over pixels and channels, in the squared unit of the layer.

use super::comparison::{Better, Metric};
use super::pixels::Pixels;

/// Mean squared error.
pub static MSE: Metric = Metric {
    name: "mse",
    description: "Mean squared error",
    unit: "unit^2",
    better: Better::Lower,
    limitations: "bright pixels decide it, and it grows with the exposure",
    compute: |comparison| Ok(comparison.mean(mse)),
};

/// Returns the mean squared error.
pub fn mse(image: &Pixels, reference: &Pixels) -> f64 {
    let squares = image.values.iter().zip(&reference.values).map(|(a, b)| (*a - *b).length_squared());
    squares.sum::<f64>() / (3 * image.values.len()) as f64
}
