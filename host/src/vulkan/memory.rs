//! Buffers: device-local where they live, mapped or staged where the host touches them.

use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;
use gpu_allocator::vulkan::{
    Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc,
};
use gpu_allocator::{AllocationError, MemoryLocation};

use super::context::Context;
use super::error::VulkanError;
use super::frame::Frame;

/// No buffer is smaller, so that an empty table can be bound [bytes].
const MIN_BYTES: u64 = 256;
/// Largest piece that goes through a staging buffer at once [bytes].
const STAGING_BYTES: u64 = 64 << 20;

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

    fn lock<T>(&self, act: impl FnOnce(&mut Allocator) -> T) -> T {
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
        Purpose::Data | Purpose::Structure | Purpose::Scratch => MemoryLocation::GpuOnly,
        Purpose::Instances | Purpose::Upload => MemoryLocation::CpuToGpu,
        Purpose::Download => MemoryLocation::GpuToCpu,
    }
}

/// A buffer with its memory. No method may be called while the device works on it; [`Frame::execute`] waits.
pub struct Buffer {
    pub(super) raw: vk::Buffer,
    name: String,
    bytes: u64,
    pub(super) size: u64,
    allocation: Option<Allocation>,
    memory: Arc<Memory>,
}

impl Buffer {
    /// Name of the buffer.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Size that was asked for [bytes]; behind it lies padding.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Bytes that kernels see: an empty table has no row of more than 4 bytes.
    pub(super) fn bound_bytes(&self) -> u64 {
        self.bytes.next_multiple_of(4).max(4)
    }

    /// Address on the device, of a buffer with the usage for it.
    pub(super) fn address(&self) -> u64 {
        let info = vk::BufferDeviceAddressInfo::default().buffer(self.raw);
        // SAFETY: the buffer is bound to memory and the device opened with buffer addresses.
        unsafe { self.memory.context.raw.get_buffer_device_address(&info) }
    }

    /// Overwrites the head of the buffer.
    pub fn write(&mut self, frame: &mut Frame, bytes: &[u8]) -> Result<(), VulkanError> {
        if bytes.len() as u64 > self.bytes {
            let (buffer, bytes) = (self.name.clone(), bytes.len() as u64);
            return Err(VulkanError::Overflow { buffer, bytes, capacity: self.bytes });
        }
        match self.mapped(vk::MemoryPropertyFlags::HOST_COHERENT) {
            Some(memory) => {
                memory[..bytes.len()].copy_from_slice(bytes);
                Ok(())
            }
            None => self.write_staged(frame, bytes),
        }
    }

    /// The whole buffer.
    pub fn read(&mut self, frame: &mut Frame) -> Result<Vec<u8>, VulkanError> {
        let length = self.bytes as usize;
        let readable = vk::MemoryPropertyFlags::HOST_COHERENT | vk::MemoryPropertyFlags::HOST_CACHED;
        match self.mapped(readable) {
            Some(memory) => Ok(memory[..length].to_vec()),
            None => self.read_staged(frame),
        }
    }

    fn write_staged(&self, frame: &mut Frame, bytes: &[u8]) -> Result<(), VulkanError> {
        let mut staging = self.staging(Purpose::Upload)?;
        for (index, piece) in bytes.chunks(STAGING_BYTES as usize).enumerate() {
            staging.mapped_or_fail()?[..piece.len()].copy_from_slice(piece);
            let (offset, length) = (index as u64 * STAGING_BYTES, piece.len() as u64);
            frame.execute(&[format!("write.{}", self.name)], |recorder, _| {
                recorder.copy((&staging, 0), (self, offset), length);
            })?;
        }
        Ok(())
    }

    fn read_staged(&self, frame: &mut Frame) -> Result<Vec<u8>, VulkanError> {
        let mut staging = self.staging(Purpose::Download)?;
        let mut bytes = Vec::with_capacity(self.bytes as usize);
        while (bytes.len() as u64) < self.bytes {
            let offset = bytes.len() as u64;
            let length = (self.bytes - offset).min(STAGING_BYTES);
            frame.execute(&[format!("read.{}", self.name)], |recorder, _| {
                recorder.copy((self, offset), (&staging, 0), length);
            })?;
            bytes.extend_from_slice(&staging.mapped_or_fail()?[..length as usize]);
        }
        Ok(bytes)
    }

    fn staging(&self, purpose: Purpose) -> Result<Buffer, VulkanError> {
        self.memory.buffer(&format!("staging.{}", self.name), self.bytes.min(STAGING_BYTES), purpose)
    }

    /// The buffer's memory if the host sees it and it has these properties.
    fn mapped(&mut self, properties: vk::MemoryPropertyFlags) -> Option<&mut [u8]> {
        let allocation = self.allocation.as_mut()?;
        if !allocation.memory_properties().contains(properties) {
            return None;
        }
        allocation.mapped_slice_mut()
    }

    /// The memory of a buffer made to be seen by the host.
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
            // A free that fails means a foreign allocation, which cannot be.
            let _ = self.memory.lock(|allocator| allocator.free(allocation));
        }
    }
}
