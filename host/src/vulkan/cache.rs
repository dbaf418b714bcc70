//! The pipeline cache on disk: a second run need not compile its kernels again.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ash::vk;

use super::context::Context;
use super::error::VulkanError;

/// A pipeline cache. Not being able to read or write its file is no error.
pub(super) struct PipelineCache {
    pub(super) raw: vk::PipelineCache,
    path: Option<PathBuf>,
    context: Arc<Context>,
}

impl PipelineCache {
    /// Loads the cache of this device and driver, if there is one.
    pub(super) fn open(context: &Arc<Context>) -> Result<PipelineCache, VulkanError> {
        let properties = &context.candidate.properties;
        let path = folder().map(|folder| folder.join(file_name(properties)));
        let mut data = path.as_ref().and_then(|path| std::fs::read(path).ok()).unwrap_or_default();
        if !is_of_device(&data, properties) {
            data.clear();
        }
        let info = vk::PipelineCacheCreateInfo::default().initial_data(&data);
        // SAFETY: the data was written for this very device and driver.
        let raw = unsafe { context.raw.create_pipeline_cache(&info, None) }
            .map_err(VulkanError::call("vkCreatePipelineCache"))?;
        Ok(PipelineCache { raw, path, context: Arc::clone(context) })
    }

    /// Writes the cache, atomically.
    pub(super) fn save(&self) {
        // SAFETY: the cache is alive.
        let data = unsafe { self.context.raw.get_pipeline_cache_data(self.raw) };
        if let (Some(path), Ok(data)) = (&self.path, data) {
            let _ = write(path, &data);
        }
    }
}

impl Drop for PipelineCache {
    fn drop(&mut self) {
        // SAFETY: no pipeline is being created.
        unsafe { self.context.raw.destroy_pipeline_cache(self.raw, None) };
    }
}

fn folder() -> Option<PathBuf> {
    let set = |name| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let cache = set("XDG_CACHE_HOME").or_else(|| Some(set("HOME")?.join(".cache")))?;
    Some(cache.join("caustics"))
}

fn file_name(properties: &vk::PhysicalDeviceProperties) -> String {
    let uuid: String = properties.pipeline_cache_uuid.iter().map(|byte| format!("{byte:02x}")).collect();
    let (vendor, device) = (properties.vendor_id, properties.device_id);
    format!("pipelines-{vendor:04x}-{device:04x}-{:08x}-{uuid}.bin", properties.driver_version)
}

/// Whether the header (length, version, vendor, device, uuid) is this device's.
fn is_of_device(data: &[u8], properties: &vk::PhysicalDeviceProperties) -> bool {
    let word = |index: usize| {
        data.get(4 * index..4 * index + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    word(2) == Some(properties.vendor_id)
        && word(3) == Some(properties.device_id)
        && data.get(16..32) == Some(&properties.pipeline_cache_uuid[..])
}

fn write(path: &Path, data: &[u8]) -> std::io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(data)?;
    file.persist(path)?;
    Ok(())
}
