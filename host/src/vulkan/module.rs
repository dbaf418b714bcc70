//! SPIR-V module that a device can run, and extraction of its entry points.

use std::sync::Arc;

use rspirv::dr::Module as Source;
use rspirv::spirv::Capability;

use super::context::Context;
use super::error::VulkanError;
use super::extract::extract;
use super::reflection::{EntryPoint, Reflection, load};

/// SPIR-V module of a device.
pub struct Module {
    reflection: Reflection,
    source: Source,
    pub(super) context: Arc<Context>,
}

impl Module {
    /// Reads a module. Errors contain `name`.
    pub fn new(context: &Arc<Context>, name: &str, words: &[u32]) -> Result<Module, VulkanError> {
        let source = load(name, words)?;
        let reflection = Reflection::from_source(name, &source)?;
        let unknown = reflection.capabilities.iter().find(|&&capability| !context.allows(capability));
        if let Some(capability) = unknown {
            let device = &context.info().name;
            let reason = format!("it needs {capability:?}, with which `{device}` was not opened");
            return Err(VulkanError::Module { name: name.into(), reason });
        }
        Ok(Module { reflection, source, context: Arc::clone(context) })
    }

    /// Returns the entry point of a pass.
    pub fn entry_point(&self, pass: &str) -> Option<&EntryPoint> {
        self.reflection.entry_points.get(pass)
    }

    /// Returns the names of the passes.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.reflection.entry_points.keys().map(String::as_str)
    }

    /// Returns the words of a module with only this entry point.
    pub(super) fn words(&self, entry: &EntryPoint) -> Vec<u32> {
        extract(&self.source, &entry.symbol).unwrap_or_default()
    }
}

impl Context {
    /// Whether the device was opened with the features of a capability.
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
