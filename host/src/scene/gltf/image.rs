//! Images: PNG and JPEG, in files, in the document and in buffers.

use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;

use image::{ImageFormat, ImageReader, Limits};
use serde_json::Value;

use super::buffer;
use crate::scene::texture::{Image, MAX_SIDE};

/// Most memory that decoding an image may take (bytes): the largest image at eight bytes a texel.
const MAX_BYTES: u64 = 8 * (MAX_SIDE as u64) * (MAX_SIDE as u64);

/// Bytes of an image that a document describes. An error says what is wrong with it.
fn bytes<'a>(
    image: &Value,
    views: &[Value],
    buffers: &'a [Vec<u8>],
    folder: &Path,
) -> Result<Cow<'a, [u8]>, String> {
    match (image["uri"].as_str(), image["bufferView"].as_u64()) {
        (Some(uri), _) => buffer::fetch(uri, folder, u64::MAX).map(Cow::Owned),
        (None, Some(view)) => view_bytes(view, views, buffers).map(Cow::Borrowed),
        (None, None) => Err("has neither a uri nor a bufferView".into()),
    }
}

/// Width and height of an image by its header [texels]: nothing is decoded.
pub fn size(
    image: &Value,
    views: &[Value],
    buffers: &[Vec<u8>],
    folder: &Path,
) -> Result<(u32, u32), String> {
    let bytes = bytes(image, views, buffers, folder)?;
    check_size(reader(&bytes)?.into_dimensions().map_err(|error| damaged(&error))?)
}

/// The image that a document describes.
pub fn read(image: &Value, views: &[Value], buffers: &[Vec<u8>], folder: &Path) -> Result<Image, String> {
    let bytes = bytes(image, views, buffers, folder)?;
    let image = reader(&bytes)?.decode().map_err(|error| damaged(&error))?.into_rgba8();
    let (width, height) = check_size(image.dimensions())?;
    Ok(Image { width, height, texels: image.pixels().map(|pixel| pixel.0).collect() })
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

fn damaged(error: &dyn std::fmt::Display) -> String {
    format!("cannot be decoded: {error}")
}

fn reader(bytes: &[u8]) -> Result<ImageReader<Cursor<&[u8]>>, String> {
    let mut reader =
        ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| damaged(&error))?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Err("is neither a PNG nor a JPEG".into());
    }
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    limits.max_alloc = Some(MAX_BYTES);
    reader.limits(limits);
    Ok(reader)
}

fn check_size((width, height): (u32, u32)) -> Result<(u32, u32), String> {
    let within = |side: u32| (1..=MAX_SIDE).contains(&side);
    if within(width) && within(height) {
        return Ok((width, height));
    }
    Err(format!("is of {width} x {height} texels; each side must be 1 to {MAX_SIDE}"))
}
