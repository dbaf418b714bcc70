//! Errors of running steps.

use caustics_kernels::declare::BufferError;

use crate::vulkan::VulkanError;

/// Error of a runner.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The Vulkan device fails, or a request to it is invalid.
    #[error("{0}")]
    Vulkan(#[from] VulkanError),
    /// A buffer of the CPU runner is missing or too small.
    #[error("{0}")]
    Buffer(#[from] BufferError),
    /// A pass on the CPU binds a missing buffer.
    #[error("pass {pass}")]
    Pass {
        /// Name of the step.
        pass: String,
        /// Error of the buffer.
        source: BufferError,
    },
    /// The caller stopped the frame.
    #[error("the frame was stopped")]
    Stopped,
    /// The CPU has no ray queries.
    #[error("{step} needs ray queries")]
    RayQueries {
        /// Name of the step.
        step: String,
    },
}
