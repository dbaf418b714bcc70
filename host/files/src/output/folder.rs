//! Output folder, held open: files are written into it even if it is moved in the meantime.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs::File;
use std::io::Result;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, Weak};

/// Kind of a folder's entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EntryKind {
    /// A regular file, or a link to one.
    File,
    /// A link to a missing file.
    Dangling,
    /// A folder, a device or a pipe.
    Other,
}

/// Output folder, held open.
#[derive(Debug)]
pub struct Folder {
    /// Path at the time of opening.
    pub path: PathBuf,
    #[cfg(unix)]
    descriptor: std::os::fd::OwnedFd,
}

/// Open folders by path: one for each path, even after it was moved.
static OPEN: Mutex<BTreeMap<PathBuf, Weak<Folder>>> = Mutex::new(BTreeMap::new());

impl Folder {
    /// Returns the open folder of this path, or opens it.
    ///
    /// # Errors
    ///
    /// If the folder does not exist.
    pub fn open(path: &Path) -> Result<Arc<Folder>> {
        let mut open = OPEN.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        open.retain(|_, folder| folder.strong_count() > 0);
        if let Some(folder) = open.get(path).and_then(Weak::upgrade).filter(|folder| !folder.is_removed()) {
            return Ok(folder);
        }
        let folder = Arc::new(Folder::new(path)?);
        open.insert(path.into(), Arc::downgrade(&folder));
        Ok(folder)
    }
}

#[cfg(unix)]
mod system {
    use super::*;
    use rustix::fs::{AtFlags, CWD, FileType, Mode, OFlags, Stat, fstat, openat, renameat, statat, unlinkat};

    impl Folder {
        pub(super) fn new(path: &Path) -> Result<Folder> {
            // A folder may be writable without being readable.
            #[cfg(target_os = "linux")]
            let access = OFlags::PATH;
            #[cfg(not(target_os = "linux"))]
            let access = OFlags::RDONLY;
            let flags = OFlags::DIRECTORY | OFlags::CLOEXEC | access;
            Ok(Folder { path: path.into(), descriptor: openat(CWD, path, flags, Mode::empty())? })
        }

        /// Whether the folder was deleted.
        pub fn is_removed(&self) -> bool {
            fstat(&self.descriptor).is_ok_and(|stat| stat.st_nlink == 0)
        }

        /// Creates a file that only its owner can read. Fails if the name is taken.
        pub fn create(&self, name: &OsStr) -> Result<File> {
            self.file(name, OFlags::CREATE | OFlags::EXCL)
        }

        /// Opens a file for writing, and creates it if it is missing.
        pub fn open_or_create(&self, name: &OsStr) -> Result<File> {
            self.file(name, OFlags::CREATE)
        }

        fn file(&self, name: &OsStr, flags: OFlags) -> Result<File> {
            // `NONBLOCK`: opening must not wait if the name is a pipe.
            let flags = flags | OFlags::RDWR | OFlags::CLOEXEC | OFlags::NONBLOCK | OFlags::NOCTTY;
            Ok(openat(&self.descriptor, name, flags, Mode::RUSR | Mode::WUSR)?.into())
        }

        /// Returns the kind of the entry of this name, or `None` if the name is free.
        pub fn entry(&self, name: &OsStr) -> Option<EntryKind> {
            statat(&self.descriptor, name, AtFlags::SYMLINK_NOFOLLOW).ok()?;
            Some(match self.stat(name) {
                Some(stat) if FileType::from_raw_mode(stat.st_mode) == FileType::RegularFile => {
                    EntryKind::File
                }
                Some(_) => EntryKind::Other,
                None => EntryKind::Dangling,
            })
        }

        fn stat(&self, name: &OsStr) -> Option<Stat> {
            statat(&self.descriptor, name, AtFlags::empty()).ok()
        }

        /// Whether an open file is the entry of this name.
        pub fn holds(&self, name: &OsStr, file: &File) -> bool {
            let id = |stat: Stat| (stat.st_dev, stat.st_ino);
            self.stat(name).is_some_and(|stat| fstat(file).is_ok_and(|open| id(open) == id(stat)))
        }

        /// Renames a file. With `force` it replaces an existing file.
        pub fn rename(&self, from: &OsStr, to: &OsStr, force: bool) -> Result<()> {
            let folder = &self.descriptor;
            if !force {
                // If two processes rename to the same name, exactly one succeeds.
                #[cfg(target_os = "linux")]
                {
                    use rustix::fs::{RenameFlags, renameat_with};
                    use rustix::io::Errno;
                    match renameat_with(folder, from, folder, to, RenameFlags::NOREPLACE) {
                        // The file system does not support `NOREPLACE`.
                        Err(Errno::INVAL | Errno::NOSYS) => {}
                        done => return Ok(done?),
                    }
                }
                if statat(folder, to, AtFlags::SYMLINK_NOFOLLOW).is_ok() {
                    return Err(std::io::ErrorKind::AlreadyExists.into());
                }
            }
            Ok(renameat(folder, from, folder, to)?)
        }

        /// Removes a file.
        pub fn remove(&self, name: &OsStr) -> Result<()> {
            Ok(unlinkat(&self.descriptor, name, AtFlags::empty())?)
        }
    }
}

/// Other systems do not move a folder while a file in it is open.
#[cfg(not(unix))]
mod system {
    use super::*;
    use std::fs::OpenOptions;

    impl Folder {
        pub(super) fn new(path: &Path) -> Result<Folder> {
            path.read_dir().map(|_| Folder { path: path.into() })
        }

        pub fn is_removed(&self) -> bool {
            !self.path.is_dir()
        }

        /// Creates a file. Fails if the name is taken.
        pub fn create(&self, name: &OsStr) -> Result<File> {
            OpenOptions::new().read(true).write(true).create_new(true).open(self.path.join(name))
        }

        /// Opens a file for writing, and creates it if it is missing.
        pub fn open_or_create(&self, name: &OsStr) -> Result<File> {
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(self.path.join(name))
        }

        /// Returns the kind of the entry of this name, or `None` if the name is free.
        pub fn entry(&self, name: &OsStr) -> Option<EntryKind> {
            let path = self.path.join(name);
            path.symlink_metadata().ok()?;
            Some(match path.metadata() {
                Ok(file) if file.is_file() => EntryKind::File,
                Ok(_) => EntryKind::Other,
                Err(_) => EntryKind::Dangling,
            })
        }

        /// Whether the entry of this name exists: an open file is not removed here.
        pub fn holds(&self, name: &OsStr, _: &File) -> bool {
            self.path.join(name).exists()
        }

        /// Renames a file. With `force` it replaces an existing file.
        pub fn rename(&self, from: &OsStr, to: &OsStr, force: bool) -> Result<()> {
            if !force && self.entry(to).is_some() {
                return Err(std::io::ErrorKind::AlreadyExists.into());
            }
            std::fs::rename(self.path.join(from), self.path.join(to))
        }

        /// Removes a file.
        pub fn remove(&self, name: &OsStr) -> Result<()> {
            std::fs::remove_file(self.path.join(name))
        }
    }
}
