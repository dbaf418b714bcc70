//! The commands that measure, from outside: benches, sweeps, comparisons and reports.

mod bench;
mod bench_still;
mod compare;
mod experiments;
mod report;
mod sweep;
