//! Compiled kernels: their source, and checks that they are complete and fit this program.
//!
//! A program embeds modules, and can load others from a folder that `cargo kernels --out` writes. It loads them whenever it
//! opens a session; [`Watch`] reports new ones.
//! The steps of a frame and the sizes of buffers belong to the program. Other kernels may compute differently but must bind
//! the same buffers.

use std::path::PathBuf;

pub use self::error::KernelsError;
pub use self::watch::Watch;

mod check;
mod error;
mod lock;
mod watch;

#[cfg(test)]
pub(crate) use self::check::passes;
use self::lock::{BASE, KernelsLock, RAYQUERY, words};

/// Hash of the kernels' sources.
pub const SOURCES: &str = env!("CAUSTICS_KERNELS_HASH");

/// SPIR-V modules.
#[derive(Clone, Debug)]
pub struct Modules {
    /// Module for any Vulkan 1.2 device.
    pub base: Vec<u32>,
    /// Module for devices with ray queries.
    pub rayquery: Vec<u32>,
}

/// Source of the kernels.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Source {
    /// Modules embedded in the program.
    #[default]
    Embedded,
    /// Modules in a folder at the time when a session is opened, with their `kernels.lock`.
    Folder(PathBuf),
}

impl Source {
    /// Returns the folder in the environment variable `CAUSTICS_KERNELS`, or else the embedded modules.
    pub fn from_environment() -> Source {
        let folder = std::env::var_os("CAUSTICS_KERNELS").filter(|folder| !folder.is_empty());
        folder.map_or(Source::Embedded, |folder| Source::Folder(folder.into()))
    }

    /// Loads the modules and checks that this program's passes can run them.
    ///
    /// # Errors
    ///
    /// - If the embedded modules are older than their sources.
    /// - If modules of a folder are missing, differ from their lock, or have another interface than the program.
    /// - If an entry point is missing, or binds a buffer otherwise than the program's pass of that name.
    pub fn modules(&self) -> Result<Modules, KernelsError> {
        let Source::Folder(folder) = self else { return embedded() };
        let lock = KernelsLock::read(folder)?;
        if lock.interface != env!("CAUSTICS_INTERFACE_HASH") {
            return Err(KernelsError::Interface { folder: folder.clone() });
        }
        let [base, rayquery] = lock.modules(folder)?.map(|bytes| words(&bytes));
        check::modules([&base, &rayquery])?;
        Ok(Modules { base, rayquery })
    }

    /// Loads the modules without any check, not even of a lock, to show a compiler's output for them.
    ///
    /// # Errors
    ///
    /// If the embedded modules are older than their sources, or those of a folder cannot be read.
    pub fn unchecked(&self) -> Result<Modules, KernelsError> {
        let Source::Folder(folder) = self else { return embedded() };
        let read = |name: &str| lock::read(&folder.join(name)).map(|bytes| words(&bytes));
        Ok(Modules { base: read(BASE)?, rayquery: read(RAYQUERY)? })
    }
}

/// Returns the embedded modules, unless the sources changed between `cargo kernels` and the build.
fn embedded() -> Result<Modules, KernelsError> {
    if env!("CAUSTICS_KERNELS_FRESH") != "1" {
        return Err(KernelsError::Stale);
    }
    Ok(Modules {
        base: words(include_bytes!("../../kernels/base.spv")),
        rayquery: words(include_bytes!("../../kernels/rayquery.spv")),
    })
}

#[cfg(test)]
mod tests;
