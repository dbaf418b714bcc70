//! Distances between pictures, a file each; all in f64. May import `image` only.
//!
//! A picture here is what one layer of a file holds, cut to a region. [`report`] computes every metric.

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
