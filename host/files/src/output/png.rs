//! PNG files of display colours, eight bits a channel.

use glam::Vec3;
use image::{ImageFormat, RgbImage};

use super::EncodeError;

/// Encodes display colours in [0, 1], row by row from the top, as the bytes of a PNG file (see `Session::display`).
///
/// # Errors
///
/// If the number of colours differs from `width * height`.
pub fn encode(width: u32, height: u32, colors: &[Vec3]) -> Result<Vec<u8>, EncodeError> {
    let bytes = colors.iter().flat_map(|color| (*color * 255.0 + 0.5).to_array()).map(|value| value as u8);
    let wrong_size = || EncodeError::Size { width, height, colors: colors.len() };
    let image = RgbImage::from_raw(width, height, bytes.collect()).ok_or_else(wrong_size)?;
    let mut out = std::io::Cursor::new(Vec::new());
    image.write_to(&mut out, ImageFormat::Png)?;
    Ok(out.into_inner())
}
