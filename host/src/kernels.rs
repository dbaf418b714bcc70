//! Compiled kernels: where they come from, and whether they are whole and for this program.
//!
//! A program carries modules of its own and takes others from a folder that `cargo kernels --out` writes, as often as it opens a
//! session: [`Watch`] says when new ones are there. What a frame consists of (its steps, the sizes of buffers) stays the
//! program's own, so that other kernels may compute otherwise but bind the same buffers.

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

/// The SPIR-V modules.
#[derive(Clone, Debug)]
pub struct Modules {
    /// For any Vulkan 1.2 device.
    pub base: Vec<u32>,
    /// For devices with ray queries.
    pub rayquery: Vec<u32>,
}

/// Where kernels come from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Source {
    /// The modules that the program carries.
    #[default]
    Embedded,
    /// The modules that lie in a folder when a session is opened, with their `kernels.lock`.
    Folder(PathBuf),
}

impl Source {
    /// The folder in the environment variable `CAUSTICS_KERNELS`; without one, the modules that the program carries.
    pub fn from_environment() -> Source {
        let folder = std::env::var_os("CAUSTICS_KERNELS").filter(|folder| !folder.is_empty());
        folder.map_or(Source::Embedded, |folder| Source::Folder(folder.into()))
    }

    /// The modules, for this program's passes to run.
    ///
    /// # Errors
    ///
    /// If the modules that the program carries are older than their sources; or if those of a folder are missing, not what
    /// their lock says, of another interface than the program, or lack an entry point or bind a buffer otherwise than
    /// the program's pass of that name.
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

    /// The modules as they are, for a compiler to show what it makes of them: not even a lock is asked for.
    ///
    /// # Errors
    ///
    /// If the modules that the program carries are older than their sources, or those of a folder cannot be read.
    pub fn unchecked(&self) -> Result<Modules, KernelsError> {
        let Source::Folder(folder) = self else { return embedded() };
        let read = |name: &str| lock::read(&folder.join(name)).map(|bytes| words(&bytes));
        Ok(Modules { base: read(BASE)?, rayquery: read(RAYQUERY)? })
    }
}

/// The modules that the program carries, unless the sources had changed since `cargo kernels` when it was built.
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
