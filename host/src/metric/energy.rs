//! Energy ratio: sum of the image over sum of the reference over all channels, without a unit.

use glam::DVec3;

use super::comparison::{Better, Comparison, Metric, NoValue};
use super::pixels::{Estimate, Pixels, mean_of};

/// Sum of the image over the sum of the reference.
pub static ENERGY_RATIO: Metric = Metric {
    name: "energy_ratio",
    description: "Sum of the image over the sum of the reference",
    unit: "1",
    better: Better::NearOne,
    limitations: "errors of opposite sign cancel",
    compute: |comparison| Ok(shared_energy(comparison).ratio),
};

/// Distance of the energy ratio from 1.
pub static ENERGY_ERROR: Metric = Metric {
    name: "energy_error",
    description: "Distance of the energy ratio from 1",
    unit: "1",
    better: Better::Lower,
    limitations: "errors of opposite sign cancel",
    compute: |comparison| Ok((shared_energy(comparison).ratio - 1.0).abs()),
};

/// Standard error of the energy ratio.
pub static ENERGY_STANDARD_ERROR: Metric = Metric {
    name: "energy_standard_error",
    description: "Standard error of the energy ratio",
    unit: "1",
    better: Better::Lower,
    limitations: "pixels of a variance layer are taken as independent",
    compute: |comparison| shared_energy(comparison).standard_error.ok_or(NoValue::NoNoise),
};

fn shared_energy(comparison: &Comparison<'_>) -> EnergyRatio {
    *comparison.shared(|Comparison { runs, reference, .. }| energy(runs, reference))
}

/// Energy ratio and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyRatio {
    /// Sum of the image (mean of its runs) over sum of the reference; not finite for a black reference.
    pub ratio: f64,
    /// Standard error of the ratio; `None` unless the noise of both images is known.
    pub standard_error: Option<f64>,
}

/// Returns the energy ratio. The image's noise comes from the differences between its runs, or else from its variance
/// layer. The reference's noise comes from its variance layer.
/// For variance layers, channels count as fully correlated and pixels as independent.
pub fn energy(runs: &[Estimate], reference: &Estimate) -> EnergyRatio {
    let sum = |pixels: &Pixels| pixels.values.iter().sum::<DVec3>().element_sum();
    let variance_of_sum = |variance: &Pixels| {
        let sum = variance.values.iter().sum::<DVec3>();
        sum.to_array().into_iter().map(f64::sqrt).sum::<f64>().powi(2)
    };
    let (image, expected) = (sum(&mean_of(runs)), sum(&reference.mean));
    let ratio = image / expected;
    let of_image = if runs.len() > 1 {
        let squares = runs.iter().map(|run| (sum(&run.mean) - image).powi(2)).sum::<f64>();
        Some(squares / ((runs.len() - 1) * runs.len()) as f64)
    } else {
        runs[0].variance.as_ref().map(variance_of_sum)
    };
    let of_reference = reference.variance.as_ref().map(variance_of_sum);
    let standard_error =
        of_image.zip(of_reference).map(|(a, b)| ((a + ratio * ratio * b) / (expected * expected)).sqrt());
    EnergyRatio { ratio, standard_error }
}
