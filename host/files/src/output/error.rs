//! Errors of encoding an image.

/// Error of encoding an image.
#[derive(Debug, thiserror::Error)]
pub enum EncodeError {
    /// The number of colours differs from `width * height`.
    #[error("an image of {width} x {height} pixels has {colors} colours")]
    Size {
        /// Width (px).
        width: u32,
        /// Height (px).
        height: u32,
        /// Number of colours given.
        colors: usize,
    },
    /// The encoder of PNG failed.
    #[error("encoding PNG")]
    Png(#[from] image::ImageError),
    /// The encoder of EXR failed.
    #[error("encoding EXR")]
    Exr(#[from] exr::error::Error),
    /// The bytes are not an EXR file of this program.
    #[error("an EXR header has {0}")]
    Header(&'static str),
}
