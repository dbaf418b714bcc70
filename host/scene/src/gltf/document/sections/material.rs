//! Materials: their textures, and members that the crate gltf does not support.

use serde::Deserialize;
use serde_json::Value;

use crate::gltf::document::members::or_default;

/// Materials; `extras.priority` may be any JSON.
pub fn read(document: &Value) -> Result<Vec<JsonMaterial>, serde_json::Error> {
    let materials = document["materials"].as_array().map_or(&[][..], Vec::as_slice);
    let mut read = Vec::with_capacity(materials.len());
    for material in materials {
        let priority = material["extras"].get("priority").cloned();
        read.push(JsonMaterial { priority, ..JsonMaterial::deserialize(material)? });
    }
    Ok(read)
}

/// A material's textures and extensions.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct JsonMaterial {
    /// Name.
    pub name: Option<String>,
    /// Base colour, metal and roughness.
    #[serde(deserialize_with = "or_default")]
    pub pbr_metallic_roughness: JsonMetallicRoughness,
    /// Texture of the emission.
    pub emissive_texture: Option<Box<TextureInfo>>,
    /// Normal map.
    pub normal_texture: Option<Box<TextureInfo>>,
    /// Use of alpha: OPAQUE, MASK or BLEND.
    pub alpha_mode: Option<String>,
    /// Minimum alpha of visible points.
    pub alpha_cutoff: Option<f64>,
    /// Extensions that the crate gltf does not support.
    #[serde(deserialize_with = "or_default")]
    pub extensions: MaterialExtensions,
    /// `extras.priority`.
    #[serde(skip)]
    pub priority: Option<Value>,
}

/// Factors and textures of metallic-roughness.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct JsonMetallicRoughness {
    /// Factors of red, green, blue and alpha.
    pub base_color_factor: Option<[f64; 4]>,
    /// Texture of the base colour.
    pub base_color_texture: Option<Box<TextureInfo>>,
    /// Texture of roughness and metal.
    pub metallic_roughness_texture: Option<Box<TextureInfo>>,
}

/// Extensions of a material.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct MaterialExtensions {
    /// Dispersion.
    #[serde(rename = "KHR_materials_dispersion", deserialize_with = "or_default")]
    pub dispersion: Dispersion,
}

/// KHR_materials_dispersion.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct Dispersion {
    /// 20 over the Abbe number.
    pub dispersion: Option<f64>,
}

/// Reference of a material to a texture.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct TextureInfo {
    /// Index of the texture.
    pub index: Option<usize>,
    /// Set of coordinates: TEXCOORD_n.
    pub tex_coord: Option<u32>,
    /// Strength of a normal map.
    pub scale: Option<f64>,
    /// Extensions.
    #[serde(deserialize_with = "or_default")]
    pub extensions: TextureExtensions,
}

/// Extensions of a reference to a texture.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct TextureExtensions {
    /// Transform of the coordinates.
    #[serde(rename = "KHR_texture_transform", deserialize_with = "or_default")]
    pub transform: TextureTransform,
}

/// KHR_texture_transform.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct TextureTransform {
    /// Offset.
    pub offset: Option<[f64; 2]>,
    /// Rotation, counter-clockwise (rad).
    pub rotation: Option<f64>,
    /// Scale.
    pub scale: Option<[f64; 2]>,
    /// Set of coordinates in place of the reference's.
    pub tex_coord: Option<u32>,
}
