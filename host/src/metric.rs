//! Distances between images, all in f64. May import `image_file` only.
//!
//! An image here is one layer of a file, cut to a region. A metric is data ([`comparison::Metric`]) beside its formula.
//! [`report::MetricReport`] computes all of [`METRICS`].
//!
//! A new metric is a file with its formula and a `pub static` [`comparison::Metric`], and a line in the list below.
//! `caustics compare` then has it in its table, its JSON and its option `--fail-above`.
//! Values that several metrics need are computed once through [`comparison::Comparison::shared`].

pub mod comparison;
pub mod error_map;
pub mod flip;
pub mod percentile;
pub mod pixels;
pub mod report;

/// Declares a module a line and the metrics in it.
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
