//! Looks at a folder of kernels for new ones.

use std::path::PathBuf;

use super::lock::KernelsLock;

/// Says when a new whole set of kernels lies in a folder. It starts no thread: ask it as often as it matters, at the cost of
/// reading a small file.
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
    /// The lock of the set that was seen last.
    seen: Option<KernelsLock>,
}

impl Watch {
    /// Watches a folder. The set that lies there now, if it is whole, is no new one.
    pub fn new(folder: PathBuf) -> Watch {
        let mut watch = Watch { folder, seen: None };
        watch.has_new();
        watch
    }

    /// Whether another set lies there than at the last call, and is whole: a set that is being written is new when it is there.
    /// Whether this program can run it is what [`Source::modules`](super::Source::modules) says.
    pub fn has_new(&mut self) -> bool {
        let Ok(lock) = KernelsLock::read(&self.folder) else { return false };
        if self.seen.as_ref() == Some(&lock) || lock.modules(&self.folder).is_err() {
            return false;
        }
        self.seen = Some(lock);
        true
    }
}
