//! Compute pipelines, one an entry point, with their one descriptor set: buffers are bound by name.

use std::collections::HashMap;
use std::ffi::CString;
use std::sync::Arc;

use ash::vk;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::needs::Needs;

use super::buffer::Buffer;
use super::cache::PipelineCache;
use super::context::Context;
use super::error::VulkanError;
use super::module::{Binding, BindingKind, EntryPoint};
use super::passes::Module;
use super::structure::Hierarchy;

pub use caustics_kernels::interface::frame::INVOCATIONS_PER_ROW;

/// What entry points can bind, by name.
pub struct Resources {
    /// Buffers.
    pub buffers: HashMap<&'static str, Buffer>,
    /// Acceleration structures.
    pub structures: HashMap<&'static str, Hierarchy>,
}

/// A pass, ready to be dispatched.
pub struct Pipeline {
    pub(super) raw: vk::Pipeline,
    pub(super) layout: vk::PipelineLayout,
    pub(super) set: vk::DescriptorSet,
    pub(super) workgroup_size: u32,
    pub(super) push_constant_bytes: u32,
    set_layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    context: Arc<Context>,
}

impl Pipeline {
    /// Compiles an entry point for what the scene needs and binds its resources, which must outlive its dispatches.
    pub(super) fn new(
        module: &Module,
        entry: &EntryPoint,
        needs: Needs,
        resources: &Resources,
        cache: &PipelineCache,
    ) -> Result<Pipeline, VulkanError> {
        let mut pipeline =
            Pipeline::compile(module, entry, needs, cache.raw, vk::PipelineCreateFlags::empty())?;
        pipeline.create_set(entry)?;
        pipeline.bind(entry, resources)?;
        Ok(pipeline)
    }

    /// Compiles an entry point for what the scene needs, and binds nothing.
    pub(super) fn compile(
        module: &Module,
        entry: &EntryPoint,
        needs: Needs,
        cache: vk::PipelineCache,
        flags: vk::PipelineCreateFlags,
    ) -> Result<Pipeline, VulkanError> {
        let context = Arc::clone(&module.context);
        check(entry, &context)?;
        // From here on, dropping the pipeline destroys what there is of it.
        let mut pipeline = Pipeline {
            raw: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set: vk::DescriptorSet::null(),
            workgroup_size: entry.workgroup_size,
            push_constant_bytes: entry.push_constant_bytes,
            set_layout: vk::DescriptorSetLayout::null(),
            pool: vk::DescriptorPool::null(),
            context,
        };
        pipeline.create_layout(entry)?;
        pipeline.create_pipeline(module, entry, needs, cache, flags)?;
        Ok(pipeline)
    }

    fn create_layout(&mut self, entry: &EntryPoint) -> Result<(), VulkanError> {
        let bindings: Vec<_> = entry
            .bindings
            .iter()
            .map(|binding| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(binding.binding)
                    .descriptor_type(descriptor_type(binding.kind))
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        let device = &self.context.raw;
        // SAFETY: bindings differ and their kinds are known to the device.
        self.set_layout = unsafe { device.create_descriptor_set_layout(&info, None) }
            .map_err(VulkanError::call("vkCreateDescriptorSetLayout"))?;

        let layouts = [self.set_layout];
        let ranges = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
            .size(entry.push_constant_bytes)];
        let ranges = if entry.push_constant_bytes > 0 { &ranges[..] } else { &[] };
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts).push_constant_ranges(ranges);
        // SAFETY: the set layout is alive.
        self.layout = unsafe { device.create_pipeline_layout(&info, None) }
            .map_err(VulkanError::call("vkCreatePipelineLayout"))?;
        Ok(())
    }

    fn create_set(&mut self, entry: &EntryPoint) -> Result<(), VulkanError> {
        // A pool needs a size even where nothing is bound, hence one more of each.
        let count = entry.bindings.len() as u32 + 1;
        let mut sizes = vec![pool_size(BindingKind::Buffer, count)];
        if self.context.is_hardware() {
            sizes.push(pool_size(BindingKind::Structure, count));
        }
        let pool_info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        let device = &self.context.raw;
        // SAFETY: kinds of descriptors are known to the device; the pool has room for the set.
        unsafe {
            self.pool = device
                .create_descriptor_pool(&pool_info, None)
                .map_err(VulkanError::call("vkCreateDescriptorPool"))?;
            let layouts = [self.set_layout];
            let info =
                vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.pool).set_layouts(&layouts);
            self.set = device
                .allocate_descriptor_sets(&info)
                .map_err(VulkanError::call("vkAllocateDescriptorSets"))?[0];
        }
        Ok(())
    }

    fn bind(&self, entry: &EntryPoint, resources: &Resources) -> Result<(), VulkanError> {
        for binding in &entry.bindings {
            let unbound =
                || VulkanError::UnboundName { pass: entry.name.clone(), buffer: binding.name.clone() };
            let name = binding.name.as_str();
            match binding.kind {
                BindingKind::Buffer => {
                    self.bind_buffer(binding, resources.buffers.get(name).ok_or_else(unbound)?);
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
        unsafe { self.context.raw.update_descriptor_sets(&[write], &[]) };
    }

    fn bind_structure(&self, binding: &Binding, structure: &Hierarchy) {
        let structures = [structure.top()];
        let mut info =
            vk::WriteDescriptorSetAccelerationStructureKHR::default().acceleration_structures(&structures);
        let write = self.write(binding).descriptor_count(1).push_next(&mut info);
        // SAFETY: the set is not in use and the structure alive.
        unsafe { self.context.raw.update_descriptor_sets(&[write], &[]) };
    }

    fn write(&self, binding: &Binding) -> vk::WriteDescriptorSet<'_> {
        vk::WriteDescriptorSet::default()
            .dst_set(self.set)
            .dst_binding(binding.binding)
            .descriptor_type(descriptor_type(binding.kind))
    }

    fn create_pipeline(
        &mut self,
        module: &Module,
        entry: &EntryPoint,
        needs: Needs,
        cache: vk::PipelineCache,
        flags: vk::PipelineCreateFlags,
    ) -> Result<(), VulkanError> {
        let device = &self.context.raw;
        // Constant 0 is the scene's needs; an entry point without it ignores it.
        let constants = needs.0.to_ne_bytes();
        let entries = [vk::SpecializationMapEntry::default().constant_id(0).offset(0).size(constants.len())];
        let specialization = vk::SpecializationInfo::default().map_entries(&entries).data(&constants);
        let name = CString::new(entry.name.as_str()).map_err(|_| VulkanError::Module {
            name: entry.name.clone(),
            reason: "its name holds a zero byte".into(),
        })?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module.raw)
            .name(&name)
            .specialization_info(&specialization);
        let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(self.layout).flags(flags);
        // SAFETY: the entry point is in the module, and the layout has what it binds.
        let pipelines = unsafe { device.create_compute_pipelines(cache, &[info], None) }
            .map_err(|(_, result)| VulkanError::Call { call: "vkCreateComputePipelines", result })?;
        self.raw = pipelines[0];
        self.context.labels.name(self.raw, &entry.name);
        Ok(())
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        let device = &self.context.raw;
        // SAFETY: the device does not run it; null handles are ignored; the pool frees the set.
        unsafe {
            device.destroy_pipeline(self.raw, None);
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_pool(self.pool, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

fn check(entry: &EntryPoint, context: &Context) -> Result<(), VulkanError> {
    let limits = &context.candidate.properties.limits;
    let buffers = entry.bindings.iter().filter(|b| b.kind == BindingKind::Buffer).count();
    let most = limits.max_per_stage_descriptor_storage_buffers as usize;
    let (size, bytes) = (entry.workgroup_size, entry.push_constant_bytes);
    let widest = limits.max_compute_work_group_size[0].min(limits.max_compute_work_group_invocations);
    let reason = if buffers > most {
        format!("it binds {buffers} buffers, but the device allows {most}")
    } else if bytes as usize > size_of::<FrameParams>() {
        format!("its {bytes} bytes of push constants are more than FrameParams has")
    } else if size > widest {
        format!("workgroups of {size} are larger than the device's {widest}")
    } else if !INVOCATIONS_PER_ROW.is_multiple_of(size)
        || INVOCATIONS_PER_ROW / size > limits.max_compute_work_group_count[0]
    {
        format!("workgroups of {size} do not tile a row of {INVOCATIONS_PER_ROW} invocations")
    } else {
        return Ok(());
    };
    Err(VulkanError::Module { name: entry.name.clone(), reason })
}

fn descriptor_type(kind: BindingKind) -> vk::DescriptorType {
    match kind {
        BindingKind::Buffer => vk::DescriptorType::STORAGE_BUFFER,
        BindingKind::Structure => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
    }
}

fn pool_size(kind: BindingKind, count: u32) -> vk::DescriptorPoolSize {
    vk::DescriptorPoolSize::default().ty(descriptor_type(kind)).descriptor_count(count)
}
