//! KHR_materials_pbrSpecularGlossiness as metallic-roughness, by the conversion of the extension's authors.
//!
//! Textures are converted texel by texel when images are read. The member [`SOURCE`] of a converted image names its source
//! images.

use std::collections::HashMap;

use glam::Vec3;
use serde::Deserialize;
use serde_json::{Value, json};

use super::element::{elements, take_extension};
use crate::gltf::context::{ImportContext, label};

pub use self::conversion::{Converted, convert};

mod conversion;

/// Member of a converted image.
pub const SOURCE: &str = "specularGlossiness";

/// An image that is converted from specular-glossiness images.
#[derive(Clone, Debug, Deserialize)]
pub struct ConvertedImage {
    /// Index of the image of the diffuse colour.
    pub diffuse: Option<usize>,
    /// Index of the image of the specular colour and the glossiness.
    pub specular: Option<usize>,
    /// Factors on both images.
    pub factors: SpecularGlossiness,
    /// Metallic-roughness texture that the image represents.
    pub part: ConvertedPart,
}

/// Texture of metallic-roughness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum ConvertedPart {
    /// Base colour.
    BaseColor,
    /// Roughness and metal.
    MetallicRoughness,
}

/// Factors of the extension, each moved into 0 to 1.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(from = "JsonFactors")]
pub struct SpecularGlossiness {
    /// Diffuse colour.
    pub diffuse: Vec3,
    /// Specular colour.
    pub specular: Vec3,
    /// 1 - roughness.
    pub glossiness: f32,
}

/// Factors as written in the JSON.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct JsonFactors {
    diffuse_factor: Option<[f64; 4]>,
    specular_factor: Option<[f64; 3]>,
    glossiness_factor: Option<f64>,
}

impl From<JsonFactors> for SpecularGlossiness {
    fn from(factors: JsonFactors) -> SpecularGlossiness {
        let share = |number: f64| number.clamp(0.0, 1.0) as f32;
        let [red, green, blue, _] = factors.diffuse_factor.unwrap_or([1.0; 4]);
        SpecularGlossiness {
            diffuse: Vec3::from([red, green, blue].map(share)),
            specular: Vec3::from(factors.specular_factor.unwrap_or([1.0; 3]).map(share)),
            glossiness: share(factors.glossiness_factor.unwrap_or(1.0)),
        }
    }
}

/// Textures of a material, in the JSON of metallic-roughness.
struct TexturePair {
    /// Reference to the texture of the base colour.
    base_color: Value,
    /// Reference to the texture of roughness and metal.
    metallic_roughness: Value,
    /// Source images and factors of both textures.
    source: Value,
}

/// Rewrites all materials that have the extension.
pub fn translate(document: &mut Value, context: &mut ImportContext<'_>) {
    let mut list = |section: &str| match document[section].take() {
        Value::Array(elements) => elements,
        _ => Vec::new(),
    };
    let (mut images, mut textures) = (list("images"), list("textures"));
    // Materials with equal sources share their textures.
    let mut known = HashMap::new();
    for (index, material) in elements(document, "materials").enumerate() {
        let Some(extension) = take_extension(material, "KHR_materials_pbrSpecularGlossiness") else {
            continue;
        };
        let note = "KHR_materials_pbrSpecularGlossiness is converted to metallic-roughness, nearly the same";
        context.warn(&label("material", index, material["name"].as_str()), note);
        material["pbrMetallicRoughness"] = match texture_pair(&extension, &textures) {
            None => converted_factors(&extension),
            Some(pair) => {
                let make = || add_textures(&pair, &mut images, &mut textures);
                let first = *known.entry(extension.to_string()).or_insert_with(make);
                converted_textures(&extension, pair, first)
            }
        };
    }
    document["images"] = images.into();
    document["textures"] = textures.into();
}

/// Textures of a material; `None` if it has no valid texture.
fn texture_pair(extension: &Value, textures: &[Value]) -> Option<TexturePair> {
    let image = |member: &str| {
        let info = &extension[member];
        let texture = textures.get(usize::try_from(info["index"].as_u64()?).ok()?)?;
        Some((info.clone(), texture["source"].as_u64()?))
    };
    let (diffuse, specular) = (image("diffuseTexture"), image("specularGlossinessTexture"));
    let source = json!({
        "diffuse": diffuse.as_ref().map(|(_, image)| image),
        "specular": specular.as_ref().map(|(_, image)| image),
        "factors": {
            "diffuseFactor": extension["diffuseFactor"],
            "specularFactor": extension["specularFactor"],
            "glossinessFactor": extension["glossinessFactor"],
        },
    });
    let base_color = diffuse.as_ref().or(specular.as_ref())?.0.clone();
    let metallic_roughness = specular.or(diffuse)?.0;
    Some(TexturePair { base_color, metallic_roughness, source })
}

/// Adds both textures of a pair, each with an image, and the sampler of the first source. Returns the index of the first texture.
fn add_textures(pair: &TexturePair, images: &mut Vec<Value>, textures: &mut Vec<Value>) -> usize {
    for part in ["baseColor", "metallicRoughness"] {
        let mut source = pair.source.clone();
        source["part"] = json!(part);
        let sampler = &textures[pair.base_color["index"].as_u64().unwrap_or(0) as usize]["sampler"];
        let texture = json!({ "source": images.len(), "sampler": sampler });
        images.push(json!({ SOURCE: source }));
        textures.push(texture);
    }
    textures.len() - 2
}

/// Metallic-roughness with textures; `first` is the index of the first.
fn converted_textures(extension: &Value, pair: TexturePair, first: usize) -> Value {
    let at = |mut info: Value, index: usize| {
        info["index"] = json!(index);
        info
    };
    json!({
        "baseColorFactor": [1, 1, 1, alpha(extension)],
        "baseColorTexture": at(pair.base_color, first),
        "metallicRoughnessTexture": at(pair.metallic_roughness, first + 1),
    })
}

/// Metallic-roughness without textures.
fn converted_factors(extension: &Value) -> Value {
    // The members were checked before.
    let factors = JsonFactors::deserialize(extension).map(SpecularGlossiness::from);
    let Ok(SpecularGlossiness { diffuse, specular, glossiness }) = factors else { return json!({}) };
    let Converted { base_color: color, metallic } = convert(diffuse, specular);
    json!({
        "baseColorFactor": [color.x, color.y, color.z, alpha(extension)],
        "metallicFactor": metallic,
        "roughnessFactor": 1.0 - glossiness,
    })
}

/// Alpha of the diffuse factor.
fn alpha(extension: &Value) -> f64 {
    extension["diffuseFactor"][3].as_f64().unwrap_or(1.0)
}
