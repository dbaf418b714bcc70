//! The passes: entry points of the loaded modules, compiled on first use and kept.

use std::collections::HashMap;
use std::sync::Arc;

use ash::vk;
use caustics_kernels::interface::needs::Needs;
use rspirv::spirv::Capability;

use super::cache::PipelineCache;
use super::context::Context;
use super::error::VulkanError;
use super::module::{EntryPoint, Reflection};
use super::pipeline::{Pipeline, Resources};

/// A SPIR-V module on the device.
pub struct Module {
    reflection: Reflection,
    pub(super) raw: vk::ShaderModule,
    pub(super) context: Arc<Context>,
}

impl Module {
    /// Loads a module; `name` stands in errors.
    pub fn new(context: &Arc<Context>, name: &str, words: &[u32]) -> Result<Module, VulkanError> {
        let reflection = Reflection::new(name, words)?;
        let unknown = reflection.capabilities.iter().find(|&&capability| !context.allows(capability));
        if let Some(capability) = unknown {
            let device = &context.info().name;
            let reason = format!("it needs {capability:?}, with which `{device}` was not opened");
            return Err(VulkanError::Module { name: name.into(), reason });
        }
        let info = vk::ShaderModuleCreateInfo::default().code(words);
        // SAFETY: the words parse, and the device has every capability.
        let raw = unsafe { context.raw.create_shader_module(&info, None) }
            .map_err(VulkanError::call("vkCreateShaderModule"))?;
        context.labels.name(raw, name);
        Ok(Module { reflection, raw, context: Arc::clone(context) })
    }

    /// The entry point of a pass.
    pub fn entry_point(&self, pass: &str) -> Option<&EntryPoint> {
        self.reflection.entry_points.get(pass)
    }

    /// Names of the passes.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.reflection.entry_points.keys().map(String::as_str)
    }
}

impl Drop for Module {
    fn drop(&mut self) {
        // SAFETY: no pipeline is being created.
        unsafe { self.context.raw.destroy_shader_module(self.raw, None) };
    }
}

impl Context {
    /// Whether the device was opened with what a capability needs.
    fn allows(&self, capability: Capability) -> bool {
        match capability {
            Capability::Shader
            | Capability::Matrix
            | Capability::VulkanMemoryModel
            | Capability::VulkanMemoryModelDeviceScope => true,
            Capability::Int64 => self.candidate.int64,
            Capability::RayQueryKHR => self.is_hardware(),
            _ => false,
        }
    }
}

/// The passes of a runner.
pub struct Passes {
    modules: Vec<Module>,
    pipelines: HashMap<&'static str, Pipeline>,
    needs: Needs,
    cache: PipelineCache,
}

impl Passes {
    /// The passes of these modules, the earlier winning, specialised for what a scene needs.
    pub fn new(context: &Arc<Context>, modules: Vec<Module>, needs: Needs) -> Result<Passes, VulkanError> {
        Ok(Passes { modules, pipelines: HashMap::new(), needs, cache: PipelineCache::open(context)? })
    }

    /// Compiles those of these passes that are new, each bound to `resources`, which must outlive its dispatches.
    pub fn prepare(
        &mut self,
        names: impl Iterator<Item = &'static str>,
        resources: &Resources,
    ) -> Result<(), VulkanError> {
        let before = self.pipelines.len();
        for pass in names {
            if !self.pipelines.contains_key(pass) {
                let (module, entry) = self.find(pass)?;
                let pipeline = Pipeline::new(module, entry, self.needs, resources, &self.cache)?;
                self.pipelines.insert(pass, pipeline);
            }
        }
        if self.pipelines.len() > before {
            self.cache.save();
        }
        Ok(())
    }

    /// A pass that was prepared.
    pub fn get(&self, pass: &str) -> Result<&Pipeline, VulkanError> {
        self.pipelines.get(pass).ok_or_else(|| self.unknown(pass))
    }

    fn find(&self, pass: &str) -> Result<(&Module, &EntryPoint), VulkanError> {
        let found = self.modules.iter().find_map(|module| Some((module, module.entry_point(pass)?)));
        found.ok_or_else(|| self.unknown(pass))
    }

    fn unknown(&self, pass: &str) -> VulkanError {
        let mut known: Vec<_> = self.modules.iter().flat_map(Module::names).collect();
        known.sort_unstable();
        known.dedup();
        VulkanError::UnknownPass { pass: pass.into(), known: known.join(", ") }
    }
}
