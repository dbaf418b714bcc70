//! What can go wrong on a Vulkan device, said with the name of the buffer, the pass or the flag.

use ash::vk;

/// An error of the Vulkan runner.
#[derive(Debug, thiserror::Error)]
pub enum VulkanError {
    /// No libvulkan.
    #[error(
        "no Vulkan loader found ({reason}); install the GPU's driver (Debian: libvulkan1), or use --runner cpu"
    )]
    NoLoader {
        /// What the dynamic linker said.
        reason: String,
    },
    /// The loader found no driver.
    #[error("no Vulkan driver found ({reason}); install the GPU's driver, or use --runner cpu")]
    NoDriver {
        /// What the loader said.
        reason: String,
    },
    /// The validation layer was asked for and is absent.
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
        /// What was asked for.
        wanted: String,
        /// Devices there are, and what each lacks.
        found: String,
    },
    /// The device that was asked for lacks something.
    #[error("Vulkan device `{name}` lacks {missing}; {advice}")]
    Unsuitable {
        /// Name of the device.
        name: String,
        /// Features and limits it lacks.
        missing: String,
        /// What to do.
        advice: &'static str,
    },
    /// A buffer is larger than what a kernel can bind.
    #[error(
        "buffer `{buffer}` needs {bytes} bytes, but the device binds at most {limit} (maxStorageBufferRange); \
         lower --width and --height or --light-paths, or use another device"
    )]
    BufferTooLarge {
        /// Name of the buffer.
        buffer: String,
        /// Its size (bytes).
        bytes: u64,
        /// maxStorageBufferRange (bytes).
        limit: u64,
    },
    /// There is no memory for a buffer.
    #[error("no memory for buffer `{buffer}` of {bytes} bytes ({source}); lower --width and --height")]
    OutOfMemory {
        /// Name of the buffer.
        buffer: String,
        /// Its size (bytes).
        bytes: u64,
        /// What the allocator said.
        source: gpu_allocator::AllocationError,
    },
    /// A buffer was named twice.
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
    /// An entry point binds a name that no buffer has.
    #[error("pass `{pass}` binds `{buffer}`, but there is no such buffer")]
    UnboundName {
        /// Name of the pass.
        pass: String,
        /// Name of its parameter.
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
    /// A step names a pass without an entry point.
    #[error("no kernel is called `{pass}`; there are: {known}")]
    UnknownPass {
        /// Name of the pass.
        pass: String,
        /// Names of the entry points.
        known: String,
    },
    /// A module or an entry point is not of the expected form.
    #[error("SPIR-V of `{name}`: {reason}; rebuild with `cargo kernels`")]
    Module {
        /// Module or entry point.
        name: String,
        /// What is wrong.
        reason: String,
    },
    /// An acceleration structure over too many primitives.
    #[error("`{structure}` over {count} primitives, but at most {limit} are possible")]
    TooManyPrimitives {
        /// Name of the structure.
        structure: &'static str,
        /// Primitives asked for.
        count: u64,
        /// Primitives that are possible.
        limit: u64,
    },
    /// A step needs ray queries on a device opened without them.
    #[error("step `{step}` needs ray queries, but the device was opened without; use --tracer hardware")]
    NotHardware {
        /// Name of the step.
        step: String,
    },
    /// The validation layer spoke.
    #[error("the validation layer reports {} message(s):\n{}", .0.len(), .0.join("\n"))]
    Validation(
        /// Its messages.
        Vec<String>,
    ),
    /// The device was lost while it ran steps.
    #[error(
        "the device was lost while it ran `{submitted}`, last pass `{last}`; a driver's watchdog ends long frames: \
         lower --light-paths or the image size, or use --runner cpu"
    )]
    DeviceLost {
        /// Last step submitted.
        last: String,
        /// Steps submitted, in order.
        submitted: String,
    },
    /// Another Vulkan call failed.
    #[error("{call} failed: {result}")]
    Call {
        /// Vulkan function.
        call: &'static str,
        /// Its result.
        result: vk::Result,
    },
}

impl VulkanError {
    /// Turns the result of a Vulkan function into an error: `.map_err(VulkanError::call("vkCreateFence"))`.
    pub(super) fn call(call: &'static str) -> impl Fn(vk::Result) -> VulkanError {
        move |result| VulkanError::Call { call, result }
    }

    /// Whether the reason is that no suitable device exists (exit code 4).
    pub fn is_no_device(&self) -> bool {
        use VulkanError::{NoDevice, NoDriver, NoLoader, Unsuitable};
        matches!(self, NoLoader { .. } | NoDriver { .. } | NoDevice { .. } | Unsuitable { .. })
    }
}
