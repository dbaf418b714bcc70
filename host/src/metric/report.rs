//! Report of all metrics of an image, or of several runs of it, against a reference.

use std::collections::BTreeMap;

use super::comparison::{Comparison, Metric, MetricValue, NoValue, Viewing};
use super::error_map::ErrorMap;
use super::pixels::Estimate;
use super::{METRICS, flip_hdr, flip_ldr, z_test};
use caustics_files::image_file::Encoding;

/// Returns the metric of this name.
pub fn metric(name: &str) -> Option<&'static Metric> {
    METRICS.iter().find(|metric| metric.name == name).copied()
}

/// All metrics of one comparison.
#[derive(Clone, Debug)]
pub struct MetricReport {
    /// Value of each of [`METRICS`], in their order.
    pub values: Vec<(&'static Metric, MetricValue)>,
    /// Number of blocks of the z-test; `None` if there is no test.
    pub z_blocks: Option<usize>,
    /// FLIP's error map, averaged over runs: `flip_hdr` for scene-linear images, else `flip_ldr`.
    pub map: Option<ErrorMap>,
}

impl MetricReport {
    /// Computes all metrics of at least one run against a reference of the same size. Metrics are averaged over runs,
    /// except the energy ratio and the z-test. If a pixel is not finite, no metric has a value.
    pub fn new(runs: &[Estimate], reference: &Estimate, viewing: &Viewing) -> MetricReport {
        let comparison = match Comparison::new(runs, reference, *viewing) {
            Ok(comparison) => comparison,
            Err(why) => {
                let values = METRICS.iter().map(|&metric| (metric, Err(why.clone()))).collect();
                return MetricReport { values, z_blocks: None, map: None };
            }
        };
        let value = |metric: &'static Metric| {
            let value = (metric.compute)(&comparison);
            let finite =
                |value: f64| if value.is_finite() { Ok(value) } else { Err(NoValue::Undefined(value)) };
            (metric, value.and_then(finite))
        };
        let map = match viewing.encoding {
            Encoding::Linear => flip_hdr::map(&comparison).0.clone(),
            Encoding::Srgb => flip_ldr::map(&comparison).0.clone(),
        };
        let values = METRICS.iter().copied().map(value).collect();
        MetricReport { values, z_blocks: z_test::blocks(&comparison), map }
    }

    /// Returns the value of a metric.
    ///
    /// # Errors
    ///
    /// If the metric has no value; the error says why.
    pub fn get(&self, name: &str) -> MetricValue {
        let found = self.values.iter().find(|(metric, _)| metric.name == name);
        found.map_or_else(|| Err(NoValue::Unknown(name.into())), |(_, value)| value.clone())
    }

    /// Returns the values by name for JSON; `None` for a metric without a value.
    pub fn by_name(&self) -> BTreeMap<&'static str, Option<f64>> {
        self.values.iter().map(|(metric, value)| (metric.name, value.as_ref().ok().copied())).collect()
    }

    /// Returns the reasons of missing values by name for JSON.
    pub fn unavailable(&self) -> BTreeMap<&'static str, String> {
        let reasons = self.values.iter();
        reasons.filter_map(|(metric, value)| Some((metric.name, value.as_ref().err()?.to_string()))).collect()
    }
}
