//! Why kernels cannot be taken.

use std::path::PathBuf;

use thiserror::Error;

use crate::vulkan::VulkanError;

/// Kernels that this program cannot run.
#[derive(Debug, Error)]
pub enum KernelsError {
    /// The modules that the program carries are not what the sources say.
    #[error(
        "kernels/*.spv is older than kernels/src: run `cargo kernels`, then build again; --runner cpu works as it is"
    )]
    Stale,
    /// A folder without a lock.
    #[error(
        "{} is missing: kernels are taken from a folder that `cargo kernels --out FOLDER` writes; --runner cpu works \
         without them",
        .file.display()
    )]
    NoLock {
        /// The file that is missing.
        file: PathBuf,
    },
    /// A file cannot be read.
    #[error("cannot read {}: {source}", .file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A lock that `cargo kernels` did not write.
    #[error("{}: {source}; run `cargo kernels --out` with its folder", .file.display())]
    Lock {
        /// The file.
        file: PathBuf,
        /// Why.
        source: Box<toml::de::Error>,
    },
    /// A module of which only a part is there, or another one.
    #[error(
        "{} is not whole: it is not the module that kernels.lock beside it names; wait until `cargo kernels` is done, \
         or run it again",
        .file.display()
    )]
    NotWhole {
        /// The module.
        file: PathBuf,
    },
    /// Kernels and program do not share their types.
    #[error(
        "the interface of the kernels in {} is another than this program's: build again (`cargo build --release`), and \
         compile the kernels again if their sources are the older ones",
        .folder.display()
    )]
    Interface {
        /// Where the kernels are.
        folder: PathBuf,
    },
    /// A module that is not of the expected form.
    #[error("{0}")]
    Module(#[from] VulkanError),
    /// A pass without an entry point.
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
    /// An entry point that binds what the program does not give it.
    #[error(
        "entry point `{entry}` of {module} binds `{buffer}`, which this program's pass of that name does not have: build \
         again (`cargo build --release`)"
    )]
    Unbound {
        /// Name of the module.
        module: &'static str,
        /// Name of the pass.
        entry: &'static str,
        /// Name of what is bound.
        buffer: String,
    },
    /// A buffer whose elements are larger or smaller than the program's.
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
