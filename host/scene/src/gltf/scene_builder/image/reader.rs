//! Reader of the images of a document.

use std::path::Path;

use crate::gltf::document::Document;
use crate::gltf::document::sections::JsonImage;

/// Reader of the images of a document.
#[derive(Clone, Copy)]
pub struct ImageReader<'a> {
    /// The document.
    pub document: &'a Document,
    /// Folder of the document.
    pub folder: &'a Path,
}

impl<'a> ImageReader<'a> {
    /// Looks an image up.
    pub fn get(&self, index: usize) -> Result<&'a JsonImage, String> {
        let images = &self.document.sections.images;
        images.get(index).ok_or_else(|| format!("is not there: there are {}", images.len()))
    }
}
