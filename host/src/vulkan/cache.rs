//! Pipeline cache on disk, so that a second run need not compile its kernels again.
//!
//! Drivers do not verify the data. Therefore a file ends with its BLAKE3, and a damaged file is ignored.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ash::vk;

use super::context::Context;
use super::error::VulkanError;
use caustics_files::file::read_head;
use caustics_files::hash::{DIGITS, Digest};

/// Maximum size of a file (bytes). Drivers take about 10 MB for all kernels.
const MAX_BYTES: u64 = 1 << 28;

/// Pipeline cache. It is no error if its file cannot be read or written.
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
        let file = path.as_ref().and_then(|path| read_head(path, MAX_BYTES).ok()).unwrap_or_default();
        let data = whole(&file).filter(|data| is_of_device(data, properties)).unwrap_or_default();
        let info = vk::PipelineCacheCreateInfo::default().initial_data(data);
        // SAFETY: the data was written for this very device and driver.
        let raw = unsafe { context.raw.create_pipeline_cache(&info, None) }
            .map_err(VulkanError::call("vkCreatePipelineCache"))?;
        Ok(PipelineCache { raw, path, context: Arc::clone(context) })
    }

    /// Writes the cache atomically.
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

/// Returns the data of a file if it is undamaged.
fn whole(file: &[u8]) -> Option<&[u8]> {
    let (data, digest) = file.split_last_chunk::<DIGITS>()?;
    (Digest::hex([data]).as_bytes() == digest).then_some(data)
}

/// Whether the header (length, version, vendor, device, uuid) belongs to this device.
fn is_of_device(data: &[u8], properties: &vk::PhysicalDeviceProperties) -> bool {
    let word = |index: usize| {
        data.get(4 * index..4 * index + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    word(0) == Some(32)
        && word(1) == Some(vk::PipelineCacheHeaderVersion::ONE.as_raw() as u32)
        && word(2) == Some(properties.vendor_id)
        && word(3) == Some(properties.device_id)
        && data.get(16..32) == Some(&properties.pipeline_cache_uuid[..])
}

fn write(path: &Path, data: &[u8]) -> std::io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(data)?;
    file.write_all(Digest::hex([data]).as_bytes())?;
    file.persist(path)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cut_or_changed_cache_files_are_ignored() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pipelines.bin");
        write(&path, b"compiled").unwrap();
        let file = std::fs::read(&path).unwrap();
        assert_eq!(whole(&file), Some(&b"compiled"[..]));
        for length in 0..file.len() {
            assert_eq!(whole(&file[..length]), None, "{length}");
        }
        for bit in 0..8 * file.len() {
            let mut flipped = file.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(whole(&flipped), None, "{bit}");
        }
    }

    #[test]
    fn headers_of_other_devices_and_of_other_layouts_are_refused() {
        let properties = vk::PhysicalDeviceProperties { vendor_id: 3, device_id: 4, ..Default::default() };
        let header = |words: [u32; 4]| -> Vec<u8> {
            words.into_iter().flat_map(u32::to_le_bytes).chain([0; 16]).collect()
        };
        assert!(is_of_device(&header([32, 1, 3, 4]), &properties));
        for words in
            [[31, 1, 3, 4], [u32::MAX, 1, 3, 4], [32, 0, 3, 4], [32, 2, 3, 4], [32, 1, 4, 4], [32, 1, 3, 3]]
        {
            assert!(!is_of_device(&header(words), &properties), "{words:?}");
        }
        assert!(!is_of_device(&header([32, 1, 3, 4])[..31], &properties));
    }
}
