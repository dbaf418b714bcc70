//! A SPIR-V module that a device can run, and a module of each of its entry points alone.

use std::sync::Arc;

use rspirv::dr::Module as Source;
use rspirv::spirv::Capability;

use super::context::Context;
use super::error::VulkanError;
use super::extract::extract;
use super::reflection::{EntryPoint, Reflection, load};

/// A SPIR-V module for a device.
pub struct Module {
    reflection: Reflection,
    source: Source,
    pub(super) context: Arc<Context>,
}

impl Module {
    /// Reads a module; `name` stands in errors.
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

    /// The entry point of a pass.
    pub fn entry_point(&self, pass: &str) -> Option<&EntryPoint> {
        self.reflection.entry_points.get(pass)
    }

    /// Names of the passes.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.reflection.entry_points.keys().map(String::as_str)
    }

    /// Words of a module of an entry point alone.
    pub(super) fn words(&self, entry: &EntryPoint) -> Vec<u32> {
        extract(&self.source, &entry.symbol).unwrap_or_default()
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
