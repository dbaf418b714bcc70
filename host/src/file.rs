//! Reads whole files that others made.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

use crate::memory;

/// Files from this size on are compared with the memory that is there (bytes).
const LARGE: u64 = 1 << 24;

/// The bytes of a regular file. Refuses pipes and devices, which may never end, and files that memory does not hold: every
/// file that a person names is read by this or by [`read_text`].
pub fn read_file(path: &Path) -> Result<Vec<u8>> {
    read_head(path, u64::MAX)
}

/// Reads at most this many bytes of a file, from its beginning.
pub fn read_head(path: &Path, most: u64) -> Result<Vec<u8>> {
    // Opening a pipe would wait for who writes it.
    if !std::fs::metadata(path)?.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, "it is not a file"));
    }
    let file = File::open(path)?;
    let length = file.metadata()?.len().min(most);
    if length > LARGE
        && let Some(available) = memory::available().filter(|&available| length > available)
    {
        let (length, available) = (memory::shown(length), memory::shown(available));
        let what = format!("it has {length}, but {available} of memory are available");
        return Err(Error::new(ErrorKind::OutOfMemory, what));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length as usize)?;
    file.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a regular file.
pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read_file(path)?).map_err(|_| Error::new(ErrorKind::InvalidData, "it is no UTF-8 text"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "abc").unwrap();
        assert_eq!(read_file(&path).unwrap(), b"abc");
        assert_eq!(read_text(&path).unwrap(), "abc");
        assert_eq!(read_head(&path, 2).unwrap(), b"ab");
        std::fs::write(&path, b"\xFF").unwrap();
        assert_eq!(read_text(&path).unwrap_err().kind(), ErrorKind::InvalidData);
        assert!(read_file(folder.path()).is_err());
        assert_eq!(read_file(&folder.path().join("b")).unwrap_err().kind(), ErrorKind::NotFound);
        #[cfg(unix)]
        assert_eq!(read_file(Path::new("/dev/zero")).unwrap_err().kind(), ErrorKind::InvalidInput);
    }

    #[test]
    fn a_file_beyond_memory_is_refused_before_it_is_read() {
        // A sparse file: it has a length and takes no room.
        let file = tempfile::NamedTempFile::new().unwrap();
        if file.as_file().set_len(1 << 50).is_err() || memory::available().is_none() {
            return; // The file system has a lower limit, or the system says nothing of its memory.
        }
        let error = read_file(file.path()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::OutOfMemory);
        assert!(error.to_string().contains("are available"), "{error}");
    }
}
