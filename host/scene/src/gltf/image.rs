//! Images of a document, however they come about.

use serde_json::Value;

use super::atlas::BAKED;
use super::document::Document;
use super::translate::specular_glossiness::SOURCE;
use crate::texture::Image;

mod basis;
mod converted;
mod encoded;

/// Width and height of an image of the document [texels]: nothing is decoded. An error says what is wrong with it.
pub fn size(document: &Document, index: u64) -> Result<(u32, u32), String> {
    let image = encoded::described(document, index)?;
    match (image.get(SOURCE), baked(document, image)) {
        (Some(source), _) => converted::size(document, source),
        (None, Some(baked)) => Ok((baked.width, baked.height)),
        (None, None) => encoded::size(document, image),
    }
}

/// An image of the document.
pub fn read(document: &Document, index: u64) -> Result<Image, String> {
    let image = encoded::described(document, index)?;
    match (image.get(SOURCE), baked(document, image)) {
        (Some(source), _) => converted::read(document, source),
        (None, Some(baked)) => Ok(baked.clone()),
        (None, None) => encoded::read(document, image),
    }
}

/// An image that is made of vertex colours.
fn baked<'a>(document: &'a Document, image: &Value) -> Option<&'a Image> {
    document.baked.get(usize::try_from(image[BAKED].as_u64()?).ok()?)
}
