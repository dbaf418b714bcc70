//! Buffers: device-local, or visible to the host where it must access them.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use gpu_allocator::{AllocationError, MemoryLocation};

use super::error::VulkanError;
use super::memory::DeviceAllocator;

/// Minimum size of a buffer, so that an empty table can be bound (bytes).
const MIN_BYTES: u64 = 256;

/// Purpose of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Named buffer of kernels.
    Data,
    /// Parameters of a frame.
    Uniform,
    /// Storage of an acceleration structure.
    Structure,
    /// Scratch of an acceleration structure's build.
    Scratch,
    /// Instances of a top-level structure, written by the host.
    Instances,
    /// Staging of uploads.
    Upload,
    /// Staging of downloads.
    Download,
}

/// Buffer with its memory. The host must not access it while the device works on it.
pub struct Buffer {
    pub(super) raw: vk::Buffer,
    pub(super) name: String,
    pub(super) bytes: u64,
    pub(super) size: u64,
    pub(super) allocation: Option<Allocation>,
    pub(super) memory: Arc<DeviceAllocator>,
}

impl Buffer {
    /// Creates a buffer of undefined content.
    ///
    /// # Errors
    ///
    /// If the buffer is larger than kernels can bind, or the memory is used up.
    pub fn new(
        memory: &Arc<DeviceAllocator>,
        name: &str,
        bytes: u64,
        purpose: Purpose,
    ) -> Result<Buffer, VulkanError> {
        let context = &memory.context;
        let limit = context.info().max_storage_buffer_bytes;
        if purpose == Purpose::Data && bytes > limit {
            return Err(VulkanError::BufferTooLarge { buffer: name.into(), bytes, limit });
        }
        let size = bytes.next_multiple_of(4).max(MIN_BYTES);
        let info = vk::BufferCreateInfo::default().size(size).usage(usage(purpose, context.is_hardware()));
        // SAFETY: the device is alive and the size is not zero.
        let raw =
            unsafe { context.raw.create_buffer(&info, None) }.map_err(VulkanError::call("vkCreateBuffer"))?;
        // On an error below, drop frees what was allocated so far.
        let memory = Arc::clone(memory);
        let mut buffer = Buffer { raw, name: name.into(), bytes, size, allocation: None, memory };
        // SAFETY: the buffer is of this device.
        let mut requirements = unsafe { context.raw.get_buffer_memory_requirements(raw) };
        requirements.alignment = requirements.alignment.max(MIN_BYTES);
        let allocation = buffer
            .memory
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

    /// Name of the buffer.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Requested size (bytes), without padding.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Size that kernels see (bytes). An empty table has 4 bytes, which hold no element of more than 4 bytes.
    pub(super) fn bound_bytes(&self) -> u64 {
        self.bytes.next_multiple_of(4).max(4)
    }

    /// Returns the buffer's address on the device. Its usage must include addresses.
    pub(super) fn address(&self) -> u64 {
        let info = vk::BufferDeviceAddressInfo::default().buffer(self.raw);
        // SAFETY: the buffer is bound to memory and the device opened with buffer addresses.
        unsafe { self.memory.context.raw.get_buffer_device_address(&info) }
    }

    /// Returns the buffer's memory, if it is visible to the host and has these properties.
    pub(super) fn mapped(&mut self, properties: vk::MemoryPropertyFlags) -> Option<&mut [u8]> {
        let allocation = self.allocation.as_mut()?;
        if !allocation.memory_properties().contains(properties) {
            return None;
        }
        allocation.mapped_slice_mut()
    }

    /// Returns the memory of a buffer that was made visible to the host.
    pub(super) fn mapped_or_fail(&mut self) -> Result<&mut [u8], VulkanError> {
        let (buffer, bytes) = (self.name.clone(), self.bytes);
        let source = AllocationError::FailedToMap("the memory is not visible to the host".into());
        self.mapped(vk::MemoryPropertyFlags::HOST_COHERENT).ok_or(VulkanError::OutOfMemory {
            buffer,
            bytes,
            source,
        })
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: the device does not work on it (see the type's contract).
        unsafe { self.memory.context.raw.destroy_buffer(self.raw, None) };
        if let Some(allocation) = self.allocation.take() {
            // Freeing fails only for a foreign allocation, which cannot occur.
            let _ = self.memory.lock(|allocator| allocator.free(allocation));
        }
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
