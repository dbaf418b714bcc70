//! The commands that measure, from outside: benches, sweeps, comparisons and reports.

mod bench;
mod compare;
mod experiments;
mod report;
mod sweep;
