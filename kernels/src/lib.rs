//! The kernels of caustics.
#![cfg_attr(target_arch = "spirv", no_std, feature(asm_experimental_arch))]
pub mod interface;
