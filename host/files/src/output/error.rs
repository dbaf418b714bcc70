//! What can go wrong while an image is encoded.

/// Why an image cannot be encoded.
#[derive(Debug, thiserror::Error)]
pub enum EncodeError {
    /// There are not `width * height` colours.
    #[error("an image of {width} x {height} pixels has {colors} colours")]
    Size {
        /// Width (px).
        width: u32,
        /// Height (px).
        height: u32,
        /// Colours that were given.
        colors: usize,
    },
    /// PNG.
    #[error("encoding PNG")]
    Png(#[from] image::ImageError),
    /// EXR.
    #[error("encoding EXR")]
    Exr(#[from] exr::error::Error),
    /// Bytes that are no EXR file of ours.
    #[error("an EXR header has {0}")]
    Header(&'static str),
}
