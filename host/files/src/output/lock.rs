//! One run at a time writes a file.

use std::ffi::OsString;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::sleep;
use std::time::Duration;

use super::folder::Folder;
use super::target::{PREFIX, TargetError, folder};

/// How often a lock is asked for: who tidies up holds it for a moment.
const ATTEMPTS: u32 = 20;
/// Time between.
const PAUSE: Duration = Duration::from_millis(10);

/// The right to write a file and what belongs to it: a locked file beside it, which the system unlocks when the process
/// ends, however it ends. It is removed with the right, or by a later run.
#[derive(Debug)]
pub struct FileLock {
    folder: Arc<Folder>,
    name: OsString,
    // Locked as long as it is open.
    _file: File,
}

impl FileLock {
    /// Takes it; an error where another run has it.
    pub fn take(output: &Path) -> Result<FileLock, TargetError> {
        let fail = |source| TargetError::Write { path: output.into(), source };
        let name = name(output);
        let folder = Folder::open(folder(output)).map_err(fail)?;
        for _ in 0..ATTEMPTS {
            let file = folder.open_or_create(&name).map_err(fail)?;
            match file.try_lock() {
                // Who had it before may have removed it after it was opened here.
                Ok(()) if !folder.holds(&name, &file) => {}
                // On a drive without locks runs are not told apart.
                Ok(()) | Err(TryLockError::Error(_)) => return Ok(FileLock { folder, name, _file: file }),
                Err(TryLockError::WouldBlock) => sleep(PAUSE),
            }
        }
        Err(TargetError::Busy { output: output.into(), lock: path_of(output) })
    }
}

/// The locked file beside a file that is written.
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
    fn only_one_has_it_and_nothing_is_left() {
        let desk = tempfile::tempdir().unwrap();
        let output = desk.path().join("a.exr");
        let first = FileLock::take(&output).unwrap();
        let error = FileLock::take(&output).unwrap_err();
        assert!(matches!(error, TargetError::Busy { .. }), "{error}");
        assert!(error.to_string().contains(".caustics-a.exr.lock"), "{error}");
        FileLock::take(&desk.path().join("b.exr")).unwrap();
        drop(first);
        drop(FileLock::take(&output).unwrap());
        // What a killed run leaves is locked by nobody.
        std::fs::write(desk.path().join(".caustics-a.exr.lock"), "").unwrap();
        drop(FileLock::take(&output).unwrap());
        assert_eq!(desk.path().read_dir().unwrap().count(), 0);
    }
}
