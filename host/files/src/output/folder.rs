//! A folder in which files are written, opened once: what is written goes where the folder is, though somebody moves it meanwhile.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs::File;
use std::io::Result;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, Weak};

/// What stands under a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EntryKind {
    /// A regular file, or a link to one.
    File,
    /// A link that leads nowhere.
    Dangling,
    /// A folder, a device, a pipe.
    Other,
}

/// A folder in which files are written.
#[derive(Debug)]
pub struct Folder {
    /// Where it was when it was opened.
    pub path: PathBuf,
    #[cfg(unix)]
    descriptor: std::os::fd::OwnedFd,
}

/// Folders in use: of one path there is one, wherever it is by now.
static OPEN: Mutex<BTreeMap<PathBuf, Weak<Folder>>> = Mutex::new(BTreeMap::new());

impl Folder {
    /// The folder of this path, which is the one that is in use under it, if there is one.
    ///
    /// # Errors
    ///
    /// If there is no such folder.
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
            // Who may write in a folder need not be able to list it.
            #[cfg(target_os = "linux")]
            let access = OFlags::PATH;
            #[cfg(not(target_os = "linux"))]
            let access = OFlags::RDONLY;
            let flags = OFlags::DIRECTORY | OFlags::CLOEXEC | access;
            Ok(Folder { path: path.into(), descriptor: openat(CWD, path, flags, Mode::empty())? })
        }

        /// Whether nobody can reach it any more.
        pub fn is_removed(&self) -> bool {
            fstat(&self.descriptor).is_ok_and(|stat| stat.st_nlink == 0)
        }

        /// Makes a file that only its user reads, where there is none of this name.
        pub fn create(&self, name: &OsStr) -> Result<File> {
            self.file(name, OFlags::CREATE | OFlags::EXCL)
        }

        /// Opens a file to write, and makes it where there is none.
        pub fn open_or_create(&self, name: &OsStr) -> Result<File> {
            self.file(name, OFlags::CREATE)
        }

        fn file(&self, name: &OsStr, flags: OFlags) -> Result<File> {
            // A pipe of this name would keep it waiting.
            let flags = flags | OFlags::RDWR | OFlags::CLOEXEC | OFlags::NONBLOCK | OFlags::NOCTTY;
            Ok(openat(&self.descriptor, name, flags, Mode::RUSR | Mode::WUSR)?.into())
        }

        /// What stands under a name; none if nothing does.
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

        /// Whether an open file is the one of this name.
        pub fn holds(&self, name: &OsStr, file: &File) -> bool {
            let id = |stat: Stat| (stat.st_dev, stat.st_ino);
            self.stat(name).is_some_and(|stat| fstat(file).is_ok_and(|open| id(open) == id(stat)))
        }

        /// Gives a file another name, and with `force` takes that from one that has it.
        pub fn rename(&self, from: &OsStr, to: &OsStr, force: bool) -> Result<()> {
            let folder = &self.descriptor;
            if !force {
                // Of two that want the name at once, one gets it.
                #[cfg(target_os = "linux")]
                {
                    use rustix::fs::{RenameFlags, renameat_with};
                    use rustix::io::Errno;
                    match renameat_with(folder, from, folder, to, RenameFlags::NOREPLACE) {
                        // File systems that do not know it.
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

/// Elsewhere a folder with an open file in it does not move.
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

        /// Makes a file where there is none of this name.
        pub fn create(&self, name: &OsStr) -> Result<File> {
            OpenOptions::new().read(true).write(true).create_new(true).open(self.path.join(name))
        }

        /// Opens a file to write, and makes it where there is none.
        pub fn open_or_create(&self, name: &OsStr) -> Result<File> {
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(self.path.join(name))
        }

        /// What stands under a name; none if nothing does.
        pub fn entry(&self, name: &OsStr) -> Option<EntryKind> {
            let path = self.path.join(name);
            path.symlink_metadata().ok()?;
            Some(match path.metadata() {
                Ok(file) if file.is_file() => EntryKind::File,
                Ok(_) => EntryKind::Other,
                Err(_) => EntryKind::Dangling,
            })
        }

        /// Whether an open file is the one of this name: it is not removed.
        pub fn holds(&self, name: &OsStr, _: &File) -> bool {
            self.path.join(name).exists()
        }

        /// Gives a file another name, and with `force` takes that from one that has it.
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
