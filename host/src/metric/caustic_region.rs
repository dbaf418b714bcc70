//! Caustic region: the pixels in which caustics are at least a fifth of the reference's luminance. The metrics here are
//! errors of all light in this region.
//! Caustics are often a small part of an image. Over the whole image, a method without caustics may look good.

use super::comparison::{Better, Comparison, Metric, MetricValue, NoValue};
use super::flip::color::luminance;
use super::pixels::{Estimate, Pixels};
use super::{flip_ldr, relmse};

/// FLIP at one exposure over the caustic region.
pub static FLIP_LDR_CAUSTIC_REGION: Metric = Metric {
    name: "flip_ldr_caustic_region",
    description: "Perceived difference at one exposure, mean over the caustic region",
    unit: "1",
    better: Better::Lower,
    limitations: "caustics outside of the reference's caustics do not count",
    compute: |comparison| {
        let map = flip_ldr::map(comparison);
        let region = region(comparison)?;
        map.0.as_ref().map(|map| region.mean(&map.values)).ok_or(NoValue::NoImage)
    },
};

/// Relative mean squared error over the caustic region.
pub static RELMSE_CAUSTIC_REGION: Metric = Metric {
    name: "relmse_caustic_region",
    description: "Relative mean squared error over the caustic region",
    unit: "1",
    better: Better::Lower,
    limitations: "caustics outside of the reference's caustics do not count; one firefly can be most of it",
    compute: |comparison| errors(comparison, relmse::relmse),
};

/// Relative mean squared error over the caustic region, without its worst 0.1 % of the pixels.
pub static RELMSE_TRIMMED_CAUSTIC_REGION: Metric = Metric {
    name: "relmse_trimmed_caustic_region",
    description: "Relative mean squared error over the caustic region, without its worst 0.1 % of the pixels",
    unit: "1",
    better: Better::Lower,
    limitations: "caustics outside of the reference's caustics do not count; fireflies are left out",
    compute: |comparison| errors(comparison, relmse::trimmed),
};

/// Minimum part of a pixel's luminance that caustics have in the region.
const MIN_PART: f64 = 0.2;

/// Pixels with a large part of caustics.
#[derive(Clone, Debug, PartialEq)]
pub struct CausticRegion {
    pixels: Vec<usize>,
}

impl CausticRegion {
    /// Returns the region of an image from its caustics; `None` if it has no pixels.
    pub fn new(whole: &Pixels, caustics: &Pixels) -> Option<CausticRegion> {
        let pairs = whole.values.iter().zip(&caustics.values).enumerate();
        let is_in = |light: f64, caustics: f64| caustics > 0.0 && caustics >= MIN_PART * light;
        let pixels = pairs
            .filter(|(_, (whole, caustics))| is_in(luminance(**whole), luminance(**caustics)))
            .map(|(pixel, _)| pixel)
            .collect::<Vec<_>>();
        (!pixels.is_empty()).then_some(CausticRegion { pixels })
    }

    /// Selects an image's values in the region.
    pub fn pick(&self, values: &[f64]) -> Vec<f64> {
        self.pixels.iter().map(|&pixel| values[pixel]).collect()
    }

    /// Returns the mean of an image's values over the region.
    pub fn mean(&self, values: &[f64]) -> f64 {
        self.pick(values).iter().sum::<f64>() / self.pixels.len() as f64
    }
}

/// Returns the caustic region of a comparison's reference.
fn region(comparison: &Comparison<'_>) -> Result<CausticRegion, NoValue> {
    let region = comparison.shared(|Comparison { reference, .. }| {
        let caustics = reference.caustics.as_ref();
        caustics.and_then(|caustics| CausticRegion::new(&reference.mean, caustics))
    });
    (*region).clone().ok_or(NoValue::NoCausticRegion)
}

/// Returns the mean over runs of an average of the relative squared errors in the region.
fn errors(comparison: &Comparison<'_>, mean: fn(&[f64]) -> f64) -> MetricValue {
    let region = region(comparison)?;
    let reference = &comparison.reference.mean;
    let of_run = |run: &Estimate| mean(&region.pick(&relmse::errors(&run.mean, reference)));
    Ok(comparison.runs.iter().map(of_run).sum::<f64>() / comparison.runs.len() as f64)
}
