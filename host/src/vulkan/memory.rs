//! Allocator of the device's memory for buffers.

use std::sync::{Arc, Mutex, PoisonError};

use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use super::context::Context;
use super::error::VulkanError;

/// Allocator of a device's memory.
pub struct DeviceAllocator {
    // Fields drop in order: free the memory before the device.
    allocator: Mutex<Allocator>,
    pub(super) context: Arc<Context>,
}

impl DeviceAllocator {
    /// Creates the allocator of a device.
    pub fn new(context: Arc<Context>) -> Result<Arc<DeviceAllocator>, VulkanError> {
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: context.instance.raw.clone(),
            device: context.raw.clone(),
            physical_device: context.candidate.physical,
            debug_settings: Default::default(),
            buffer_device_address: context.is_hardware(),
            allocation_sizes: Default::default(),
        })
        .map_err(|source| VulkanError::OutOfMemory { buffer: "any".into(), bytes: 0, source })?;
        Ok(Arc::new(DeviceAllocator { allocator: Mutex::new(allocator), context }))
    }

    /// Calls a function with the locked allocator.
    pub(super) fn lock<T>(&self, act: impl FnOnce(&mut Allocator) -> T) -> T {
        act(&mut self.allocator.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
