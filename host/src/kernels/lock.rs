//! Set of kernels in a folder: the modules, and a lock that is written after them.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::error::KernelsError;
use caustics_files::file::{read_file, read_text};
use caustics_files::hash::fnv1a;

/// Name of the module for any device.
pub const BASE: &str = "base.spv";
/// Name of the module for devices with ray queries.
pub const RAYQUERY: &str = "rayquery.spv";

/// Contents of `kernels.lock` that a program reads.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct KernelsLock {
    /// Hash of the interface between kernels and program; empty in locks of old kernels.
    #[serde(default)]
    pub interface: String,
    #[serde(rename = "base.spv")]
    base: String,
    #[serde(rename = "rayquery.spv")]
    rayquery: String,
}

impl KernelsLock {
    /// Reads the lock of a folder.
    pub fn read(folder: &Path) -> Result<KernelsLock, KernelsError> {
        let file = folder.join("kernels.lock");
        let text = match read_text(&file) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Err(KernelsError::NoLock { file }),
            Err(source) => return Err(KernelsError::Read { file, source }),
        };
        toml::from_str(&text).map_err(|source| KernelsError::Lock { file, source: source.into() })
    }

    /// Returns the bytes of the folder's modules: base, then ray queries. A module whose hash differs from the lock is
    /// refused.
    pub fn modules(&self, folder: &Path) -> Result<[Vec<u8>; 2], KernelsError> {
        let module = |name: &str, hash: &str| {
            let file: PathBuf = folder.join(name);
            let bytes = read(&file)?;
            // The builder appends a byte 0xff to each file that it hashes.
            if fnv1a(bytes.iter().copied().chain([0xff])) == hash {
                Ok(bytes)
            } else {
                Err(KernelsError::NotWhole { file })
            }
        };
        Ok([module(BASE, &self.base)?, module(RAYQUERY, &self.rayquery)?])
    }
}

/// Returns the bytes of a file.
pub fn read(file: &Path) -> Result<Vec<u8>, KernelsError> {
    read_file(file).map_err(|source| KernelsError::Read { file: file.to_path_buf(), source })
}

/// Returns the words of a module.
pub fn words(bytes: &[u8]) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(bytes)
}
