//! Distances between images, all in f64. May import `image_file` only.
//!
//! An image here is what one layer of a file holds, cut to a region. A metric is data ([`comparison::Metric`]) beside its
//! formula, and [`report::MetricReport`] computes all of [`METRICS`].
//!
//! To add one, write a file with its formula and a `pub static` of what it is called, what it measures, where its value
//! misleads and how it is computed from a [`comparison::Comparison`], and name both in the list below. It is then in the
//! table and the JSON of `caustics compare`, and an option `--fail-above` knows it. What several metrics are made of is
//! computed once through [`comparison::Comparison::shared`].

pub mod comparison;
pub mod error_map;
pub mod flip;
pub mod percentile;
pub mod pixels;
pub mod report;

/// Declares a file a line, and the metrics that it holds.
macro_rules! metrics {
    ($($file:ident: $($metric:ident)+;)*) => {
        $(pub mod $file;)*

        /// All metrics, in the order of a report.
        pub static METRICS: &[&comparison::Metric] = &[$($(&$file::$metric,)+)*];
    };
}

metrics! {
    flip_ldr: FLIP_LDR;
    flip_hdr: FLIP_HDR;
    relmse: RELMSE RELMSE_TRIMMED RELMSE_P999;
    caustic_region: FLIP_LDR_CAUSTIC_REGION RELMSE_CAUSTIC_REGION RELMSE_TRIMMED_CAUSTIC_REGION;
    split: RELMSE_BIAS2 RELMSE_VARIANCE RELMSE_REFERENCE MSE_BIAS2 MSE_VARIANCE MSE_REFERENCE;
    mse: MSE;
    smape: SMAPE;
    energy: ENERGY_RATIO ENERGY_ERROR ENERGY_STANDARD_ERROR;
    z_test: Z_MEAN_SQUARE Z_LARGEST Z_IMAGE Z_SURPRISE;
}

#[cfg(test)]
mod tests;
