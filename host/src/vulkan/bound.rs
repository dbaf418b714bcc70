//! Pipeline with its single descriptor set. Buffers are bound by name.

use std::collections::HashMap;
use std::sync::Arc;

use ash::vk;

use super::buffer::Buffer;
use super::error::VulkanError;
use super::pipeline::{Pipeline, descriptor_type};
use super::reflection::{Binding, BindingKind};
use super::structure::Hierarchy;

/// Resources that entry points can bind, by name.
pub struct Resources {
    /// Placeholder buffer, for a shared entry point whose pass lacks buffers of the other passes.
    pub nothing: Buffer,
    /// Named buffers.
    pub buffers: HashMap<&'static str, Buffer>,
    /// Named acceleration structures.
    pub structures: HashMap<&'static str, Hierarchy>,
}

/// Pass that is ready for dispatch.
pub struct BoundPipeline {
    pub(super) pipeline: Arc<Pipeline>,
    pub(super) set: vk::DescriptorSet,
    pool: vk::DescriptorPool,
}

impl BoundPipeline {
    /// Binds resources to a pipeline. The resources must outlive its dispatches.
    pub(super) fn new(pipeline: Arc<Pipeline>, resources: &Resources) -> Result<BoundPipeline, VulkanError> {
        // On an error below, drop destroys the objects created so far.
        let mut bound =
            BoundPipeline { pipeline, set: vk::DescriptorSet::null(), pool: vk::DescriptorPool::null() };
        bound.create_set()?;
        bound.bind(resources)?;
        Ok(bound)
    }

    fn create_set(&mut self) -> Result<(), VulkanError> {
        // A pool must not be empty: add one descriptor of each kind.
        let count = self.pipeline.entry.bindings.len() as u32 + 1;
        let mut sizes = vec![pool_size(BindingKind::Buffer, count), pool_size(BindingKind::Uniform, count)];
        if self.pipeline.context.is_hardware() {
            sizes.push(pool_size(BindingKind::Structure, count));
        }
        let pool_info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        let device = &self.pipeline.context.raw;
        // SAFETY: kinds of descriptors are known to the device; the pool has room for the set.
        unsafe {
            self.pool = device
                .create_descriptor_pool(&pool_info, None)
                .map_err(VulkanError::call("vkCreateDescriptorPool"))?;
            let layouts = [self.pipeline.set_layout];
            let info =
                vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.pool).set_layouts(&layouts);
            self.set = device
                .allocate_descriptor_sets(&info)
                .map_err(VulkanError::call("vkAllocateDescriptorSets"))?[0];
        }
        Ok(())
    }

    fn bind(&self, resources: &Resources) -> Result<(), VulkanError> {
        let entry = &self.pipeline.entry;
        for binding in &entry.bindings {
            let unbound =
                || VulkanError::UnboundName { pass: entry.name.clone(), buffer: binding.name.clone() };
            let name = binding.name.as_str();
            match binding.kind {
                BindingKind::Buffer | BindingKind::Uniform => {
                    let others = entry.is_joint().then_some(&resources.nothing);
                    let buffer = resources.buffers.get(name).or(others).ok_or_else(unbound)?;
                    self.bind_buffer(binding, buffer);
                }
                BindingKind::Structure => {
                    self.bind_structure(binding, resources.structures.get(name).ok_or_else(unbound)?);
                }
            }
        }
        Ok(())
    }

    fn bind_buffer(&self, binding: &Binding, buffer: &Buffer) {
        let info =
            [vk::DescriptorBufferInfo::default().buffer(buffer.raw).offset(0).range(buffer.bound_bytes())];
        let write = self.write(binding).buffer_info(&info);
        // SAFETY: the set is not in use and the buffer alive.
        unsafe { self.pipeline.context.raw.update_descriptor_sets(&[write], &[]) };
    }

    fn bind_structure(&self, binding: &Binding, structure: &Hierarchy) {
        let structures = [structure.top()];
        let mut info =
            vk::WriteDescriptorSetAccelerationStructureKHR::default().acceleration_structures(&structures);
        let write = self.write(binding).descriptor_count(1).push_next(&mut info);
        // SAFETY: the set is not in use and the structure alive.
        unsafe { self.pipeline.context.raw.update_descriptor_sets(&[write], &[]) };
    }

    fn write(&self, binding: &Binding) -> vk::WriteDescriptorSet<'_> {
        vk::WriteDescriptorSet::default()
            .dst_set(self.set)
            .dst_binding(binding.binding)
            .descriptor_type(descriptor_type(binding.kind))
    }
}

impl Drop for BoundPipeline {
    fn drop(&mut self) {
        // SAFETY: the device does not run it; a null handle is ignored; the pool frees the set.
        unsafe { self.pipeline.context.raw.destroy_descriptor_pool(self.pool, None) };
    }
}

fn pool_size(kind: BindingKind, count: u32) -> vk::DescriptorPoolSize {
    vk::DescriptorPoolSize::default().ty(descriptor_type(kind)).descriptor_count(count)
}
