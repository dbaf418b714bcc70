//! PNG to display colours.

use image::ImageFormat;

use super::{Channels, Encoding};

/// The first bytes of a file.
pub const MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Decodes a PNG file of any colour type to `R`, `G`, `B` in [0, 1]; an alpha channel is left out.
pub fn decode(bytes: &[u8]) -> Result<Channels, String> {
    let picture = image::load_from_memory_with_format(bytes, ImageFormat::Png)
        .map_err(|error| format!("it cannot be read as PNG: {error}"))?
        .into_rgb32f();
    let lane = |lane: usize| picture.pixels().map(|pixel| pixel.0[lane]).collect();
    Ok(Channels {
        width: picture.width() as usize,
        height: picture.height() as usize,
        channels: ["R", "G", "B"]
            .into_iter()
            .zip([lane(0), lane(1), lane(2)])
            .map(|(n, v)| (n.into(), v))
            .collect(),
        encoding: Encoding::Srgb,
        ..Channels::default()
    })
}
