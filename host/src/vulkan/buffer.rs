//! Buffers, mapped where the host sees the device's memory, else staged.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::AllocationError;
use gpu_allocator::vulkan::Allocation;

use super::error::VulkanError;
use super::frame::Frame;
use super::memory::{Memory, Purpose};

/// Largest piece that goes through a staging buffer at once (bytes).
const STAGING_BYTES: u64 = 64 << 20;

/// A buffer with its memory. No method may be called while the device works on it; [`Frame::execute`] waits.
pub struct Buffer {
    pub(super) raw: vk::Buffer,
    pub(super) name: String,
    pub(super) bytes: u64,
    pub(super) size: u64,
    pub(super) allocation: Option<Allocation>,
    pub(super) memory: Arc<Memory>,
}

impl Buffer {
    /// Name of the buffer.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Size that was asked for (bytes); behind it lies padding.
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

    /// Overwrites the buffer from an offset on (bytes).
    pub fn write(&mut self, frame: &mut Frame, offset: u64, bytes: &[u8]) -> Result<(), VulkanError> {
        if offset.saturating_add(bytes.len() as u64) > self.bytes {
            let (buffer, bytes) = (self.name.clone(), offset.saturating_add(bytes.len() as u64));
            return Err(VulkanError::Overflow { buffer, bytes, capacity: self.bytes });
        }
        match self.mapped(vk::MemoryPropertyFlags::HOST_COHERENT) {
            Some(memory) => {
                memory[offset as usize..][..bytes.len()].copy_from_slice(bytes);
                Ok(())
            }
            None => self.write_staged(frame, offset, bytes),
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

    fn write_staged(&self, frame: &mut Frame, start: u64, bytes: &[u8]) -> Result<(), VulkanError> {
        let mut staging = self.staging(Purpose::Upload)?;
        for (index, piece) in bytes.chunks(STAGING_BYTES as usize).enumerate() {
            staging.mapped_or_fail()?[..piece.len()].copy_from_slice(piece);
            let (offset, length) = (start + index as u64 * STAGING_BYTES, piece.len() as u64);
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

#[cfg(test)]
mod tests {
    use super::super::context::Context;
    use super::super::test_module;
    use super::*;

    #[test]
    fn staging_carries_every_piece() {
        let context = match Context::new(None, false, false) {
            Ok(context) => Arc::new(context),
            Err(error) => return test_module::skip(&error),
        };
        let memory = Memory::new(Arc::clone(&context)).unwrap();
        let mut frame = Frame::new(&context).unwrap();
        let bytes: Vec<u8> = (0..STAGING_BYTES + 1001).map(|i| (i % 251) as u8).collect();
        let mut buffer = memory.buffer("large", bytes.len() as u64, Purpose::Data).unwrap();
        buffer.write_staged(&mut frame, 0, &bytes).unwrap();
        assert!(buffer.read(&mut frame).unwrap() == bytes);
        assert!(buffer.read_staged(&mut frame).unwrap() == bytes);
    }
}
