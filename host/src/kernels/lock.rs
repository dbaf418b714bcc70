//! A set of kernels in a folder: modules, and a lock that is written when they are there.

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

/// What `kernels.lock` says that a program must know.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct KernelsLock {
    /// Hash of what kernels and program must agree on; locks of old kernels have none.
    #[serde(default)]
    pub interface: String,
    #[serde(rename = "base.spv")]
    base: String,
    #[serde(rename = "rayquery.spv")]
    rayquery: String,
}

impl KernelsLock {
    /// The lock of a folder.
    pub fn read(folder: &Path) -> Result<KernelsLock, KernelsError> {
        let file = folder.join("kernels.lock");
        let text = match read_text(&file) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Err(KernelsError::NoLock { file }),
            Err(source) => return Err(KernelsError::Read { file, source }),
        };
        toml::from_str(&text).map_err(|source| KernelsError::Lock { file, source: source.into() })
    }

    /// The bytes of the folder's modules: base, then with ray queries. Those that it does not name are refused.
    pub fn modules(&self, folder: &Path) -> Result<[Vec<u8>; 2], KernelsError> {
        let module = |name: &str, hash: &str| {
            let file: PathBuf = folder.join(name);
            let bytes = read(&file)?;
            // It hashes a byte 0xff behind the module.
            if fnv1a(bytes.iter().copied().chain([0xff])) == hash {
                Ok(bytes)
            } else {
                Err(KernelsError::NotWhole { file })
            }
        };
        Ok([module(BASE, &self.base)?, module(RAYQUERY, &self.rayquery)?])
    }
}

/// The bytes of a file.
pub fn read(file: &Path) -> Result<Vec<u8>, KernelsError> {
    read_file(file).map_err(|source| KernelsError::Read { file: file.to_path_buf(), source })
}

/// The words of a module.
pub fn words(bytes: &[u8]) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(bytes)
}
