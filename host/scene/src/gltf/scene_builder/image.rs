//! Images of a document, however they come about: files, images that are converted, vertex colours.

use std::path::Path;

use crate::gltf::document::Document;
use crate::gltf::document::sections::{ImageContent, JsonImage};
use crate::texture::Image;

mod basis;
mod converted;
mod encoded;

/// Reader of the images of a document.
#[derive(Clone, Copy)]
pub struct ImageReader<'a> {
    /// The document.
    pub document: &'a Document,
    /// Folder of the document.
    pub folder: &'a Path,
}

impl<'a> ImageReader<'a> {
    /// Width and height of an image (texels), by its header. An error says what is wrong with it.
    pub fn size(&self, index: usize) -> Result<(u32, u32), String> {
        match &self.get(index)?.content {
            ImageContent::Converted(image) => converted::size(self, image),
            ImageContent::VertexColors(image) => Ok((image.width, image.height)),
            content => encoded::size(self, content),
        }
    }

    /// Reads an image.
    pub fn read(&self, index: usize) -> Result<Image, String> {
        match &self.get(index)?.content {
            ImageContent::Converted(image) => converted::read(self, image),
            ImageContent::VertexColors(image) => Ok(image.clone()),
            content => encoded::read(self, content),
        }
    }

    fn get(&self, index: usize) -> Result<&'a JsonImage, String> {
        let images = &self.document.sections.images;
        images.get(index).ok_or_else(|| format!("is not there: there are {}", images.len()))
    }
}
