//! Experiments of `caustics`: scenes rendered in several run configurations, with the cost and the error of each.
//!
//! | module | contents |
//! |---|---|
//! | `run_config`, `parameter`, `run_parameters` | run configurations, what can vary in them, their names |
//! | `matrix` | all combinations of values |
//! | `limits` | largest frame |
//! | `plan` | what is measured |
//! | `measure` | renders the frames of all configurations in turn |
//! | `reference`, `error` | the reference of each frame, and measures of images against it |
//! | `record`, `timing`, `cost`, `result` | a frame of a configuration, and the summary of all its frames |
//! | `store`, `table` | results on disk, and shown to the user |
//! | `sweep` | a whole experiment, from a file or from the options of `bench` |

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
