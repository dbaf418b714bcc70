//! Textures, samplers and images.

use serde::{Deserialize, Deserializer};
use serde_json::Value;

use crate::gltf::checked_json::translate::specular_glossiness::ConvertedImage;
use crate::texture::Image;

/// Texture.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct JsonTexture {
    /// Index of the image.
    pub source: Option<usize>,
    /// Index of the sampler.
    pub sampler: Option<usize>,
}

/// Sampler of textures.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct JsonSampler {
    /// Wrap along u, in OpenGL's codes.
    pub wrap_s: Option<u32>,
    /// Wrap along v.
    pub wrap_t: Option<u32>,
    /// Magnification filter.
    pub mag_filter: Option<u32>,
}

/// Image.
#[derive(Debug, Deserialize)]
#[serde(from = "RawImage")]
pub struct JsonImage {
    /// Name.
    pub name: Option<String>,
    /// Source of the texels.
    pub content: ImageContent,
}

/// Source of the texels of an image.
#[derive(Debug)]
pub enum ImageContent {
    /// File, or data URI.
    Uri(String),
    /// File in a buffer view.
    View(usize),
    /// Conversion of specular-glossiness images.
    Converted(ConvertedImage),
    /// Vertex colours.
    VertexColors(Image),
    /// Missing in the document.
    Missing,
}

/// Image as written in the JSON.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct RawImage {
    #[serde(default, deserialize_with = "text")]
    name: Option<String>,
    uri: Option<String>,
    buffer_view: Option<usize>,
    /// Member that the translation adds.
    specular_glossiness: Option<ConvertedImage>,
}

impl From<RawImage> for JsonImage {
    fn from(image: RawImage) -> JsonImage {
        let content = match (image.specular_glossiness, image.uri, image.buffer_view) {
            (Some(converted), ..) => ImageContent::Converted(converted),
            (None, Some(uri), _) => ImageContent::Uri(uri),
            (None, None, Some(view)) => ImageContent::View(view),
            (None, None, None) => ImageContent::Missing,
        };
        JsonImage { name: image.name, content }
    }
}

/// Reads a name; other types than text give `None`.
fn text<'de, D: Deserializer<'de>>(member: D) -> Result<Option<String>, D::Error> {
    Ok(match Value::deserialize(member)? {
        Value::String(text) => Some(text),
        _ => None,
    })
}
