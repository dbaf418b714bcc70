//! Textures, samplers and images.

use serde::{Deserialize, Deserializer};
use serde_json::Value;

use crate::gltf::checked_json::translate::specular_glossiness::ConvertedImage;
use crate::texture::Image;

/// Texture.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct JsonTexture {
    /// Index of its image.
    pub source: Option<usize>,
    /// Index of its sampler.
    pub sampler: Option<usize>,
}

/// Sampler of textures.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct JsonSampler {
    /// Wrap along u, as OpenGL numbers it.
    pub wrap_s: Option<u32>,
    /// Wrap along v.
    pub wrap_t: Option<u32>,
    /// Filter of magnified texels.
    pub mag_filter: Option<u32>,
}

/// Image.
#[derive(Debug, Deserialize)]
#[serde(from = "RawImage")]
pub struct JsonImage {
    /// Name.
    pub name: Option<String>,
    /// Origin of its texels.
    pub content: ImageContent,
}

/// Origin of the texels of an image.
#[derive(Debug)]
pub enum ImageContent {
    /// File, or data in the document.
    Uri(String),
    /// File in a buffer view.
    View(usize),
    /// Images of specular-glossiness.
    Converted(ConvertedImage),
    /// Vertex colours.
    VertexColors(Image),
    /// None that the document names.
    Missing,
}

/// Image as it stands in the JSON.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct RawImage {
    #[serde(default, deserialize_with = "text")]
    name: Option<String>,
    uri: Option<String>,
    buffer_view: Option<usize>,
    /// Member that the translation sets.
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

/// Reads a name, anything else than text as none.
fn text<'de, D: Deserializer<'de>>(member: D) -> Result<Option<String>, D::Error> {
    Ok(match Value::deserialize(member)? {
        Value::String(text) => Some(text),
        _ => None,
    })
}
