//! Errors of the Vulkan runner. Messages name the buffer, the pass or the flag.

use ash::vk;

/// Error of the Vulkan runner.
#[derive(Debug, thiserror::Error)]
pub enum VulkanError {
    /// libvulkan cannot be loaded.
    #[error(
        "no Vulkan loader found ({reason}); install the GPU's driver (Debian: libvulkan1), or use --runner cpu"
    )]
    NoLoader {
        /// Error of the dynamic linker.
        reason: String,
    },
    /// The loader found no driver.
    #[error("no Vulkan driver found ({reason}); install the GPU's driver, or use --runner cpu")]
    NoDriver {
        /// Error of the loader.
        reason: String,
    },
    /// The user requested the validation layer, and it is not installed.
    #[error(
        "--debug validation needs VK_LAYER_KHRONOS_validation, which is not installed; install it (Debian: \
         vulkan-validationlayers) or point VK_LAYER_PATH to its folder"
    )]
    NoValidationLayer,
    /// No device fits the request.
    #[error(
        "no Vulkan device {wanted}; `caustics device` lists them, and --runner cpu needs none; found: {found}"
    )]
    NoDevice {
        /// Description of the request.
        wanted: String,
        /// List of the devices that were found.
        found: String,
    },
    /// The requested device lacks a feature.
    #[error("Vulkan device `{name}` lacks {missing}; {advice}")]
    Unsuitable {
        /// Name of the device.
        name: String,
        /// Missing features and limits.
        missing: String,
        /// Advice for the user.
        advice: &'static str,
    },
    /// A buffer exceeds the size that a kernel can bind.
    #[error(
        "buffer `{buffer}` needs {bytes} bytes, but the device binds at most {limit} (maxStorageBufferRange); \
         lower --width and --height or --light-paths, or use another device"
    )]
    BufferTooLarge {
        /// Name of the buffer.
        buffer: String,
        /// Size of the buffer (bytes).
        bytes: u64,
        /// maxStorageBufferRange (bytes).
        limit: u64,
    },
    /// The memory does not suffice for a buffer.
    #[error("no memory for buffer `{buffer}` of {bytes} bytes ({source}); lower --width and --height")]
    OutOfMemory {
        /// Name of the buffer.
        buffer: String,
        /// Size of the buffer (bytes).
        bytes: u64,
        /// Error of the allocator.
        source: gpu_allocator::AllocationError,
    },
    /// Two buffers have the same name.
    #[error("buffer `{buffer}` is declared twice")]
    DuplicateBuffer {
        /// Name of the buffer.
        buffer: String,
    },
    /// A step or the caller names a buffer that does not exist.
    #[error("there is no buffer `{buffer}`")]
    UnknownBuffer {
        /// Name of the buffer.
        buffer: String,
    },
    /// An entry point binds a name for which there is no buffer.
    #[error("pass `{pass}` binds `{buffer}`, but there is no such buffer")]
    UnboundName {
        /// Name of the pass.
        pass: String,
        /// Name of the binding.
        buffer: String,
    },
    /// More bytes were written than the buffer holds.
    #[error("{bytes} bytes do not fit buffer `{buffer}` of {capacity} bytes")]
    Overflow {
        /// Name of the buffer.
        buffer: String,
        /// Bytes to write.
        bytes: u64,
        /// Size of the buffer (bytes).
        capacity: u64,
    },
    /// A step names a pass for which there is no entry point.
    #[error("no kernel is called `{pass}`; there are: {known}")]
    UnknownPass {
        /// Name of the pass.
        pass: String,
        /// Names of the entry points.
        known: String,
    },
    /// A module or an entry point does not have the expected form.
    #[error("SPIR-V of `{name}`: {reason}; rebuild with `cargo kernels`")]
    Module {
        /// Name of the module or entry point.
        name: String,
        /// Description of the fault.
        reason: String,
    },
    /// An acceleration structure has too many primitives.
    #[error("`{structure}` over {count} primitives, but at most {limit} are possible")]
    TooManyPrimitives {
        /// Name of the structure.
        structure: &'static str,
        /// Requested number of primitives.
        count: u64,
        /// Maximum number of primitives.
        limit: u64,
    },
    /// A step needs ray queries, and the device was opened without them.
    #[error("step `{step}` needs ray queries, but the device was opened without; use --tracer hardware")]
    NotHardware {
        /// Name of the step.
        step: String,
    },
    /// The validation layer reported messages.
    #[error("the validation layer reports {} message(s):\n{}", .0.len(), .0.join("\n"))]
    Validation(
        /// Messages of the layer.
        Vec<String>,
    ),
    /// The device was lost while it ran steps.
    #[error(
        "the device was lost while it ran `{submitted}`, last pass `{last}`; a driver's watchdog ends long frames: \
         lower --light-paths or the image size, or use --runner cpu"
    )]
    DeviceLost {
        /// Name of the last submitted step.
        last: String,
        /// Names of the submitted steps, in order.
        submitted: String,
    },
    /// Another Vulkan call failed.
    #[error("{call} failed: {result}")]
    Call {
        /// Name of the Vulkan function.
        call: &'static str,
        /// Result of the function.
        result: vk::Result,
    },
}

impl VulkanError {
    /// Converts the result of a Vulkan function to an error: `.map_err(VulkanError::call("vkCreateFence"))`.
    pub(super) fn call(call: &'static str) -> impl Fn(vk::Result) -> VulkanError {
        move |result| VulkanError::Call { call, result }
    }

    /// Whether the error is that no suitable device exists (exit code 4).
    pub fn is_no_device(&self) -> bool {
        use VulkanError::{NoDevice, NoDriver, NoLoader, Unsuitable};
        matches!(self, NoLoader { .. } | NoDriver { .. } | NoDevice { .. } | Unsuitable { .. })
    }
}
