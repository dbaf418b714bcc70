//! Transfers between host and device: direct if a buffer's memory is visible to the host, else through a staging buffer.

use ash::vk;

use super::buffer::{Buffer, Purpose};
use super::error::VulkanError;
use super::frame::FrameCommands;

/// Maximum size of a piece in a staging buffer (bytes).
const STAGING_BYTES: u64 = 64 << 20;

impl FrameCommands {
    /// Overwrites a buffer from an offset on (bytes).
    ///
    /// # Errors
    ///
    /// If the bytes do not fit, or the device fails.
    pub fn upload(&mut self, buffer: &mut Buffer, offset: u64, bytes: &[u8]) -> Result<(), VulkanError> {
        let (end, capacity) = (offset.saturating_add(bytes.len() as u64), buffer.bytes);
        if end > capacity {
            return Err(VulkanError::Overflow { buffer: buffer.name.clone(), bytes: end, capacity });
        }
        match buffer.mapped(vk::MemoryPropertyFlags::HOST_COHERENT) {
            Some(memory) => {
                memory[offset as usize..][..bytes.len()].copy_from_slice(bytes);
                Ok(())
            }
            None => self.upload_staged(buffer, offset, bytes),
        }
    }

    /// Returns the bytes of a whole buffer.
    ///
    /// # Errors
    ///
    /// If the device fails.
    pub fn download(&mut self, buffer: &mut Buffer) -> Result<Vec<u8>, VulkanError> {
        let length = buffer.bytes as usize;
        let readable = vk::MemoryPropertyFlags::HOST_COHERENT | vk::MemoryPropertyFlags::HOST_CACHED;
        match buffer.mapped(readable) {
            Some(memory) => Ok(memory[..length].to_vec()),
            None => self.download_staged(buffer),
        }
    }

    fn upload_staged(&mut self, buffer: &Buffer, start: u64, bytes: &[u8]) -> Result<(), VulkanError> {
        let mut staging = staging(buffer, Purpose::Upload)?;
        for (index, piece) in bytes.chunks(STAGING_BYTES as usize).enumerate() {
            staging.mapped_or_fail()?[..piece.len()].copy_from_slice(piece);
            let (offset, length) = (start + index as u64 * STAGING_BYTES, piece.len() as u64);
            self.execute(&[format!("write.{}", buffer.name)], |recorder, _| {
                recorder.copy((&staging, 0), (buffer, offset), length);
            })?;
        }
        Ok(())
    }

    fn download_staged(&mut self, buffer: &Buffer) -> Result<Vec<u8>, VulkanError> {
        let mut staging = staging(buffer, Purpose::Download)?;
        let mut bytes = Vec::with_capacity(buffer.bytes as usize);
        while (bytes.len() as u64) < buffer.bytes {
            let offset = bytes.len() as u64;
            let length = (buffer.bytes - offset).min(STAGING_BYTES);
            self.execute(&[format!("read.{}", buffer.name)], |recorder, _| {
                recorder.copy((buffer, offset), (&staging, 0), length);
            })?;
            bytes.extend_from_slice(&staging.mapped_or_fail()?[..length as usize]);
        }
        Ok(bytes)
    }
}

/// Creates a staging buffer for pieces of another buffer.
fn staging(buffer: &Buffer, purpose: Purpose) -> Result<Buffer, VulkanError> {
    let name = format!("staging.{}", buffer.name);
    Buffer::new(&buffer.memory, &name, buffer.bytes.min(STAGING_BYTES), purpose)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::context::Context;
    use super::super::memory::DeviceAllocator;
    use super::super::test_module;
    use super::*;

    #[test]
    fn staging_transfers_every_piece() {
        let context = match Context::new(None, false, false) {
            Ok(context) => Arc::new(context),
            Err(error) => return test_module::skip(&error),
        };
        let memory = DeviceAllocator::new(Arc::clone(&context)).unwrap();
        let mut frame = FrameCommands::new(&context).unwrap();
        let bytes: Vec<u8> = (0..STAGING_BYTES + 1001).map(|i| (i % 251) as u8).collect();
        let mut buffer = Buffer::new(&memory, "large", bytes.len() as u64, Purpose::Data).unwrap();
        frame.upload_staged(&buffer, 0, &bytes).unwrap();
        assert!(frame.download(&mut buffer).unwrap() == bytes);
        assert!(frame.download_staged(&buffer).unwrap() == bytes);
    }
}
