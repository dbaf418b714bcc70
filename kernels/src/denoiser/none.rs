//! No filter.

#[cfg(not(target_arch = "spirv"))]
use crate::declare::Denoiser;

/// Smooths nothing.
#[cfg(not(target_arch = "spirv"))]
pub const NONE: Denoiser = Denoiser {
    name: "none",
    description: "no denoiser",
    cost: "nothing",
    limitations: "noise: one path a pixel",
    steps: |_| Vec::new(),
};
