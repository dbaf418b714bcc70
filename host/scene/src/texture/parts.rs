//! Inputs of texture tables, and their checks.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::material::{
    FLAG_BLEND, FLAG_COLOR_TEXTURE, FLAG_CUT_OUT, FLAG_EMISSIVE_TEXTURE, FLAG_NORMAL_MAP,
    FLAG_ROUGHNESS_TEXTURE, FLAGS_TEXTURE, Material,
};
use caustics_kernels::interface::texture::{
    ENCODING_LINEAR, ENCODING_NORMAL, ENCODING_SRGB, MaterialTextures,
};
use glam::{Vec2, Vec4};

use crate::SceneError;

/// Maximum side of an image (texels).
pub const MAX_SIDE: u32 = 16_384;

/// An image of eight bits a channel, rows from top to bottom.
#[derive(Clone, Debug, Default)]
pub struct Image {
    /// Width (texels).
    pub width: u32,
    /// Height (texels).
    pub height: u32,
    /// Red, green, blue, alpha.
    pub texels: Vec<[u8; 4]>,
}

/// Kind of a texture's texels; it determines the averaging.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// Colours in sRGB, averaged in linear light.
    Color,
    /// Linear data.
    Data,
    /// Normals, averaged as vectors.
    Normal,
}

impl Role {
    pub(super) fn encoding(self) -> u32 {
        match self {
            Role::Color => ENCODING_SRGB,
            Role::Data => ENCODING_LINEAR,
            Role::Normal => ENCODING_NORMAL,
        }
    }
}

/// An image with its use as a texture.
#[derive(Clone, Copy, Debug)]
pub struct ImageTexture {
    /// Index of the image.
    pub image: usize,
    /// Kind of the texels.
    pub role: Role,
    /// `WRAP_*` along u and v.
    pub wrap: [u32; 2],
    /// Whether texels of a level are not interpolated.
    pub nearest: bool,
    /// Whether only the finest level is used, because neighbouring texels are unrelated.
    pub finest: bool,
}

/// Texture coordinates of a triangle's corners.
#[derive(Clone, Copy, Debug, Default)]
pub struct CornerCoordinates {
    /// Coordinates; (0, 0) is the image's upper left corner.
    pub uv: [Vec2; 3],
    /// Unit tangents with glTF's sign of the bitangent; `None`: along increasing u.
    pub tangents: Option<[Vec4; 3]>,
}

/// Texture inputs of a scene; empty without textures.
#[derive(Clone, Debug, Default)]
pub struct TextureParts {
    /// Images.
    pub images: Vec<Image>,
    /// Textures that use the images.
    pub textures: Vec<ImageTexture>,
    /// Textures of materials, one record each.
    pub materials: Vec<MaterialTextures>,
    /// Texture coordinates, one record a triangle.
    pub coordinates: Vec<CornerCoordinates>,
}

/// Refuses parts that do not fit together, and values that no kernel can use.
pub fn check(
    file: &str,
    parts: &TextureParts,
    triangle_count: usize,
    material_names: &[String],
) -> Result<(), SceneError> {
    let wrong = |what: String| Err(SceneError::Tables { file: file.into(), what });
    for (id, image) in parts.images.iter().enumerate() {
        let within = |side: u32| (1..=MAX_SIDE).contains(&side);
        let texels = u64::from(image.width) * u64::from(image.height);
        if !within(image.width) || !within(image.height) || texels != image.texels.len() as u64 {
            return wrong(format!("image {id} is not of 1 to {MAX_SIDE} texels a side"));
        }
    }
    if parts.textures.iter().any(|texture| texture.image >= parts.images.len()) {
        return wrong("a texture has no image".into());
    }
    if ![0, material_names.len()].contains(&parts.materials.len()) {
        return wrong("as many rows of textures as materials are needed, or none".into());
    }
    if ![0, triangle_count].contains(&parts.coordinates.len()) {
        return wrong("as many texture coordinates as triangles are needed, or none".into());
    }
    for (id, record) in parts.materials.iter().enumerate() {
        let uses = [
            (record.base_color, Role::Color),
            (record.metallic_roughness, Role::Data),
            (record.emissive, Role::Color),
            (record.normal, Role::Normal),
        ];
        for (texture, role) in uses.into_iter().filter(|&(texture, _)| texture != NONE) {
            if parts.textures.get(texture as usize).is_none_or(|texture| texture.role != role) {
                return wrong(format!("material {id} has no texture {texture} as {role:?}"));
            }
            if parts.coordinates.is_empty() {
                return wrong(format!("material {id} is textured, but there are no texture coordinates"));
            }
        }
        let shares = [record.alpha, record.alpha_cutoff.min(1.0)];
        if !shares.iter().all(|share| (0.0..=1.0).contains(share)) || !record.normal_scale.is_finite() {
            let what = "an alpha (baseColorFactor[3]) out of 0 to 1, a negative alphaCutoff, or a normalTexture.scale";
            let what = format!("{what} that is not finite");
            return Err(SceneError::Material {
                file: file.into(),
                material: material_names[id].clone(),
                what,
            });
        }
    }
    let usable = |uv: &Vec2| uv.is_finite() && uv.abs().max_element() <= 1e6;
    if let Some(id) = parts.coordinates.iter().position(|record| !record.uv.iter().all(usable)) {
        return wrong(format!("triangle {id} has texture coordinates that are not finite or beyond 1e6"));
    }
    Ok(())
}

impl TextureParts {
    /// Whether the alpha of a material is one everywhere, as far as its texture's texels tell.
    pub fn is_opaque(&self, record: &MaterialTextures) -> bool {
        let image = self.textures.get(record.base_color as usize).map(|texture| &self.images[texture.image]);
        record.alpha == 1.0 && image.is_none_or(|image| image.texels.iter().all(|texel| texel[3] == 255))
    }
}

/// Flags of alpha.
const FLAGS_ALPHA: u32 = FLAG_CUT_OUT | FLAG_BLEND;

/// Sets the flags of materials by their textures.
pub fn set_flags(materials: &mut [Material], parts: &TextureParts) {
    materials.iter_mut().for_each(|material| material.flags &= !(FLAGS_TEXTURE | FLAGS_ALPHA));
    for (material, record) in materials.iter_mut().zip(&parts.materials) {
        let flags = [
            (record.base_color, FLAG_COLOR_TEXTURE),
            (record.metallic_roughness, FLAG_ROUGHNESS_TEXTURE),
            (record.emissive, FLAG_EMISSIVE_TEXTURE),
            (record.normal, FLAG_NORMAL_MAP),
        ];
        for (_, flag) in flags.into_iter().filter(|&(texture, _)| texture != NONE) {
            material.flags |= flag;
        }
        if material.is_medium() {
            // The faces of a medium bound it for all paths alike, so media ignore alpha.
        } else if record.blends != 0 {
            if !parts.is_opaque(record) {
                material.flags |= FLAG_BLEND;
            }
        } else if record.alpha_cutoff > 0.0 {
            material.flags |= FLAG_CUT_OUT;
        }
    }
}
