//! Sweeps: a matrix of run configurations over scenes, each measured once for time and error, its result a file.

pub mod config;
pub mod equal_time;
mod errors;
pub mod expand;
pub mod matrix_table;
pub mod merge;
pub mod task;
mod turns;
pub mod value;
