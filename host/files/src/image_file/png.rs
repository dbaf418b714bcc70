//! Decodes PNG files to display colours.

use std::io::Cursor;

use image::{ImageFormat, ImageReader};

use super::channels::{Channels, Encoding};
use super::limit::check_samples;
use crate::caught::decoded;

/// The first bytes of a file.
pub const MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Memory that reading one of a texel's three colours takes (bytes), rounded up. Measured: 11.5 to 12.1.
const SAMPLE_BYTES: u64 = 13;

/// Decodes a PNG file of any colour type to `R`, `G`, `B` in [0, 1]. An alpha channel is dropped.
pub fn decode(bytes: &[u8]) -> Result<Channels, String> {
    decoded(|| decode_file(bytes), "it cannot be read as PNG: its data are damaged")
}

fn decode_file(bytes: &[u8]) -> Result<Channels, String> {
    let wrong = |error| format!("it cannot be read as PNG: {error}");
    let reader = || ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let (width, height) = reader().into_dimensions().map_err(wrong)?;
    check_samples(3 * u128::from(width) * u128::from(height), SAMPLE_BYTES)?;
    let image = reader().decode().map_err(wrong)?.into_rgb32f();
    let channel = |channel: usize| image.pixels().map(|pixel| pixel.0[channel]).collect();
    Ok(Channels {
        width: image.width() as usize,
        height: image.height() as usize,
        channels: ["R", "G", "B"]
            .into_iter()
            .zip([channel(0), channel(1), channel(2)])
            .map(|(n, v)| (n.into(), v))
            .collect(),
        encoding: Encoding::Srgb,
        ..Channels::default()
    })
}
