//! Distances between pictures, all in f64. May import `image` only.
//!
//! A picture here is what one layer of a file holds, cut to a region. A metric is data ([`comparison::Metric`]) beside its
//! formula, and [`report::MetricReport`] computes all of [`report::METRICS`].
//!
//! To add one, write a file with its formula and a `pub static` of what it is called, what it measures, where its value
//! misleads and how it is computed from a [`comparison::Comparison`], and name it in [`report::METRICS`]. It is then in the
//! table and the JSON of `caustics compare`, and an option `--fail-above` knows it. What several metrics are made of is
//! computed once through [`comparison::Comparison::shared`].

pub mod comparison;
pub mod energy;
pub mod error_map;
pub mod flip;
pub mod flip_hdr;
pub mod flip_ldr;
pub mod mse;
pub mod percentile;
pub mod pixels;
pub mod relmse;
pub mod report;
pub mod smape;
pub mod split;
pub mod z_test;

#[cfg(test)]
mod tests;
