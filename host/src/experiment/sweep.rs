//! Sweeps: a matrix of cells over scenes, each measured once for time and error, its result a file.

pub mod accuracy;
pub mod config;
pub mod equal_time;
pub mod expand;
pub mod merge;
pub mod shard;
pub mod value;
