//! Images that lie in a file or a buffer: PNG, JPEG, WebP and KTX 2.0.

use std::borrow::Cow;
use std::io::Cursor;
use std::panic::UnwindSafe;

use image::{ImageFormat, ImageReader, ImageResult, Limits};
use serde_json::Value;

use super::basis;
use crate::gltf::buffer;
use crate::gltf::document::Document;
use crate::texture::{Image, MAX_SIDE};
use caustics_files::caught::decoded;

/// Most memory that decoding an image may take (bytes): the largest image at eight bytes a texel.
const MAX_BYTES: u64 = 8 * (MAX_SIDE as u64) * (MAX_SIDE as u64);

/// What a document says of an image.
pub fn described(document: &Document, index: u64) -> Result<&Value, String> {
    let images = &document.sections.images;
    images.get(index as usize).ok_or_else(|| format!("is not there: there are {}", images.len()))
}

/// Width and height of an image by its header [texels].
pub fn size(document: &Document, image: &Value) -> Result<(u32, u32), String> {
    let bytes = bytes(document, image)?;
    if basis::is_ktx(&bytes) {
        return check_size(basis::size(&bytes)?);
    }
    check_size(decode(&bytes, ImageReader::into_dimensions)?)
}

/// An image.
pub fn read(document: &Document, image: &Value) -> Result<Image, String> {
    let bytes = bytes(document, image)?;
    if basis::is_ktx(&bytes) {
        check_size(basis::size(&bytes)?)?;
        return basis::read(&bytes);
    }
    let image = decode(&bytes, ImageReader::decode)?.into_rgba8();
    let (width, height) = check_size(image.dimensions())?;
    Ok(Image { width, height, texels: image.pixels().map(|pixel| pixel.0).collect() })
}

/// Bytes of an image that a document describes.
fn bytes<'a>(document: &'a Document, image: &Value) -> Result<Cow<'a, [u8]>, String> {
    let Document { sections, buffers, folder, .. } = document;
    match (image["uri"].as_str(), image["bufferView"].as_u64()) {
        (Some(uri), _) => buffer::fetch(uri, folder, u64::MAX).map(Cow::Owned),
        (None, Some(view)) => buffer::view_bytes(view, &sections.buffer_views, buffers).map(Cow::Borrowed),
        (None, None) => Err("has neither a uri nor a bufferView".into()),
    }
}

/// Result of a decoder that is given these bytes. image-webp 0.2.4 panics at some damaged animations.
fn decode<'a, T>(
    bytes: &'a [u8],
    decode: impl FnOnce(ImageReader<Cursor<&'a [u8]>>) -> ImageResult<T> + UnwindSafe,
) -> Result<T, String> {
    decoded(
        || decode(reader(bytes)?).map_err(|error| damaged(&error)),
        "cannot be decoded: its data are damaged",
    )
}

fn damaged(error: &dyn std::fmt::Display) -> String {
    format!("cannot be decoded: {error}")
}

fn reader(bytes: &[u8]) -> Result<ImageReader<Cursor<&[u8]>>, String> {
    let mut reader =
        ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| damaged(&error))?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) {
        return Err("is no PNG, JPEG, WebP or KTX 2.0".into());
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
