//! The host of caustics: scenes in, frames through a runner, pictures out.
//!
//! `scene` reads glTF into flat tables, `method` lists the passes of a frame, `runner` executes the list on the
//! CPU or, through `vulkan`, on a GPU, `session` ties them together, `output` writes the picture. See ARCHITECTURE.md.

#![cfg_attr(not(test), deny(clippy::print_stderr, clippy::print_stdout))]
#![deny(unsafe_code)]

pub mod accumulation;
pub mod checkpoint;
pub mod counters;
pub mod energy;
pub mod experiment;
pub mod file;
pub mod frame_memory;
#[doc(hidden)]
pub mod fuzzing;
pub mod hash;
pub mod image;
pub mod kernels;
pub mod memory;
pub mod metric;
pub mod output;
pub mod picture;
pub mod report;
pub mod runner;
pub mod scene;
pub mod sealed;
pub mod session;
pub mod settings;
pub mod text;
pub mod trace_rate;
pub mod upload;
#[allow(unsafe_code)]
pub mod vulkan;
