//! Lock of an output file: one run at a time writes it.

use std::ffi::OsString;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::sleep;
use std::time::Duration;

use super::folder::Folder;
use super::target::{PREFIX, TargetError, folder};

/// Attempts to take a lock. A run that removes stale files holds it for a moment.
const ATTEMPTS: u32 = 20;
/// Pause between attempts.
const PAUSE: Duration = Duration::from_millis(10);

/// Lock of an output file and the files that belong to it: a locked file beside it. The system unlocks it when the process
/// ends, for any reason. The lock file is removed on drop, or by a later run.
#[derive(Debug)]
pub struct FileLock {
    folder: Arc<Folder>,
    name: OsString,
    // Holds the lock while it is open.
    _file: File,
}

impl FileLock {
    /// Takes the lock.
    ///
    /// # Errors
    ///
    /// If another run holds the lock, or its file cannot be written.
    pub fn take(output: &Path) -> Result<FileLock, TargetError> {
        let fail = |source| TargetError::Write { path: output.into(), source };
        let name = name(output);
        let folder = Folder::open(folder(output)).map_err(fail)?;
        for _ in 0..ATTEMPTS {
            let file = folder.open_or_create(&name).map_err(fail)?;
            match file.try_lock() {
                // The previous holder removed the file after it was opened here: try again.
                Ok(()) if !folder.holds(&name, &file) => {}
                // The drive supports no locks: proceed without.
                Ok(()) | Err(TryLockError::Error(_)) => return Ok(FileLock { folder, name, _file: file }),
                Err(TryLockError::WouldBlock) => sleep(PAUSE),
            }
        }
        Err(TargetError::Busy { output: output.into(), lock: path_of(output) })
    }
}

/// Path of the lock file of an output file.
pub fn path_of(output: &Path) -> PathBuf {
    folder(output).join(name(output))
}

fn name(output: &Path) -> OsString {
    format!("{PREFIX}{}.lock", output.file_name().unwrap_or_default().to_string_lossy()).into()
}

impl Drop for FileLock {
    fn drop(&mut self) {
        let _ = self.folder.remove(&self.name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_is_exclusive_and_its_file_is_removed() {
        let desk = tempfile::tempdir().unwrap();
        let output = desk.path().join("a.exr");
        let first = FileLock::take(&output).unwrap();
        let error = FileLock::take(&output).unwrap_err();
        assert!(matches!(error, TargetError::Busy { .. }), "{error}");
        assert!(error.to_string().contains(".caustics-a.exr.lock"), "{error}");
        FileLock::take(&desk.path().join("b.exr")).unwrap();
        drop(first);
        drop(FileLock::take(&output).unwrap());
        // The lock file of a killed run is not locked.
        std::fs::write(desk.path().join(".caustics-a.exr.lock"), "").unwrap();
        drop(FileLock::take(&output).unwrap());
        assert_eq!(desk.path().read_dir().unwrap().count(), 0);
    }
}
