//! Output files that appear whole or not at all.

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use thiserror::Error;

use super::folder::{EntryKind, Folder};
use crate::file;

/// Error of writing an output file.
#[derive(Debug, Error)]
pub enum TargetError {
    /// The file exists.
    #[error("{} exists; give --force to overwrite it", .0.display())]
    Exists(PathBuf),
    /// The path is a link to a missing file.
    #[error("{} is a link to what is not there; remove it, or give --force to replace it", .0.display())]
    Dangling(PathBuf),
    /// The path is a device, a pipe or a folder, which must not be replaced.
    #[error("{} is no regular file; give another name", .0.display())]
    NoFile(PathBuf),
    /// Another run writes the file.
    #[error("another run writes {} and holds {}; wait for it, or give another -o", output.display(), lock.display())]
    Busy {
        /// The file.
        output: PathBuf,
        /// Lock file of the other run.
        lock: PathBuf,
    },
    /// The file cannot be removed.
    #[error("cannot remove {}: {source}", path.display())]
    Remove {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The file cannot be written.
    #[error("cannot write {}: {source}; {}", path.display(), advice(source))]
    Write {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
}

impl TargetError {
    /// Whether the user chose a file that cannot be written; otherwise the system failed to write it.
    pub fn is_usage(&self) -> bool {
        matches!(self, TargetError::Exists(_) | TargetError::Dangling(_) | TargetError::NoFile(_))
    }
}

/// Returns advice for a file that cannot be written.
fn advice(error: &std::io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::FileTooLarge => "raise the limit of files (ulimit -f), or give a smaller size",
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "make room there, or choose another -o",
        _ => "choose another -o, or create the folder",
    }
}

/// Prefix of the names of temporary files.
pub(super) const PREFIX: &str = ".caustics-";

/// Output file that is claimed before its content is computed. It is written to the folder that was opened by the claim,
/// even if that folder is moved.
#[derive(Debug)]
pub struct Target {
    path: PathBuf,
    name: OsString,
    force: bool,
    part: Part,
}

impl Target {
    /// Checks that `path` may be written and opens a temporary file beside it. With `force` an existing file is replaced.
    ///
    /// # Errors
    ///
    /// - If the file exists and `force` is not set.
    /// - If `path` is a folder, a device or a link to a missing file.
    /// - If its folder cannot be written.
    pub fn claim(path: &Path, force: bool) -> Result<Target, TargetError> {
        let path = path.to_path_buf();
        let Some(name) = path.file_name().map(OsStr::to_os_string) else {
            return Err(TargetError::NoFile(path));
        };
        let fail = |source| TargetError::Write { path: path.clone(), source };
        let folder = Folder::open(folder(&path)).map_err(fail)?;
        match folder.entry(&name) {
            Some(EntryKind::Other) => return Err(TargetError::NoFile(path)),
            Some(EntryKind::Dangling) if !force => return Err(TargetError::Dangling(path)),
            Some(EntryKind::File) if !force => return Err(TargetError::Exists(path)),
            _ => {}
        }
        let part = Part::new(folder).map_err(fail)?;
        Ok(Target { path, name, force, part })
    }

    /// Writes the bytes to the temporary file and renames it to the claimed path.
    pub fn finish(self, bytes: &[u8]) -> Result<(), TargetError> {
        self.finish_with(|file| file.write_all(bytes))
    }

    /// Writes the file by a function, for content that is too large for memory. See [`Target::finish`].
    pub fn finish_with(
        mut self,
        write: impl FnOnce(&mut BufWriter<&mut File>) -> std::io::Result<()>,
    ) -> Result<(), TargetError> {
        let mut file = BufWriter::new(&mut self.part.file);
        let written = write(&mut file).and_then(|()| file.flush());
        drop(file);
        let done = written.and_then(|()| self.part.rename_to(&self.name, self.force)).or_else(|error| {
            // The folder was removed, and the temporary file with it: recreate the folder and copy the open file.
            if error.kind() != ErrorKind::NotFound || !self.part.folder.is_removed() {
                return Err(error);
            }
            let folder = folder(&self.path);
            std::fs::create_dir_all(folder)?;
            let mut again = Part::new(Folder::open(folder)?)?;
            self.part.file.rewind()?;
            std::io::copy(&mut self.part.file, &mut again.file)?;
            again.rename_to(&self.name, self.force)
        });
        done.map_err(|source| match source.kind() {
            ErrorKind::AlreadyExists => TargetError::Exists(self.path.clone()),
            _ => TargetError::Write { path: self.path.clone(), source },
        })
    }
}

/// Returns the folder of a file.
pub(super) fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

/// Temporary file. It is locked while it is in use, which tells it from a file that a killed run left. It is removed on
/// drop unless it was renamed.
#[derive(Debug)]
struct Part {
    folder: Arc<Folder>,
    /// Temporary name; `None` once the file has its final name.
    name: Option<OsString>,
    file: File,
}

impl Part {
    fn new(folder: Arc<Folder>) -> std::io::Result<Part> {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        remove_stale(&folder.path);
        loop {
            let count = COUNT.fetch_add(1, Ordering::Relaxed);
            let name = OsString::from(format!("{PREFIX}{}-{count}", std::process::id()));
            let file = match folder.create(&name) {
                // A killed process with the same id left it.
                Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
                file => file?,
            };
            // Without locks on this drive, other runs cannot lock the file in order to remove it either.
            let _ = file.lock();
            // Another run may have removed the file as stale before it was locked.
            if folder.holds(&name, &file) {
                return Ok(Part { folder, name: Some(name), file });
            }
        }
    }

    /// Renames the temporary file to its final name.
    fn rename_to(&mut self, name: &OsStr, force: bool) -> std::io::Result<()> {
        // Sync first: after a crash of the machine, the name must not exist without its bytes.
        self.file.sync_all()?;
        #[cfg(unix)]
        {
            // Temporary files are private; the final file gets the default permissions of a new file.
            use std::os::unix::fs::PermissionsExt;
            self.file.set_permissions(std::fs::Permissions::from_mode(0o644))?;
        }
        if let Some(part) = &self.name {
            self.folder.rename(part, name, force)?;
        }
        self.name = None;
        Ok(())
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        if let Some(name) = &self.name {
            // The file is gone if its folder is.
            let _ = self.folder.remove(name);
        }
    }
}

/// Removes files of killed runs from a folder, once in a process: temporary files that are not locked.
fn remove_stale(folder: &Path) {
    static SEEN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let is_new = SEEN.lock().is_ok_and(|mut seen| seen.insert(folder.into()));
    for entry in folder.read_dir().into_iter().flatten().flatten().filter(|_| is_new) {
        let is_ours = entry.file_name().to_string_lossy().starts_with(PREFIX);
        if !is_ours || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        // Keep the lock until the file is removed: a run that creates it at this moment waits.
        if let Ok(file) = file::open(&entry.path())
            && file.try_lock().is_ok()
        {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Removes a file. A missing file is no error.
///
/// # Errors
///
/// If the system cannot remove the file.
pub fn remove(path: &Path) -> Result<(), TargetError> {
    // Use the open folder, which may have moved.
    let removed = match path.file_name() {
        Some(name) => Folder::open(folder(path)).and_then(|folder| folder.remove(name)),
        None => std::fs::remove_file(path),
    };
    match removed {
        Err(source) if source.kind() != ErrorKind::NotFound => {
            Err(TargetError::Remove { path: path.into(), source })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_overwritten_without_force_and_nothing_is_left_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        Target::claim(&path, false).unwrap().finish(b"one").unwrap();
        assert!(matches!(Target::claim(&path, false), Err(TargetError::Exists(_))));
        drop(Target::claim(&path, true).unwrap());
        assert_eq!(std::fs::read(&path).unwrap(), b"one");
        Target::claim(&path, true).unwrap().finish(b"two").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        assert_eq!(folder.path().read_dir().unwrap().count(), 1);
        let nowhere = folder.path().join("missing/a.exr");
        assert!(matches!(Target::claim(&nowhere, true), Err(TargetError::Write { .. })));
        assert!(matches!(Target::claim(folder.path(), true), Err(TargetError::NoFile(_))));
    }

    #[test]
    fn files_of_killed_runs_are_removed_and_files_in_use_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let [stale, used, other] =
            [".caustics-a1", ".caustics-b2", "caustics-c3"].map(|name| folder.path().join(name));
        for path in [&stale, &used, &other] {
            std::fs::write(path, "part").unwrap();
        }
        let holder = File::open(&used).unwrap();
        holder.lock().unwrap();
        let target = Target::claim(&folder.path().join("a.exr"), false).unwrap();
        assert_eq!([&stale, &used, &other].map(|path| path.exists()), [false, true, true]);
        // The target's own temporary file is locked too.
        let own = File::open(folder.path().join(target.part.name.as_ref().unwrap())).unwrap();
        assert!(own.try_lock().is_err());
        target.finish(b"whole").unwrap();
        assert_eq!(std::fs::read(folder.path().join("a.exr")).unwrap(), b"whole");
    }

    #[cfg(unix)]
    #[test]
    fn a_file_follows_its_moved_folder_and_is_written_even_if_its_folder_was_removed() {
        let desk = tempfile::tempdir().unwrap();
        let [before, after] = ["before", "after"].map(|name| desk.path().join(name));
        std::fs::create_dir(&before).unwrap();
        let [first, dropped] = ["a", "b"].map(|name| Target::claim(&before.join(name), false).unwrap());
        std::fs::rename(&before, &after).unwrap();
        // While a target is open, its path stands for the moved folder.
        Target::claim(&before.join("c"), false).unwrap().finish(b"later").unwrap();
        first.finish(b"whole").unwrap();
        drop(dropped);
        let files = |folder: &Path| -> BTreeSet<OsString> {
            folder.read_dir().unwrap().map(|file| file.unwrap().file_name()).collect()
        };
        assert_eq!(files(&after), BTreeSet::from(["a".into(), "c".into()]));
        assert!(!before.exists());

        let removed = Target::claim(&after.join("d"), false).unwrap();
        std::fs::remove_dir_all(&after).unwrap();
        removed.finish(b"whole").unwrap();
        assert_eq!(
            (files(&after), std::fs::read(after.join("d")).unwrap()),
            (["d".into()].into(), b"whole".into())
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_a_missing_file_is_refused_without_force() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        std::os::unix::fs::symlink("nowhere", &path).unwrap();
        assert!(matches!(Target::claim(&path, false), Err(TargetError::Dangling(_))));
        Target::claim(&path, true).unwrap().finish(b"whole").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"whole");
    }
}
