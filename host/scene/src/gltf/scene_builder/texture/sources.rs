//! Textures that materials refer to, each once for a role, and their images.

use std::collections::HashMap;

use caustics_kernels::interface::texture::{WRAP_CLAMP, WRAP_MIRRORED, WRAP_REPEAT};

use crate::SceneError;
use crate::gltf::context::ImportContext;
use crate::gltf::document::Document;
use crate::gltf::document::sections::{ImageContent, JsonSampler};
use crate::texture::{ImageTexture, Role};

/// Textures and images found so far.
#[derive(Default)]
pub struct TextureSources {
    /// Textures.
    pub textures: Vec<ImageTexture>,
    /// Index in the document of each image.
    pub images: Vec<usize>,
    /// Indices of the textures, by the document's index and the role.
    known: HashMap<(usize, Role), u32>,
}

impl TextureSources {
    /// Index of a texture in a role.
    pub fn texture(
        &mut self,
        document: &Document,
        context: &ImportContext<'_>,
        index: usize,
        role: Role,
        owner: &str,
    ) -> Result<u32, SceneError> {
        if let Some(&known) = self.known.get(&(index, role)) {
            return Ok(known);
        }
        let sections = &document.sections;
        let missing = |owner: &str, kind, index, count| context.index_error(owner, kind, index, count);
        let texture = sections.textures.get(index);
        let texture = texture.ok_or_else(|| missing(owner, "texture", index, sections.textures.len()))?;
        let owner = format!("texture {index}");
        let source = texture
            .source
            .ok_or_else(|| context.document_error(format_args!("{owner} has no image as its source")))?;
        let image = sections.images.get(source);
        let image = image.ok_or_else(|| missing(&owner, "image", source, sections.images.len()))?;
        let sampler = match texture.sampler {
            Some(sampler) => sections
                .samplers
                .get(sampler)
                .ok_or_else(|| missing(&owner, "sampler", sampler, sections.samplers.len()))?,
            None => &JsonSampler::default(),
        };
        // Neighbours on images of vertex colours need not be neighbours on the surface, so only the finest level is valid.
        let finest = matches!(image.content, ImageContent::VertexColors(_));
        let (wrap, nearest) =
            ([wrap(sampler.wrap_s), wrap(sampler.wrap_t)], sampler.mag_filter == Some(NEAREST));
        let image = self.image(source);
        self.textures.push(ImageTexture { image, role, wrap, nearest, finest });
        let id = self.textures.len() as u32 - 1;
        self.known.insert((index, role), id);
        Ok(id)
    }

    /// Index of an image of the document.
    fn image(&mut self, source: usize) -> usize {
        let known = self.images.iter().position(|&known| known == source);
        known.unwrap_or_else(|| {
            self.images.push(source);
            self.images.len() - 1
        })
    }
}

/// OpenGL's code of the nearest filter.
const NEAREST: u32 = 9728;

/// Wrap for an OpenGL code.
fn wrap(code: Option<u32>) -> u32 {
    match code {
        Some(33071) => WRAP_CLAMP,
        Some(33648) => WRAP_MIRRORED,
        _ => WRAP_REPEAT,
    }
}
