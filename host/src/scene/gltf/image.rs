//! Images: PNG and JPEG, in files, in the document and in buffers.

use std::io::Cursor;
use std::path::Path;

use image::{ImageFormat, ImageReader, Limits};
use serde_json::Value;

use super::buffer;
use crate::scene::texture::{Image, LARGEST_SIDE};

/// Most memory that decoding an image may take [bytes]: the largest image at eight bytes a texel.
const MOST_BYTES: u64 = 8 * (LARGEST_SIDE as u64) * (LARGEST_SIDE as u64);

/// The image that a document describes. An error says what is wrong with it.
pub fn read(image: &Value, views: &[Value], buffers: &[Vec<u8>], folder: &Path) -> Result<Image, String> {
    let bytes = match (image["uri"].as_str(), image["bufferView"].as_u64()) {
        (Some(uri), _) => buffer::fetch(uri, folder)?,
        (None, Some(view)) => view_bytes(view, views, buffers)?.to_vec(),
        (None, None) => return Err("has neither a uri nor a bufferView".into()),
    };
    decode(&bytes)
}

/// Bytes of a buffer view.
fn view_bytes<'a>(index: u64, views: &[Value], buffers: &'a [Vec<u8>]) -> Result<&'a [u8], String> {
    let view = views
        .get(index as usize)
        .ok_or_else(|| format!("refers to buffer view {index}, but there are {}", views.len()))?;
    let number = |key: &str| view[key].as_u64().unwrap_or(0);
    let buffer = buffers
        .get(number("buffer") as usize)
        .ok_or_else(|| format!("refers to buffer {}, but there are {}", number("buffer"), buffers.len()))?;
    let start = number("byteOffset");
    let end = start.saturating_add(number("byteLength"));
    if end > buffer.len() as u64 {
        return Err(format!("needs {end} bytes of a buffer of {}", buffer.len()));
    }
    Ok(&buffer[start as usize..end as usize])
}

fn decode(bytes: &[u8]) -> Result<Image, String> {
    let damaged = |error: &dyn std::fmt::Display| format!("cannot be decoded: {error}");
    let mut reader =
        ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| damaged(&error))?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Err("is neither a PNG nor a JPEG".into());
    }
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(LARGEST_SIDE), Some(LARGEST_SIDE));
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let image = reader.decode().map_err(|error| damaged(&error))?.into_rgba8();
    let (width, height) = image.dimensions();
    if width == 0 || height == 0 || width > LARGEST_SIDE || height > LARGEST_SIDE {
        return Err(format!("is of {width} x {height} texels; each side must be 1 to {LARGEST_SIDE}"));
    }
    Ok(Image { width, height, texels: image.pixels().map(|pixel| pixel.0).collect() })
}
