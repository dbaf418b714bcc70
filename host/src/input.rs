//! Files of others, read whole: regular files only, since pipes and devices may never end, and up to a size.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Most bytes of a text: an experiment, a result, a table.
pub const TEXT: u64 = 1 << 28;
/// Most bytes of a picture, or of what a run goes on from: the largest frame with all its layers.
pub const PICTURE: u64 = 1 << 33;

/// Reads a regular file of at most `most` bytes.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    let refuse = |what: String| Err(Error::new(ErrorKind::InvalidInput, what));
    // Asked before it is opened: to open a pipe is to wait for who writes into it.
    if !std::fs::metadata(path)?.is_file() {
        return refuse("it is not a file".into());
    }
    let file = File::open(path)?;
    let length = file.metadata()?.len();
    let mut bytes = Vec::new();
    if length <= most {
        bytes.try_reserve_exact(length as usize)?;
        // A file may grow, and what the system makes up under /proc has no true length.
        file.take(most + 1).read_to_end(&mut bytes)?;
    }
    if length.max(bytes.len() as u64) > most {
        return refuse(format!("it has more than {most} bytes"));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_up_to_a_size_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "12345").unwrap();
        assert_eq!(read(&path, 5).unwrap(), b"12345");
        assert!(read(&path, 4).unwrap_err().to_string().contains("more than 4 bytes"));
        assert_eq!(read(folder.path(), 5).unwrap_err().kind(), ErrorKind::InvalidInput);
        assert_eq!(read(&folder.path().join("b"), 5).unwrap_err().kind(), ErrorKind::NotFound);
        if cfg!(unix) {
            assert!(read(Path::new("/dev/zero"), 5).unwrap_err().to_string().contains("not a file"));
        }
    }
}
