//! Compute pipelines: entry points compiled for the features of a scene.

use std::ffi::CString;
use std::sync::Arc;

use ash::vk;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::Dispatch;

use super::context::Context;
use super::error::VulkanError;
use super::module::Module;
use super::reflection::{BindingKind, EntryPoint};

pub use caustics_kernels::interface::frame::INVOCATIONS_PER_ROW;

/// Compiled entry point.
pub struct Pipeline {
    pub(super) raw: vk::Pipeline,
    pub(super) layout: vk::PipelineLayout,
    pub(super) set_layout: vk::DescriptorSetLayout,
    pub(super) entry: EntryPoint,
    pub(super) context: Arc<Context>,
}

impl Pipeline {
    /// Compiles an entry point for the features of a scene.
    pub(super) fn new(
        module: &Module,
        entry: &EntryPoint,
        features: Features,
        cache: vk::PipelineCache,
        flags: vk::PipelineCreateFlags,
    ) -> Result<Pipeline, VulkanError> {
        let context = Arc::clone(&module.context);
        check(entry, &context)?;
        // On an error below, drop destroys the objects created so far.
        let mut pipeline = Pipeline {
            raw: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            entry: entry.clone(),
            context,
        };
        pipeline.create_layout()?;
        let shader = Shader::new(&pipeline.context, &entry.name, &module.words(entry))?;
        pipeline.create_pipeline(&shader, features, cache, flags)?;
        Ok(pipeline)
    }

    fn create_layout(&mut self) -> Result<(), VulkanError> {
        let entry = &self.entry;
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

    fn create_pipeline(
        &mut self,
        shader: &Shader,
        features: Features,
        cache: vk::PipelineCache,
        flags: vk::PipelineCreateFlags,
    ) -> Result<(), VulkanError> {
        let (device, entry) = (&self.context.raw, &self.entry);
        // Constant 0 holds the features, constant 1 the index of the pass in a shared entry point. Entry points ignore
        // constants that they lack.
        let constants = [features.0, entry.pass_index];
        let constant = |id: u32| {
            vk::SpecializationMapEntry::default().constant_id(id).offset(4 * id).size(size_of::<u32>())
        };
        let entries = [constant(0), constant(1)];
        let specialization =
            vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::bytes_of(&constants));
        let name = CString::new(entry.symbol.as_str()).map_err(|_| VulkanError::Module {
            name: entry.name.clone(),
            reason: "its name holds a zero byte".into(),
        })?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(shader.raw)
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
        // SAFETY: the device does not run it; null handles are ignored.
        unsafe {
            device.destroy_pipeline(self.raw, None);
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

/// Shader module with a single entry point, from which a pipeline is created.
struct Shader {
    raw: vk::ShaderModule,
    context: Arc<Context>,
}

impl Shader {
    fn new(context: &Arc<Context>, name: &str, words: &[u32]) -> Result<Shader, VulkanError> {
        let info = vk::ShaderModuleCreateInfo::default().code(words);
        // SAFETY: the words were assembled from a module that parses, and the device has every capability.
        let raw = unsafe { context.raw.create_shader_module(&info, None) }
            .map_err(VulkanError::call("vkCreateShaderModule"))?;
        context.labels.name(raw, name);
        Ok(Shader { raw, context: Arc::clone(context) })
    }
}

impl Drop for Shader {
    fn drop(&mut self) {
        // SAFETY: no pipeline is being created of it.
        unsafe { self.context.raw.destroy_shader_module(self.raw, None) };
    }
}

fn check(entry: &EntryPoint, context: &Context) -> Result<(), VulkanError> {
    let limits = &context.candidate.properties.limits;
    let buffers = entry.bindings.iter().filter(|b| b.kind == BindingKind::Buffer).count();
    let max_buffers = limits.max_per_stage_descriptor_storage_buffers as usize;
    let (size, bytes) = (entry.workgroup_size, entry.push_constant_bytes);
    let widest = limits.max_compute_work_group_size[0].min(limits.max_compute_work_group_invocations);
    let reason = if buffers > max_buffers {
        format!("it binds {buffers} buffers, but the device allows {max_buffers}")
    } else if bytes as usize > size_of::<Dispatch>() {
        format!("its {bytes} bytes of push constants are more than Dispatch has")
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

pub(super) fn descriptor_type(kind: BindingKind) -> vk::DescriptorType {
    match kind {
        BindingKind::Buffer => vk::DescriptorType::STORAGE_BUFFER,
        BindingKind::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
        BindingKind::Structure => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
    }
}
