//! The device's memory, and the buffers made of it: device-local, except where the host must see them.

use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc};

use super::buffer::Buffer;
use super::context::Context;
use super::error::VulkanError;

/// No buffer is smaller, so that an empty table can be bound (bytes).
const MIN_BYTES: u64 = 256;

/// The device's memory.
pub struct Memory {
    // Freed before the device: fields drop in order.
    allocator: Mutex<Allocator>,
    pub(super) context: Arc<Context>,
}

/// What a buffer is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A named buffer of kernels.
    Data,
    /// The settings of a frame.
    Uniform,
    /// Storage of an acceleration structure.
    Structure,
    /// Scratch of an acceleration structure's build.
    Scratch,
    /// Instances of a top-level structure, written by the host.
    Instances,
    /// Staging towards the device.
    Upload,
    /// Staging towards the host.
    Download,
}

impl Memory {
    /// The memory of a device.
    pub fn new(context: Arc<Context>) -> Result<Arc<Memory>, VulkanError> {
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: context.instance.raw.clone(),
            device: context.raw.clone(),
            physical_device: context.candidate.physical,
            debug_settings: Default::default(),
            buffer_device_address: context.is_hardware(),
            allocation_sizes: Default::default(),
        })
        .map_err(|source| VulkanError::OutOfMemory { buffer: "any".into(), bytes: 0, source })?;
        Ok(Arc::new(Memory { allocator: Mutex::new(allocator), context }))
    }

    /// A buffer of undefined content. Fails if kernels could not bind the whole of it.
    pub fn buffer(self: &Arc<Self>, name: &str, bytes: u64, purpose: Purpose) -> Result<Buffer, VulkanError> {
        let context = &self.context;
        let limit = context.info().max_storage_buffer_bytes;
        if purpose == Purpose::Data && bytes > limit {
            return Err(VulkanError::BufferTooLarge { buffer: name.into(), bytes, limit });
        }

        let size = bytes.next_multiple_of(4).max(MIN_BYTES);
        let info = vk::BufferCreateInfo::default().size(size).usage(usage(purpose, context.is_hardware()));
        // SAFETY: the device is alive and the size is not zero.
        let raw =
            unsafe { context.raw.create_buffer(&info, None) }.map_err(VulkanError::call("vkCreateBuffer"))?;
        // From here on, dropping the buffer frees what there is of it.
        let memory = Arc::clone(self);
        let mut buffer = Buffer { raw, name: name.into(), bytes, size, allocation: None, memory };

        // SAFETY: the buffer is of this device.
        let mut requirements = unsafe { context.raw.get_buffer_memory_requirements(raw) };
        requirements.alignment = requirements.alignment.max(MIN_BYTES);
        let allocation = self
            .lock(|allocator| {
                allocator.allocate(&AllocationCreateDesc {
                    name,
                    requirements,
                    location: location(purpose),
                    linear: true,
                    allocation_scheme: AllocationScheme::GpuAllocatorManaged,
                })
            })
            .map_err(|source| VulkanError::OutOfMemory { buffer: name.into(), bytes, source })?;
        let allocation = buffer.allocation.insert(allocation);
        // SAFETY: the buffer has no memory yet, and the allocation outlives it.
        unsafe { context.raw.bind_buffer_memory(raw, allocation.memory(), allocation.offset()) }
            .map_err(VulkanError::call("vkBindBufferMemory"))?;
        context.labels.name(raw, name);
        Ok(buffer)
    }

    /// Does something with the allocator.
    pub(super) fn lock<T>(&self, act: impl FnOnce(&mut Allocator) -> T) -> T {
        act(&mut self.allocator.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

fn usage(purpose: Purpose, hardware: bool) -> vk::BufferUsageFlags {
    use vk::BufferUsageFlags as Usage;
    match purpose {
        Purpose::Data => {
            let plain = Usage::STORAGE_BUFFER | Usage::TRANSFER_SRC | Usage::TRANSFER_DST;
            let input =
                Usage::SHADER_DEVICE_ADDRESS | Usage::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR;
            if hardware { plain | input } else { plain }
        }
        Purpose::Uniform => Usage::UNIFORM_BUFFER | Usage::TRANSFER_DST,
        Purpose::Structure => Usage::ACCELERATION_STRUCTURE_STORAGE_KHR | Usage::SHADER_DEVICE_ADDRESS,
        Purpose::Scratch => Usage::STORAGE_BUFFER | Usage::SHADER_DEVICE_ADDRESS,
        Purpose::Instances => {
            Usage::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR | Usage::SHADER_DEVICE_ADDRESS
        }
        Purpose::Upload => Usage::TRANSFER_SRC,
        Purpose::Download => Usage::TRANSFER_DST,
    }
}

fn location(purpose: Purpose) -> MemoryLocation {
    match purpose {
        Purpose::Data | Purpose::Uniform | Purpose::Structure | Purpose::Scratch => MemoryLocation::GpuOnly,
        Purpose::Instances | Purpose::Upload => MemoryLocation::CpuToGpu,
        Purpose::Download => MemoryLocation::GpuToCpu,
    }
}
