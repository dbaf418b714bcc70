//! Sweeps: a matrix of run configurations over scenes. Each is measured once for time and error; its result is a file.

pub mod config;
pub mod equal_time;
mod errors;
pub mod expand;
pub mod matrix_table;
pub mod merge;
pub mod task;
mod turns;
pub mod value;
