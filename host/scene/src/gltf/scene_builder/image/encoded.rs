//! Images in files and buffers: PNG, JPEG, WebP and KTX 2.0.

use std::borrow::Cow;
use std::io::Cursor;
use std::panic::UnwindSafe;

use image::{ImageFormat, ImageReader as Decoder, ImageResult, Limits};

use super::basis;
use super::reader::ImageReader;
use crate::gltf::document::buffer;
use crate::gltf::document::sections::ImageContent;
use crate::texture::{Image, MAX_SIDE};
use caustics_files::caught::decoded;

/// Maximum memory for decoding an image (bytes): the largest image at eight bytes a texel.
const MAX_BYTES: u64 = 8 * (MAX_SIDE as u64) * (MAX_SIDE as u64);

/// Width and height of an image, from its header (texels).
pub fn size(reader: &ImageReader<'_>, content: &ImageContent) -> Result<(u32, u32), String> {
    let bytes = bytes(reader, content)?;
    if basis::is_ktx(&bytes) {
        return check_size(basis::size(&bytes)?);
    }
    check_size(decode(&bytes, Decoder::into_dimensions)?)
}

/// Decodes an image.
pub fn read(reader: &ImageReader<'_>, content: &ImageContent) -> Result<Image, String> {
    let bytes = bytes(reader, content)?;
    if basis::is_ktx(&bytes) {
        check_size(basis::size(&bytes)?)?;
        return basis::read(&bytes);
    }
    let image = decode(&bytes, Decoder::decode)?.into_rgba8();
    let (width, height) = check_size(image.dimensions())?;
    Ok(Image { width, height, texels: image.pixels().map(|pixel| pixel.0).collect() })
}

/// Bytes of an image's file.
fn bytes<'a>(reader: &ImageReader<'a>, content: &ImageContent) -> Result<Cow<'a, [u8]>, String> {
    match content {
        ImageContent::Uri(uri) => buffer::fetch(uri, reader.folder, u64::MAX).map(Cow::Owned),
        ImageContent::View(view) => reader.document.view_bytes(*view).map(Cow::Borrowed),
        _ => Err("has neither a uri nor a bufferView".into()),
    }
}

/// Runs a decoder on a file's bytes. image-webp 0.2.4 panics at some damaged animations.
fn decode<'a, T>(
    bytes: &'a [u8],
    decode: impl FnOnce(Decoder<Cursor<&'a [u8]>>) -> ImageResult<T> + UnwindSafe,
) -> Result<T, String> {
    decoded(
        || decode(reader(bytes)?).map_err(|error| damaged(&error)),
        "cannot be decoded: its data are damaged",
    )
}

fn damaged(error: &dyn std::fmt::Display) -> String {
    format!("cannot be decoded: {error}")
}

fn reader(bytes: &[u8]) -> Result<Decoder<Cursor<&[u8]>>, String> {
    let mut reader =
        Decoder::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| damaged(&error))?;
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
