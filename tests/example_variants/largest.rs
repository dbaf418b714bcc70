//! The largest difference of a channel: an example that shows all that a metric consists of.

use super::comparison::{Better, Metric};
use super::pixels::Pixels;

/// Largest difference of a channel.
pub static LARGEST: Metric = Metric {
    name: "largest",
    description: "Largest difference of a channel: an example",
    unit: "unit",
    better: Better::Lower,
    limitations: "one pixel decides it",
    compute: |comparison| Ok(comparison.mean(largest)),
};

/// The largest difference.
pub fn largest(image: &Pixels, reference: &Pixels) -> f64 {
    let differences = image.values.iter().zip(&reference.values).map(|(a, b)| (*a - *b).abs().max_element());
    differences.fold(0.0, f64::max)
}
