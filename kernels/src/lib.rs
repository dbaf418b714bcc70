//! The kernels of caustics: one source for SPIR-V (through rust-gpu) and for the CPU.
#![cfg_attr(target_arch = "spirv", no_std)]
#![cfg_attr(feature = "ray-query", feature(asm_experimental_arch))]

// A gather's file is the same inside and outside of this crate.
extern crate self as caustics_kernels;

pub mod declare;
pub mod denoiser;
pub mod emission;
pub mod gather;
pub mod history;
pub mod interface;
pub mod light;
pub mod math;
pub mod method;
pub mod pass;
pub mod seam;
pub mod surface;
pub mod texture;
pub mod trace;
