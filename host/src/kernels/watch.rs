//! Detection of new kernels in a folder.

use std::path::PathBuf;

use super::lock::KernelsLock;

/// Detector of new complete sets of kernels in a folder. It starts no thread: the caller polls it, and each poll reads a
/// small file.
///
/// ```no_run
/// # let folder = std::path::PathBuf::new();
/// use caustics::kernels::{Source, Watch};
///
/// let mut watch = Watch::new(folder.clone());
/// if watch.has_new() {
///     match Source::Folder(folder).modules() {
///         Ok(_) => {} // A session that is opened now runs them.
///         Err(error) => eprintln!("{error}"),
///     }
/// }
/// ```
#[derive(Debug)]
pub struct Watch {
    folder: PathBuf,
    /// Lock of the last set that was seen.
    seen: Option<KernelsLock>,
}

impl Watch {
    /// Watches a folder. A complete set that is already there is not new.
    pub fn new(folder: PathBuf) -> Watch {
        let mut watch = Watch { folder, seen: None };
        watch.has_new();
        watch
    }

    /// Whether the folder holds a complete set that was not there at the last call. A set that is being written is reported
    /// once it is complete. [`Source::modules`](super::Source::modules) checks whether this program can run it.
    pub fn has_new(&mut self) -> bool {
        let Ok(lock) = KernelsLock::read(&self.folder) else { return false };
        if self.seen.as_ref() == Some(&lock) || lock.modules(&self.folder).is_err() {
            return false;
        }
        self.seen = Some(lock);
        true
    }
}
