//! Devices: their capabilities, whether they are usable, and the choice among them.

use std::ffi::{CStr, FromBytesUntilNulError};

use ash::{khr, vk};
use serde::Serialize;

use super::error::VulkanError;
use super::instance::Instance;

/// Kind of a device, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DeviceKind {
    /// Graphics card.
    Discrete,
    /// GPU inside of the processor.
    Integrated,
    /// GPU of a virtual machine.
    Virtual,
    /// Any other device.
    Other,
    /// Driver that computes on the processor.
    Cpu,
}

/// Description of a Vulkan device and its capabilities.
#[derive(Clone, Debug, Serialize)]
pub struct DeviceInfo {
    /// Position in the loader's list.
    pub index: usize,
    /// Name of the device.
    pub name: String,
    /// Name and version of the driver.
    pub driver: String,
    /// Kind of the device.
    pub kind: DeviceKind,
    /// Vulkan version of the device, as `1.3.280`.
    pub api_version: String,
    /// Whether the device can run `base.spv`.
    pub usable: bool,
    /// Whether the device has ray queries for `rayquery.spv`.
    pub ray_queries: bool,
    /// Features and limits that the device lacks for `base.spv`.
    pub missing: Vec<&'static str>,
    /// Extensions and features that the device lacks for ray queries.
    pub missing_ray_queries: Vec<&'static str>,
    /// Maximum size of a buffer that a kernel can bind (bytes).
    pub max_storage_buffer_bytes: u64,
    /// Whether the device has timestamps for timing passes.
    pub timestamps: bool,
}

impl DeviceInfo {
    /// Whether the driver computes on the processor. The CPU runner is faster then.
    pub fn is_cpu(&self) -> bool {
        self.kind == DeviceKind::Cpu
    }

    /// Whether the device can run `base.spv`, and with `hardware` also `rayquery.spv`.
    pub fn suits(&self, hardware: bool) -> bool {
        self.usable && (self.ray_queries || !hardware)
    }
}

/// Returns every Vulkan device of this machine in the loader's order.
///
/// # Errors
///
/// If there is no loader or driver.
pub fn devices() -> Result<Vec<DeviceInfo>, VulkanError> {
    let instance = Instance::new(false)?;
    Ok(candidates(&instance).into_iter().map(|candidate| candidate.info).collect())
}

/// Returns the device that would be opened for `base.spv`: the device of this index or with this text in its name, or else
/// the best.
pub fn best(wanted: Option<&str>) -> Result<DeviceInfo, VulkanError> {
    let instance = Instance::new(false)?;
    Ok(select(candidates(&instance), wanted, false)?.info)
}

/// Device with the data for opening it.
pub(super) struct Candidate {
    pub(super) physical: vk::PhysicalDevice,
    pub(super) info: DeviceInfo,
    pub(super) properties: vk::PhysicalDeviceProperties,
    /// Queue family for compute.
    pub(super) family: u32,
    /// Valid bits of a timestamp; 0 without timestamps.
    pub(super) timestamp_bits: u32,
    /// Whether kernels may use 64-bit integers.
    pub(super) int64: bool,
    /// Whether the device has VK_KHR_pipeline_executable_properties, which gives statistics of compiled pipelines.
    pub(super) executables: bool,
    /// Maximum number of primitives of a bottom-level structure; 0 without ray queries.
    pub(super) max_primitives: u64,
    /// Alignment of scratch addresses (bytes).
    pub(super) scratch_alignment: u64,
}

/// Returns every device of an instance.
pub(super) fn candidates(instance: &Instance) -> Vec<Candidate> {
    instance.physical_devices.iter().enumerate().map(|(index, &d)| inspect(instance, d, index)).collect()
}

/// Selects the device of this index or with this text in its name, or else the best kind. Fails if the device is
/// unsuitable.
pub(super) fn select(
    mut candidates: Vec<Candidate>,
    wanted: Option<&str>,
    hardware: bool,
) -> Result<Candidate, VulkanError> {
    let found = describe(&candidates);
    let index = wanted.and_then(|text| text.parse().ok()).filter(|&index: &usize| index < candidates.len());
    let text = wanted.unwrap_or_default().to_lowercase();
    candidates.retain(|c| match index {
        Some(index) => c.info.index == index,
        None => c.info.name.to_lowercase().contains(&text),
    });
    candidates.sort_by_key(|c| (!c.info.suits(hardware), c.info.kind, c.info.index));
    let Some(best) = candidates.into_iter().next() else {
        let wanted = wanted.map_or("at all".into(), |text| format!("matches --device `{text}`"));
        return Err(VulkanError::NoDevice { wanted, found });
    };

    let info = &best.info;
    if info.suits(hardware) {
        return Ok(best);
    }
    let (missing, advice) = if info.usable {
        (&info.missing_ray_queries, "use --tracer software, or another device (`caustics device` lists them)")
    } else {
        (&info.missing, "use --runner cpu, or another device (`caustics device` lists them)")
    };
    Err(VulkanError::Unsuitable { name: info.name.clone(), missing: missing.join(", "), advice })
}

fn describe(candidates: &[Candidate]) -> String {
    let names: Vec<_> = candidates.iter().map(|c| format!("{} `{}`", c.info.index, c.info.name)).collect();
    if names.is_empty() { "none".into() } else { names.join(", ") }
}

fn inspect(instance: &Instance, physical: vk::PhysicalDevice, index: usize) -> Candidate {
    let raw = &instance.raw;
    // SAFETY: the physical device is of this instance.
    let (extensions, families, properties) = unsafe {
        (
            raw.enumerate_device_extension_properties(physical).unwrap_or_default(),
            raw.get_physical_device_queue_family_properties(physical),
            raw.get_physical_device_properties(physical),
        )
    };
    let has = |name| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
    let modern = properties.api_version >= vk::API_VERSION_1_2;
    let structures = modern && has(khr::acceleration_structure::NAME);
    let queries = modern && has(khr::ray_query::NAME);
    let executables = modern && has(khr::pipeline_executable_properties::NAME);

    // Query features and properties only of supported extensions.
    let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut structure = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default();
    let mut query = vk::PhysicalDeviceRayQueryFeaturesKHR::default();
    let mut executable = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default();
    let mut features = vk::PhysicalDeviceFeatures2::default();
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut structure_limits = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
    let mut limits = vk::PhysicalDeviceProperties2::default();
    if modern {
        features = features.push_next(&mut vulkan12);
        limits = limits.push_next(&mut driver);
    }
    if structures {
        features = features.push_next(&mut structure);
        limits = limits.push_next(&mut structure_limits);
    }
    if queries {
        features = features.push_next(&mut query);
    }
    if executables {
        features = features.push_next(&mut executable);
    }
    if modern {
        // SAFETY: the device is of version 1.2 or later, and the chained structures live.
        unsafe {
            raw.get_physical_device_features2(physical, &mut features);
            raw.get_physical_device_properties2(physical, &mut limits);
        }
    }
    let int64 = features.features.shader_int64 == vk::TRUE;

    let family = families.iter().position(|f| f.queue_flags.contains(vk::QueueFlags::COMPUTE));
    let timestamp_bits = family.map_or(0, |family| families[family].timestamp_valid_bits);
    let missing = missing(&[
        (modern, "Vulkan 1.2"),
        (vulkan12.scalar_block_layout == vk::TRUE, "scalarBlockLayout"),
        (vulkan12.vulkan_memory_model == vk::TRUE, "vulkanMemoryModel"),
        (vulkan12.vulkan_memory_model_device_scope == vk::TRUE, "vulkanMemoryModelDeviceScope"),
        (family.is_some(), "a compute queue"),
        (properties.limits.max_push_constants_size >= 128, "128 bytes of push constants"),
        (properties.limits.max_compute_work_group_count[0] >= 1 << 15, "32768 workgroups a row"),
    ]);
    let missing_ray_queries = self::missing(&[
        (structures, "VK_KHR_acceleration_structure"),
        (queries, "VK_KHR_ray_query"),
        (has(khr::deferred_host_operations::NAME), "VK_KHR_deferred_host_operations"),
        (vulkan12.buffer_device_address == vk::TRUE, "bufferDeviceAddress"),
        (structure.acceleration_structure == vk::TRUE, "accelerationStructure"),
        (query.ray_query == vk::TRUE, "rayQuery"),
    ]);

    let info = DeviceInfo {
        index,
        name: text(properties.device_name_as_c_str()),
        driver: format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str())),
        kind: kind(properties.device_type),
        api_version: version(properties.api_version),
        usable: missing.is_empty(),
        ray_queries: missing.is_empty() && missing_ray_queries.is_empty(),
        missing,
        missing_ray_queries,
        max_storage_buffer_bytes: u64::from(properties.limits.max_storage_buffer_range),
        timestamps: timestamp_bits > 0,
    };
    Candidate {
        physical,
        info,
        properties,
        family: family.unwrap_or(0) as u32,
        timestamp_bits,
        int64,
        executables: executable.pipeline_executable_info == vk::TRUE,
        max_primitives: structure_limits.max_primitive_count,
        scratch_alignment: u64::from(structure_limits.min_acceleration_structure_scratch_offset_alignment),
    }
}

fn missing(features: &[(bool, &'static str)]) -> Vec<&'static str> {
    features.iter().filter(|(there, _)| !there).map(|&(_, name)| name).collect()
}

fn text(name: Result<&CStr, FromBytesUntilNulError>) -> String {
    name.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

fn kind(device_type: vk::PhysicalDeviceType) -> DeviceKind {
    match device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
        vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
        vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
        vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
        _ => DeviceKind::Other,
    }
}

fn version(version: u32) -> String {
    let (major, minor) = (vk::api_version_major(version), vk::api_version_minor(version));
    format!("{major}.{minor}.{}", vk::api_version_patch(version))
}
