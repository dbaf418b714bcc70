//! Passes: entry points of the loaded modules, compiled on first use. Compiled pipelines belong to the process, and runners
//! on the same device share them.

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

/// Options for opening a device, with its kernels.
#[derive(Clone, Debug, Default)]
pub struct DeviceOptions {
    /// Index of the device or a part of its name; `None` selects the best one.
    pub device: Option<String>,
    /// Whether to trace by ray queries. If not, the device is opened without the feature.
    pub hardware: bool,
    /// Whether the validation layer is on, so that its messages make calls fail.
    pub validation: bool,
    /// SPIR-V module without ray queries.
    pub base: Vec<u32>,
    /// SPIR-V module with ray queries. If `hardware` is set, its entry points take precedence over those of `base`.
    pub rayquery: Option<Vec<u32>>,
}

/// Device with its kernels, which are compiled on first use.
pub struct Kernels {
    // Fields drop in order: objects of the device stand before it.
    // Compiled pipelines by pass and features.
    pipelines: Mutex<HashMap<(&'static str, u32), Arc<Pipeline>>>,
    cache: PipelineCache,
    // Modules in the order of search.
    modules: Vec<Module>,
    context: Arc<Context>,
}

impl Kernels {
    /// Opens the device of these options, or returns the process's own if one was opened with the same options and is not
    /// lost.
    /// Other kernels of the same device are released once no runner uses them, so that a process may exchange kernels any
    /// number of times.
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

    /// Returns the device.
    pub fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// Returns the pipelines of these passes, and compiles missing ones in parallel.
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

/// Passes of a runner, each bound to its buffers.
pub struct Passes {
    bound: HashMap<&'static str, BoundPipeline>,
    features: Features,
    kernels: Arc<Kernels>,
}

impl Passes {
    /// Passes of a device, specialised for the features of a scene.
    pub fn new(kernels: Arc<Kernels>, features: Features) -> Passes {
        Passes { bound: HashMap::new(), features, kernels }
    }

    /// Binds new passes among these to `resources`, which must outlive their dispatches.
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

    /// Returns a prepared pass.
    pub fn get(&self, pass: &str) -> Result<&BoundPipeline, VulkanError> {
        self.bound.get(pass).ok_or_else(|| self.kernels.unknown(pass))
    }
}
