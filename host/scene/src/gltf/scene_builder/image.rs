//! Images of a document: files, converted images, and vertex colours.

use crate::gltf::document::sections::ImageContent;
use crate::texture::Image;

pub use self::reader::ImageReader;

mod basis;
mod converted;
mod encoded;
mod reader;

impl ImageReader<'_> {
    /// Width and height of an image (texels), from its header. An error describes the fault.
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
}
