//! A file that appears whole or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use tempfile::NamedTempFile;
use thiserror::Error;

/// Why a file cannot be written.
#[derive(Debug, Error)]
pub enum TargetError {
    /// It is there already.
    #[error("{} exists; give --force to overwrite it", .0.display())]
    Exists(PathBuf),
    /// Its folder cannot be written.
    #[error("cannot write {}: {source}; choose another -o, or create the folder", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}

/// A file to be, claimed before any work is done for it.
#[derive(Debug)]
pub struct Target {
    path: PathBuf,
    force: bool,
    part: NamedTempFile,
}

impl Target {
    /// Checks that `path` may be written and opens a temporary file beside it.
    pub fn claim(path: &Path, force: bool) -> Result<Target, TargetError> {
        let path = path.to_path_buf();
        // A device or a pipe is nobody's to replace.
        if path.exists() && (!force || !path.is_file()) {
            return Err(TargetError::Exists(path));
        }
        let folder = match path.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        match tempfile::Builder::new().prefix(".caustics-").tempfile_in(folder) {
            Ok(part) => Ok(Target { path, force, part }),
            Err(source) => Err(TargetError::Write { path, source }),
        }
    }

    /// Writes the bytes and puts the file in its place.
    pub fn finish(mut self, bytes: &[u8]) -> Result<(), TargetError> {
        let fail = |path: &Path, source| TargetError::Write { path: path.into(), source };
        self.part.write_all(bytes).map_err(|source| fail(&self.path, source))?;
        // A name must not be there before its bytes are, whatever happens to the machine.
        self.part.as_file().sync_all().map_err(|source| fail(&self.path, source))?;
        #[cfg(unix)]
        {
            // Temporary files are private; pictures are as public as any other new file.
            use std::os::unix::fs::PermissionsExt;
            let public = std::fs::Permissions::from_mode(0o644);
            self.part.as_file().set_permissions(public).map_err(|source| fail(&self.path, source))?;
        }
        let done =
            if self.force { self.part.persist(&self.path) } else { self.part.persist_noclobber(&self.path) };
        done.map(drop).map_err(|error| match error.error.kind() {
            std::io::ErrorKind::AlreadyExists => TargetError::Exists(self.path),
            _ => fail(&self.path, error.error),
        })
    }
}

/// Removes a file; one that is not there is no failure.
pub fn remove(path: &Path) -> anyhow::Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("cannot remove {}", path.display()))
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
    }
}
