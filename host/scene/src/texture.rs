//! Textures of a scene: builds tables with all levels from images.

use caustics_kernels::interface::texture::{
    CHUNK_COUNT, CHUNK_TEXELS, MaterialTextures, Texture, TextureCoordinates,
};
use caustics_kernels::interface::triangle::Triangle;

use super::SceneError;

pub(crate) use self::coordinates::record;
pub use self::parts::{CornerCoordinates, Image, ImageTexture, Role, TextureParts};
pub(crate) use self::parts::{MAX_SIDE, check, set_flags};

mod coordinates;
mod levels;
mod parts;
pub(crate) mod srgb;

/// Texture tables.
#[derive(Clone, Debug, Default)]
pub struct TextureData {
    /// Textures.
    pub textures: Vec<Texture>,
    /// Textures of each material.
    pub materials: Vec<MaterialTextures>,
    /// Texture coordinates of each triangle.
    pub coordinates: Vec<TextureCoordinates>,
    /// Texels of all chunks.
    pub texels: Vec<u32>,
}

impl TextureData {
    /// Texels of a chunk.
    pub fn chunk(&self, chunk: u32) -> &[u32] {
        let size = CHUNK_TEXELS as usize;
        let end = self.texels.len().min((chunk as usize + 1) * size);
        &self.texels[end.min(chunk as usize * size)..end]
    }

    /// Minimum and maximum byte of a channel in a texture's finest level; averages lie between them.
    pub fn range(&self, texture: u32, channel: u32) -> [u8; 2] {
        let Texture { offset, width, height, .. } = self.textures[texture as usize];
        let texels = &self.texels[offset as usize..][..(width * height) as usize];
        let bytes = || texels.iter().map(|word| (word >> (8 * channel)) as u8);
        [bytes().min().unwrap_or(0), bytes().max().unwrap_or(255)]
    }
}

/// Number of texels of images of these sizes with all levels. Refuses more than the kernels' buffers hold.
pub fn check_texels(file: &str, sizes: impl Iterator<Item = (u32, u32)>) -> Result<u64, SceneError> {
    let limit = u64::from(CHUNK_COUNT) * u64::from(CHUNK_TEXELS);
    let count = sizes.map(|(width, height)| levels::texels(width, height)).sum();
    if count > limit {
        return Err(SceneError::Texels { file: file.into(), count, limit });
    }
    Ok(count)
}

/// Builds the tables of checked parts over triangles, whose coordinates have the same order.
pub fn build(file: &str, parts: TextureParts, triangles: &[Triangle]) -> Result<TextureData, SceneError> {
    // Textures with equal image and role share their texels.
    let mut stored: Vec<(usize, Role, Texture)> = Vec::new();
    let mut textures = Vec::with_capacity(parts.textures.len());
    let mut end = 0_u64;
    for texture in &parts.textures {
        let there = stored.iter().find(|(image, role, _)| (*image, *role) == (texture.image, texture.role));
        let record = there.map(|&(_, _, record)| record).unwrap_or_else(|| {
            let Image { width, height, .. } = parts.images[texture.image];
            let record = Texture {
                offset: end as u32,
                width,
                height,
                level_count: levels::count(width, height),
                encoding: texture.role.encoding(),
                ..Texture::default()
            };
            end += levels::texels(width, height);
            stored.push((texture.image, texture.role, record));
            record
        });
        let [wrap_u, wrap_v] = texture.wrap;
        let level_count = if texture.finest { 1 } else { record.level_count };
        textures.push(Texture { wrap_u, wrap_v, nearest: u32::from(texture.nearest), level_count, ..record });
    }
    check_texels(file, stored.iter().map(|(_, _, record)| (record.width, record.height)))?;
    let mut texels = Vec::with_capacity(end as usize);
    for (image, role, _) in &stored {
        levels::append(&mut texels, &parts.images[*image], *role);
    }
    let records = triangles.iter().zip(&parts.coordinates);
    let coordinates = records.map(|(triangle, record)| coordinates::record(triangle, record)).collect();
    Ok(TextureData { textures, materials: parts.materials, coordinates, texels })
}
