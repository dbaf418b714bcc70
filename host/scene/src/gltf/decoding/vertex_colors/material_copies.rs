//! Copies of materials, each with a factor or a texture for vertex colours.

use gltf::json::{self, Index};

use super::{Baker, MaterialIndex};
use crate::SceneError;
use crate::gltf::decoding::atlas::Atlas;
use crate::gltf::document::sections::{
    ImageContent, JsonImage, JsonMaterial, JsonSampler, JsonTexture, TextureInfo,
};
use crate::texture::Image;

/// Memory of a copied material, in lists that grow to twice their length (bytes).
const MATERIAL_BYTES: u64 =
    (2 * (size_of::<json::Material>() + size_of::<JsonMaterial>()) + 4 * size_of::<TextureInfo>()) as u64;
/// Approximate maximum memory of a JSON value for each byte of its text (bytes).
const JSON_BYTES: u64 = 64;
/// OpenGL's code of clamping.
const CLAMP_TO_EDGE: u32 = 33071;

impl Baker<'_, '_> {
    /// Copies a material with a factor on its base colour; equal factors share a copy.
    pub(super) fn factored(
        &mut self,
        material: MaterialIndex,
        factor: [f32; 4],
    ) -> Result<Index<json::Material>, SceneError> {
        let key = (material.map(|material| material.value()), factor.map(f32::to_bits));
        let copy = match self.copies.get(&key) {
            Some(&copy) => copy,
            None => self.copy(material, factor)?,
        };
        self.copies.insert(key, copy);
        Ok(Index::new(copy as u32))
    }

    /// Copies a material with an image of colours.
    pub(super) fn textured(
        &mut self,
        material: MaterialIndex,
        atlas: Atlas,
        image: Image,
    ) -> Result<Index<json::Material>, SceneError> {
        let copy = self.copy(material, [1.0; 4])?;
        let sections = &mut self.model.document.sections;
        let (source, sampler) = (sections.images.len(), sections.samplers.len());
        let (index, wrap) = (sections.textures.len(), Some(CLAMP_TO_EDGE));
        sections.images.push(JsonImage { name: None, content: ImageContent::VertexColors(image) });
        sections.samplers.push(JsonSampler { wrap_s: wrap, wrap_t: wrap, mag_filter: None });
        sections.textures.push(JsonTexture { source: Some(source), sampler: Some(sampler) });
        let texture = Box::new(TextureInfo { index: Some(index), ..TextureInfo::default() });
        sections.materials[copy].pbr_metallic_roughness.base_color_texture = Some(texture);
        self.model.atlases.insert(copy, atlas);
        Ok(Index::new(copy as u32))
    }

    /// Adds a copy of a material with a factor on its base colour, and returns its index.
    fn copy(&mut self, material: MaterialIndex, factor: [f32; 4]) -> Result<usize, SceneError> {
        let (mut typed, mut plain) = (json::Material::default(), JsonMaterial::default());
        if let Some(index) = material {
            let original = self.context.get(&self.model.root.materials, index, "material", "a primitive")?;
            let original_plain = &self.model.sections.materials[index.value()];
            let bytes = MATERIAL_BYTES + JSON_BYTES * text_bytes(original_plain);
            self.context.take(bytes, "copies of materials with vertex colours")?;
            (typed, plain) = (original.clone(), original_plain.clone());
        }
        let color = &mut typed.pbr_metallic_roughness.base_color_factor.0;
        color.iter_mut().zip(factor).for_each(|(color, factor)| *color *= factor);
        plain.pbr_metallic_roughness.base_color_factor = Some(color.map(f64::from));
        let document = &mut self.model.document;
        document.root.materials.push(typed);
        document.sections.materials.push(plain);
        Ok(document.sections.materials.len() - 1)
    }
}

/// Length of the texts of a material, which is not limited (bytes).
fn text_bytes(material: &JsonMaterial) -> u64 {
    let name = material.name.as_ref().map_or(0, String::len);
    let priority = material.priority.as_ref().map_or(0, |priority| priority.to_string().len());
    (name + priority) as u64
}
