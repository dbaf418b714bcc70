//! Every metric of an image, or of several runs of it, against a reference.

use std::collections::BTreeMap;

use super::comparison::{Comparison, Metric, MetricValue, NoValue, Viewing};
use super::error_map::ErrorMap;
use super::pixels::Estimate;
use super::{METRICS, flip_hdr, flip_ldr, z_test};
use caustics_files::image_file::Encoding;

/// The metric of a name.
pub fn metric(name: &str) -> Option<&'static Metric> {
    METRICS.iter().find(|metric| metric.name == name).copied()
}

/// All metrics of one comparison.
#[derive(Clone, Debug)]
pub struct MetricReport {
    /// Value of each of [`METRICS`], in their order.
    pub values: Vec<(&'static Metric, MetricValue)>,
    /// Blocks that the z-test compared, if there is a test.
    pub z_blocks: Option<usize>,
    /// FLIP's map: `flip_hdr` of scene-linear images, else `flip_ldr`; the mean over runs.
    pub map: Option<ErrorMap>,
}

impl MetricReport {
    /// Computes all metrics of at least one run against a reference of the same size. All but the energy ratio and the
    /// z-test are those of one run; of several runs the mean is given. Where pixels are not finite no metric has a value.
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

    /// The value of a metric.
    ///
    /// # Errors
    ///
    /// If it has none; the error says why.
    pub fn get(&self, name: &str) -> MetricValue {
        let found = self.values.iter().find(|(metric, _)| metric.name == name);
        found.map_or_else(|| Err(NoValue::Unknown(name.into())), |(_, value)| value.clone())
    }

    /// Values by name, as JSON holds them; `None` for a metric without one.
    pub fn by_name(&self) -> BTreeMap<&'static str, Option<f64>> {
        self.values.iter().map(|(metric, value)| (metric.name, value.as_ref().ok().copied())).collect()
    }

    /// Why metrics have no value, by name, as JSON holds it.
    pub fn unavailable(&self) -> BTreeMap<&'static str, String> {
        let reasons = self.values.iter();
        reasons.filter_map(|(metric, value)| Some((metric.name, value.as_ref().err()?.to_string()))).collect()
    }
}
