//! The passes: entry points of the loaded modules, compiled on first use. What is compiled belongs to the process: runners that
//! open the same device share it.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;
use caustics_kernels::interface::features::Features;
use rayon::prelude::*;

use super::bound::{BoundPipeline, Resources};
use super::cache::PipelineCache;
use super::context::Context;
use super::error::VulkanError;
use super::module::Module;
use super::pipeline::Pipeline;
use super::reflection::EntryPoint;
use caustics_files::hash::Digest;

/// How to open a device, and what runs on it.
#[derive(Clone, Debug, Default)]
pub struct DeviceOptions {
    /// Index of the device or a part of its name; none: the best one there is.
    pub device: Option<String>,
    /// Whether to trace by ray queries. Without, the device is opened without the feature.
    pub hardware: bool,
    /// Whether the validation layer watches and its messages make calls fail.
    pub validation: bool,
    /// SPIR-V that needs no ray queries.
    pub base: Vec<u32>,
    /// SPIR-V that does; its entry points win over those of `base` if `hardware` is set.
    pub rayquery: Option<Vec<u32>>,
}

/// A device with the kernels on it, compiled as they are asked for.
pub struct Kernels {
    // Dropped in order: what was made of the device comes before it.
    // By pass and needs.
    pipelines: Mutex<HashMap<(&'static str, u32), Arc<Pipeline>>>,
    cache: PipelineCache,
    // In the order in which they are searched.
    modules: Vec<Module>,
    context: Arc<Context>,
}

impl Kernels {
    /// The device of these options: that of the process, if one was opened like it and is not lost. Other kernels that were
    /// open for the same device are given back once no runner has them, so that a process may exchange kernels for ever.
    pub fn open(options: &DeviceOptions) -> Result<Arc<Kernels>, VulkanError> {
        static OPEN: Mutex<Vec<([String; 2], Arc<Kernels>)>> = Mutex::new(Vec::new());
        let DeviceOptions { device, hardware, validation, base, rayquery } = options;
        let words = [Some(base), rayquery.as_ref()];
        let modules = Digest::hex(words.into_iter().flatten().map(|words| bytemuck::cast_slice(words)));
        let key = [format!("{device:?} {hardware} {validation}"), modules];
        let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
        open.retain(|(other, kernels)| {
            let is_used = Arc::strong_count(kernels) > 1;
            !kernels.context.is_lost() && (is_used || *other == key || other[0] != key[0])
        });
        if let Some((_, kernels)) = open.iter().find(|(other, _)| *other == key) {
            return Ok(Arc::clone(kernels));
        }
        let kernels = Arc::new(Kernels::new(options)?);
        open.push((key, Arc::clone(&kernels)));
        Ok(kernels)
    }

    fn new(options: &DeviceOptions) -> Result<Kernels, VulkanError> {
        let DeviceOptions { device, hardware, validation, base, rayquery } = options;
        let context = Arc::new(Context::new(device.as_deref(), *hardware, *validation)?);
        let mut modules = Vec::new();
        if let (true, Some(words)) = (*hardware, rayquery) {
            modules.push(Module::new(&context, "rayquery.spv", words)?);
        }
        modules.push(Module::new(&context, "base.spv", base)?);
        let cache = PipelineCache::open(&context)?;
        Ok(Kernels { pipelines: Mutex::default(), cache, modules, context })
    }

    /// The device.
    pub fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// These passes, those that nobody asked for yet compiled side by side.
    fn compiled(
        &self,
        passes: &[&'static str],
        features: Features,
    ) -> Result<Vec<Arc<Pipeline>>, VulkanError> {
        let known = |pass| {
            let pipelines = self.pipelines.lock().unwrap_or_else(PoisonError::into_inner);
            pipelines.get(&(pass, features.0)).map(Arc::clone)
        };
        let found: Vec<_> = passes
            .par_iter()
            .map(|&pass| match known(pass) {
                Some(pipeline) => Ok((pipeline, false)),
                None => {
                    let (module, entry) = self.find(pass)?;
                    let empty = vk::PipelineCreateFlags::empty();
                    let pipeline = Pipeline::new(module, entry, features, self.cache.raw, empty)?;
                    Ok((Arc::new(pipeline), true))
                }
            })
            .collect::<Result<_, VulkanError>>()?;
        if found.iter().any(|(_, is_new)| *is_new) {
            self.cache.save();
        }
        let mut pipelines = self.pipelines.lock().unwrap_or_else(PoisonError::into_inner);
        for (&pass, (pipeline, _)) in passes.iter().zip(&found) {
            pipelines.entry((pass, features.0)).or_insert_with(|| Arc::clone(pipeline));
        }
        Ok(found.into_iter().map(|(pipeline, _)| pipeline).collect())
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

/// The passes of a runner, each bound to its buffers.
pub struct Passes {
    bound: HashMap<&'static str, BoundPipeline>,
    features: Features,
    kernels: Arc<Kernels>,
}

impl Passes {
    /// The passes of a device, specialised for what a scene needs.
    pub fn new(kernels: Arc<Kernels>, features: Features) -> Passes {
        Passes { bound: HashMap::new(), features, kernels }
    }

    /// Binds those of these passes that are new to `resources`, which must outlive their dispatches.
    pub fn prepare(
        &mut self,
        names: impl Iterator<Item = &'static str>,
        resources: &Resources,
    ) -> Result<(), VulkanError> {
        let mut missing: Vec<_> = names.filter(|name| !self.bound.contains_key(name)).collect();
        missing.sort_unstable();
        missing.dedup();
        for (name, pipeline) in missing.iter().zip(self.kernels.compiled(&missing, self.features)?) {
            self.bound.insert(name, BoundPipeline::new(pipeline, resources)?);
        }
        Ok(())
    }

    /// A pass that was prepared.
    pub fn get(&self, pass: &str) -> Result<&BoundPipeline, VulkanError> {
        self.bound.get(pass).ok_or_else(|| self.kernels.unknown(pass))
    }
}
