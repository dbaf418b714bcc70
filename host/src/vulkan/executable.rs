//! Statistics of a device's compiler for an entry point, by VK_KHR_pipeline_executable_properties.

use std::ffi::CStr;
use std::sync::Arc;

use ash::vk;
use caustics_kernels::interface::features::Features;
use serde::{Deserialize, Serialize};

use super::context::Context;
use super::error::VulkanError;
use super::module::Module;
use super::pipeline::Pipeline;

/// Program of a compiled pipeline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Executable {
    /// Name that the driver gives.
    pub name: String,
    /// Number of invocations that run in lockstep.
    pub subgroup_size: u32,
    /// Statistics from the driver.
    pub statistics: Vec<Statistic>,
}

/// Statistic of a program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Statistic {
    /// Name that the driver gives.
    pub name: String,
    /// Value of the statistic.
    pub value: StatisticValue,
}

/// Value of one of Vulkan's types.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum StatisticValue {
    /// Boolean.
    Flag(bool),
    /// Unsigned integer.
    Count(u64),
    /// Signed integer.
    Integer(i64),
    /// Floating-point number.
    Number(f64),
}

/// Compiles the entry point of a pass without a cache and returns its programs. Empty if the device has no statistics.
pub fn compile(module: &Module, pass: &str, features: Features) -> Result<Vec<Executable>, VulkanError> {
    let context = Arc::clone(&module.context);
    let entry = module.entry_point(pass).ok_or_else(|| VulkanError::UnknownPass {
        pass: pass.into(),
        known: module.names().collect::<Vec<_>>().join(", "),
    })?;
    let mut flags = vk::PipelineCreateFlags::empty();
    if context.executables.is_some() {
        flags |= vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR;
    }
    let pipeline = Pipeline::new(module, entry, features, vk::PipelineCache::null(), flags)?;
    executables(&context, pipeline.raw)
}

fn executables(context: &Context, pipeline: vk::Pipeline) -> Result<Vec<Executable>, VulkanError> {
    let Some(extension) = &context.executables else { return Ok(Vec::new()) };
    let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
    // SAFETY: the pipeline is alive, and the feature enabled.
    let programs = unsafe { extension.get_pipeline_executable_properties(&info) }
        .map_err(VulkanError::call("vkGetPipelineExecutablePropertiesKHR"))?;
    let executables = programs.iter().enumerate().map(|(index, program)| {
        let info = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline).executable_index(index as u32);
        // SAFETY: the pipeline was compiled to keep its statistics, and has this executable.
        let statistics = unsafe { extension.get_pipeline_executable_statistics(&info) }
            .map_err(VulkanError::call("vkGetPipelineExecutableStatisticsKHR"))?;
        Ok(Executable {
            name: text(program.name_as_c_str()),
            subgroup_size: program.subgroup_size,
            statistics: statistics.iter().map(statistic).collect(),
        })
    });
    executables.collect()
}

fn statistic(raw: &vk::PipelineExecutableStatisticKHR<'_>) -> Statistic {
    use vk::PipelineExecutableStatisticFormatKHR as Format;
    // SAFETY: the driver wrote the member that the format names.
    let value = unsafe {
        match raw.format {
            Format::BOOL32 => StatisticValue::Flag(raw.value.b32 == vk::TRUE),
            Format::INT64 => StatisticValue::Integer(raw.value.i64),
            Format::FLOAT64 => StatisticValue::Number(raw.value.f64),
            _ => StatisticValue::Count(raw.value.u64),
        }
    };
    Statistic { name: text(raw.name_as_c_str()), value }
}

fn text<E>(name: Result<&CStr, E>) -> String {
    name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vulkan::test_module;

    #[test]
    fn an_entry_point_compiles_without_memory_or_bindings() {
        let context = match Context::to_compile(None) {
            Ok(context) => Arc::new(context),
            Err(error) => return test_module::skip(&error),
        };
        let module = Module::new(&context, "base", &test_module::base()).unwrap();
        let executables = compile(&module, "twice", Features::ALL).unwrap();
        assert_eq!(executables.is_empty(), context.executables.is_none());
        let error = compile(&module, "thrice", Features::ALL).unwrap_err().to_string();
        assert!(error.contains("`thrice`") && error.contains("fill, twice"), "{error}");
    }

    #[test]
    fn values_survive_json() {
        let values = [
            StatisticValue::Flag(true),
            StatisticValue::Count(u64::MAX),
            StatisticValue::Integer(-3),
            StatisticValue::Number(0.5),
        ];
        let json = serde_json::to_string(&values).unwrap();
        assert_eq!(json, "[true,18446744073709551615,-3,0.5]");
        assert_eq!(serde_json::from_str::<[StatisticValue; 4]>(&json).unwrap(), values);
    }
}
