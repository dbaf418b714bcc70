//! Packet of an image for a page.

use std::borrow::Cow;
use std::time::Instant;

use jpeg_encoder::{Encoder, ImageBuffer, JpegColorType, rgb_to_ycbcr};
use serde_json::json;

use super::line::Format;
use super::look::{Look, Raster};
use super::shared::PageFrame;

/// Encodes an image: the length of a head in four bytes, the head in JSON, the bytes of the image.
pub fn packet(frame: &PageFrame, side: usize, look: Look, format: Format) -> Vec<u8> {
    let start = Instant::now();
    let raster = look.raster(&frame.shown);
    let (kind, bytes) = encoded(&raster, format);
    let head = json!({
        "side": side, "serial": frame.serial, "samples": frame.samples, "moves": frame.moves, "at": frame.at,
        "width": raster.width, "height": raster.height, "format": kind, "stops": raster.stops,
        "brightest": raster.brightest, "encode_ms": start.elapsed().as_secs_f64() * 1e3,
    })
    .to_string();
    let mut packet = Vec::with_capacity(4 + head.len() + bytes.len());
    packet.extend((head.len() as u32).to_le_bytes());
    packet.extend(head.as_bytes());
    packet.extend(bytes.as_ref());
    packet
}

/// Returns the name of the encoding, and the bytes.
fn encoded(raster: &Raster, format: Format) -> (&'static str, Cow<'_, [u8]>) {
    let raw = ("raw", Cow::from(&raster.bytes));
    let Format::Jpeg(quality) = format else { return raw };
    let [Ok(width), Ok(height)] = [raster.width, raster.height].map(u16::try_from) else { return raw };
    let mut bytes = Vec::new();
    let encoder = Encoder::new(&mut bytes, quality);
    match encoder.encode_image(Rgb { width, height, bytes: &raster.bytes }) {
        Ok(()) => ("jpeg", bytes.into()),
        Err(_) => raw,
    }
}

/// An image for the encoder, whose own `encode` would be compiled for every pixel format.
struct Rgb<'a> {
    width: u16,
    height: u16,
    bytes: &'a [u8],
}

impl ImageBuffer for Rgb<'_> {
    fn get_jpeg_color_type(&self) -> JpegColorType {
        JpegColorType::Ycbcr
    }
    fn width(&self) -> u16 {
        self.width
    }
    fn height(&self) -> u16 {
        self.height
    }
    fn fill_buffers(&self, row: u16, [y, cb, cr, _]: &mut [Vec<u8>; 4]) {
        let width = usize::from(self.width);
        let row = &self.bytes.as_chunks::<3>().0[usize::from(row) * width..][..width];
        y.extend(row.iter().map(|&[r, g, b]| rgb_to_ycbcr(r, g, b).0));
        cb.extend(row.iter().map(|&[r, g, b]| rgb_to_ycbcr(r, g, b).1));
        cr.extend(row.iter().map(|&[r, g, b]| rgb_to_ycbcr(r, g, b).2));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jpeg_decodes_to_the_image() {
        let [width, height] = [40, 24];
        let color = |x: u32, y: u32| [6 * x as u8, 10 * y as u8, 200 - 3 * x as u8];
        let bytes = (0..width * height).flat_map(|i| color(i % width, i / width)).collect();
        let raster = Raster { width, height, bytes, ..Raster::default() };
        let (kind, jpeg) = encoded(&raster, Format::Jpeg(95));
        assert_eq!(kind, "jpeg");
        let decoded = image::load_from_memory(&jpeg).unwrap().into_rgb8();
        assert_eq!(decoded.dimensions(), (width, height));
        for (shown, sent) in decoded.as_raw().iter().zip(&raster.bytes) {
            assert!(shown.abs_diff(*sent) <= 12, "{shown} for {sent}");
        }
        assert_eq!(encoded(&raster, Format::Raw).1, raster.bytes);
    }
}
