//! Experiments of `caustics`: scenes rendered in several configurations, and what each costs and how far off it is.
//!
//! `run_config` is a run configuration, `parameter` what can vary of it, `run_parameters` what the parameters say of one,
//! `limits` how large a frame may be, `matrix` all combinations; `plan` says what is measured, `measure` renders the frames
//! of all configurations in turn, `reference` keeps the reference of each frame, `error` has the measures that hold images
//! against it; `record` is a frame of a configuration, `timing`, `cost` and `result` what is left of all of them, `store`
//! and `table` keep and show it. `sweep` does all of it, from a file or from the options of `bench`.

#![cfg_attr(not(test), deny(clippy::print_stderr, clippy::print_stdout))]
#![forbid(unsafe_code)]

pub mod cost;
pub mod error;
#[doc(hidden)]
pub mod fuzzing;
pub mod gain;
pub mod identity;
pub mod limits;
pub mod matrix;
pub mod measure;
pub mod memory;
pub mod parameter;
pub mod plan;
pub mod record;
pub mod reference;
pub mod renamed;
pub mod report;
pub mod result;
pub mod run_config;
pub mod run_parameters;
pub mod store;
pub mod sweep;
pub mod table;
pub mod timing;
