//! Reads images back: the channels of an EXR file, or the colours of a PNG file.

mod channels;
mod exr;
mod limit;
mod png;

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::file::read_file;

pub use self::channels::{Channels, Encoding};

/// Error of reading an image file.
#[derive(Debug, Error)]
pub enum ImageError {
    /// The system cannot read the file.
    #[error("cannot read {}: {source}; check the path", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The file is neither EXR nor PNG, or it is damaged.
    #[error("{}: {what}; give a flat EXR file or a PNG file", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Description of the damage.
        what: String,
    },
}

impl Channels {
    /// Reads a flat EXR file with any channels (16 or 32 bits), or a PNG file as `R`, `G`, `B`. The first bytes decide
    /// between the formats.
    pub fn read(path: &Path) -> Result<Channels, ImageError> {
        let read = read_file(path);
        let bytes = read.map_err(|source| ImageError::Read { path: path.into(), source })?;
        Channels::decode(&bytes).map_err(|what| ImageError::Damaged { path: path.into(), what })
    }

    /// Decodes the bytes of an EXR or PNG file, as [`Channels::read`] does.
    ///
    /// # Errors
    ///
    /// If the bytes are neither format, are damaged, or would take more memory than is available. The text names the cause.
    pub fn decode(bytes: &[u8]) -> Result<Channels, String> {
        if bytes.starts_with(&exr::MAGIC) {
            exr::decode(bytes)
        } else if bytes.starts_with(png::MAGIC) {
            png::decode(bytes)
        } else {
            Err("it is neither an EXR nor a PNG file".into())
        }
    }
}

#[cfg(test)]
mod tests;
