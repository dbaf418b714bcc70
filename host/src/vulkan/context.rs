//! Device opened for compute, with or without ray queries.

use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

use ash::{ext, khr, vk};

use super::debug::{Labels, Messages};
use super::device::{Candidate, DeviceInfo, candidates, select};
use super::error::VulkanError;
use super::instance::Instance;

/// Open device and its compute queue. Every object of the device keeps it alive through an `Arc`.
pub struct Context {
    pub(super) raw: ash::Device,
    /// Queue for one submission at a time, by any runner.
    pub(super) queue: Mutex<vk::Queue>,
    lost: AtomicBool,
    pub(super) candidate: Candidate,
    /// Extension for acceleration structures, on a device opened with ray queries.
    pub(super) structures: Option<khr::acceleration_structure::Device>,
    /// Extension for statistics of compiled pipelines, on a device opened to compile.
    pub(super) executables: Option<khr::pipeline_executable_properties::Device>,
    pub(super) labels: Labels,
    pub(super) instance: Instance,
}

impl Context {
    /// Opens the device of this index or with this text in its name, or else the best one; see [`DeviceInfo::suits`].
    pub fn new(device: Option<&str>, hardware: bool, validation: bool) -> Result<Context, VulkanError> {
        let instance = Instance::new(validation)?;
        let candidate = select(candidates(&instance), device, hardware)?;
        Context::open(instance, candidate, hardware, false)
    }

    /// Opens a device for compiling kernels and reading their statistics, with ray queries if it has them. It uses no
    /// device memory, which drivers without their hardware lack.
    pub fn to_compile(device: Option<&str>) -> Result<Context, VulkanError> {
        let instance = Instance::new(false)?;
        let candidate = select(candidates(&instance), device, false)?;
        let (hardware, asks) = (candidate.info.ray_queries, candidate.executables);
        Context::open(instance, candidate, hardware, asks)
    }

    fn open(
        instance: Instance,
        candidate: Candidate,
        hardware: bool,
        asks: bool,
    ) -> Result<Context, VulkanError> {
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(candidate.family)
            .queue_priorities(&priorities)];
        let features = vk::PhysicalDeviceFeatures::default().shader_int64(candidate.int64);
        let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default()
            .scalar_block_layout(true)
            .vulkan_memory_model(true)
            .vulkan_memory_model_device_scope(true)
            .buffer_device_address(hardware);
        let mut structure =
            vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default().acceleration_structure(true);
        let mut query = vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true);
        let mut executable = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
            .pipeline_executable_info(true);
        let mut extensions = Vec::new();
        let mut info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_features(&features)
            .push_next(&mut vulkan12);
        if hardware {
            extensions.push(khr::acceleration_structure::NAME.as_ptr());
            extensions.push(khr::ray_query::NAME.as_ptr());
            extensions.push(khr::deferred_host_operations::NAME.as_ptr());
            info = info.push_next(&mut structure).push_next(&mut query);
        }
        if asks {
            extensions.push(khr::pipeline_executable_properties::NAME.as_ptr());
            info = info.push_next(&mut executable);
        }
        let info = info.enabled_extension_names(&extensions);

        // SAFETY: the device has what `info` asks for, as `select` checked.
        let raw = unsafe { instance.raw.create_device(candidate.physical, &info, None) }
            .map_err(VulkanError::call("vkCreateDevice"))?;
        // SAFETY: the family has one queue, created above.
        let queue = unsafe { raw.get_device_queue(candidate.family, 0) };
        let structures = hardware.then(|| khr::acceleration_structure::Device::new(&instance.raw, &raw));
        let executables = asks.then(|| khr::pipeline_executable_properties::Device::new(&instance.raw, &raw));
        let labels = Labels(instance.debug_utils.then(|| ext::debug_utils::Device::new(&instance.raw, &raw)));
        let (queue, lost) = (Mutex::new(queue), AtomicBool::new(false));
        Ok(Context { raw, queue, lost, candidate, structures, executables, labels, instance })
    }

    /// Returns the description of the device.
    pub fn info(&self) -> &DeviceInfo {
        &self.candidate.info
    }

    /// Whether the device was opened with ray queries.
    pub fn is_hardware(&self) -> bool {
        self.structures.is_some()
    }

    /// Whether the device was lost. It runs nothing any more then.
    pub fn is_lost(&self) -> bool {
        self.lost.load(Relaxed)
    }

    /// Marks the device as lost.
    pub(super) fn lose(&self) {
        self.lost.store(true, Relaxed);
    }

    /// Returns the messages of the validation layer.
    pub fn messages(&self) -> &Messages {
        &self.instance.messages
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        // SAFETY: every object of the device holds it, so all are gone and the queue is idle.
        unsafe { self.raw.destroy_device(None) };
    }
}
