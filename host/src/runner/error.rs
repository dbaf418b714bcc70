//! What can go wrong while steps run.

use caustics_kernels::declare::BufferError;

use crate::vulkan::VulkanError;

/// Why a runner cannot do what it is told.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The device, or what is asked of it.
    #[error("{0}")]
    Vulkan(#[from] VulkanError),
    /// A buffer of the CPU is not there or too small.
    #[error("{0}")]
    Buffer(#[from] BufferError),
    /// A pass on the CPU does not find what it binds.
    #[error("pass {pass}")]
    Pass {
        /// The step.
        pass: String,
        /// What it does not find.
        source: BufferError,
    },
    /// Somebody no longer wants the frame.
    #[error("the frame was stopped")]
    Stopped,
    /// The CPU has no ray queries.
    #[error("{step} needs ray queries")]
    RayQueries {
        /// The step.
        step: String,
    },
}
