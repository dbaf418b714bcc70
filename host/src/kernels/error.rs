//! Errors of loading kernels.

use std::path::PathBuf;

use thiserror::Error;

use crate::vulkan::VulkanError;

/// Error of loading kernels.
#[derive(Debug, Error)]
pub enum KernelsError {
    /// The embedded modules are older than their sources.
    #[error(
        "kernels/*.spv is older than kernels/src: run `cargo kernels`, then build again; --runner cpu works as it is"
    )]
    Stale,
    /// The folder has no lock.
    #[error(
        "{} is missing: kernels are taken from a folder that `cargo kernels --out FOLDER` writes; --runner cpu works \
         without them",
        .file.display()
    )]
    NoLock {
        /// Missing file.
        file: PathBuf,
    },
    /// A file cannot be read.
    #[error("cannot read {}: {source}", .file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// The lock has another format than `cargo kernels` writes.
    #[error("{}: {source}; run `cargo kernels --out` with its folder", .file.display())]
    Lock {
        /// The file.
        file: PathBuf,
        /// Cause.
        source: Box<toml::de::Error>,
    },
    /// A module is incomplete, or is not the one that the lock names.
    #[error(
        "{} is not whole: it is not the module that kernels.lock beside it names; wait until `cargo kernels` is done, \
         or run it again",
        .file.display()
    )]
    NotWhole {
        /// The module.
        file: PathBuf,
    },
    /// The kernels and the program have different interface types.
    #[error(
        "the interface of the kernels in {} is another than this program's: build again (`cargo build --release`), and \
         compile the kernels again if their sources are the older ones",
        .folder.display()
    )]
    Interface {
        /// Folder of the kernels.
        folder: PathBuf,
    },
    /// A module does not have the expected form.
    #[error("{0}")]
    Module(#[from] VulkanError),
    /// A pass has no entry point.
    #[error(
        "{module} has no entry point `{entry}`, which this program runs: build again (`cargo build --release`), or \
         compile the kernels that belong to it"
    )]
    NoEntry {
        /// Name of the module.
        module: &'static str,
        /// Name of the pass.
        entry: &'static str,
    },
    /// An entry point binds a buffer that the program's pass does not have.
    #[error(
        "entry point `{entry}` of {module} binds `{buffer}`, which this program's pass of that name does not have: build \
         again (`cargo build --release`)"
    )]
    Unbound {
        /// Name of the module.
        module: &'static str,
        /// Name of the pass.
        entry: &'static str,
        /// Name of the binding.
        buffer: String,
    },
    /// The elements of a buffer differ in size from the program's.
    #[error(
        "entry point `{entry}` of {module} binds `{buffer}` with elements of {found} bytes, but those of this program have \
         {expected}: build again (`cargo build --release`)"
    )]
    Elements {
        /// Name of the module.
        module: &'static str,
        /// Name of the pass.
        entry: &'static str,
        /// Name of the buffer.
        buffer: String,
        /// Size of an element in the module (bytes).
        found: u32,
        /// Size of an element in the program (bytes).
        expected: usize,
    },
}
