//! KHR_materials_pbrSpecularGlossiness as metallic-roughness, by the conversion of the extension's authors [Khronos,
//! glTF repository, extensions/2.0/Archived/KHR_materials_pbrSpecularGlossiness/examples].
//!
//! Textures are converted texel by texel: their images are made when images are read, of those that `SOURCE` names.

use std::collections::HashMap;

use glam::Vec3;
use serde_json::{Value, json};

use super::element::{elements, take_extension};
use crate::gltf::unsupported::label;
use crate::gltf::warning::Warnings;

/// Member of an image that is made of others.
pub const SOURCE: &str = "specularGlossiness";
/// Reflectance of a dielectric at normal incidence.
const DIELECTRIC: f32 = 0.04;

/// What metallic-roughness calls it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Converted {
    /// Base colour.
    pub base_color: Vec3,
    /// Share of metal.
    pub metallic: f32,
}

/// A diffuse and a specular colour, converted.
pub fn convert(diffuse: Vec3, specular: Vec3) -> Converted {
    let strength_left = 1.0 - specular.max_element();
    let brightness = |color: Vec3| (color * color).dot(Vec3::new(0.299, 0.587, 0.114)).sqrt();
    let metallic = metallic(brightness(diffuse), brightness(specular), strength_left);
    let of_diffuse = diffuse * (strength_left / (1.0 - DIELECTRIC) / (1.0 - metallic).max(1e-6));
    let of_specular = (specular - DIELECTRIC * (1.0 - metallic)) / metallic.max(1e-6);
    let base_color = of_diffuse.lerp(of_specular, metallic * metallic).clamp(Vec3::ZERO, Vec3::ONE);
    Converted { base_color, metallic }
}

/// The share of metal that gives both brightnesses, of a quadratic equation.
fn metallic(diffuse: f32, specular: f32, strength_left: f32) -> f32 {
    if specular < DIELECTRIC {
        return 0.0;
    }
    let b = diffuse * strength_left / (1.0 - DIELECTRIC) + specular - 2.0 * DIELECTRIC;
    let c = DIELECTRIC - specular;
    let root = (b * b - 4.0 * DIELECTRIC * c).max(0.0).sqrt();
    ((root - b) / (2.0 * DIELECTRIC)).clamp(0.0, 1.0)
}

/// Rewrites all materials that have the extension.
pub fn translate(document: &mut Value, warnings: &mut Warnings) {
    let mut list = |section: &str| match document[section].take() {
        Value::Array(elements) => elements,
        _ => Vec::new(),
    };
    let (mut images, mut textures) = (list("images"), list("textures"));
    // Materials that share everything share their textures.
    let mut known = HashMap::new();
    for (index, material) in elements(document, "materials").enumerate() {
        let Some(extension) = take_extension(material, "KHR_materials_pbrSpecularGlossiness") else {
            continue;
        };
        let note = "KHR_materials_pbrSpecularGlossiness is converted to metallic-roughness, nearly the same";
        warnings.note(&label("material", index, material["name"].as_str()), note);
        material["pbrMetallicRoughness"] = match pair(&extension, &textures) {
            None => converted_factors(&extension),
            Some((info, other, sampled)) => {
                let first = *known.entry(extension.to_string()).or_insert_with(|| {
                    for part in ["baseColor", "metallicRoughness"] {
                        let mut source = sampled.clone();
                        source["part"] = json!(part);
                        let sampler = &textures[info["index"].as_u64().unwrap_or(0) as usize]["sampler"];
                        let texture = json!({ "source": images.len(), "sampler": sampler });
                        images.push(json!({ SOURCE: source }));
                        textures.push(texture);
                    }
                    textures.len() - 2
                });
                let infos = [0, 1].map(|part| {
                    let mut info = if part == 0 { info.clone() } else { other.clone() };
                    info["index"] = json!(first + part);
                    info
                });
                json!({
                    "baseColorFactor": [1, 1, 1, number(&extension["diffuseFactor"][3], 1.0)],
                    "baseColorTexture": infos[0],
                    "metallicRoughnessTexture": infos[1],
                })
            }
        };
    }
    document["images"] = images.into();
    document["textures"] = textures.into();
}

/// How the textures of base colour and of metallic-roughness are mapped, and what their images are made of; none where no
/// texture is there.
fn pair(extension: &Value, textures: &[Value]) -> Option<(Value, Value, Value)> {
    let image = |member: &str| {
        let info = &extension[member];
        let texture = textures.get(usize::try_from(info["index"].as_u64()?).ok()?)?;
        Some((info.clone(), texture["source"].as_u64()?))
    };
    let (diffuse, specular) = (image("diffuseTexture"), image("specularGlossinessTexture"));
    let made_of = json!({
        "diffuse": diffuse.as_ref().map(|(_, image)| image),
        "specular": specular.as_ref().map(|(_, image)| image),
        "diffuseFactor": extension["diffuseFactor"],
        "specularFactor": extension["specularFactor"],
        "glossinessFactor": extension["glossinessFactor"],
    });
    let first = diffuse.as_ref().or(specular.as_ref())?.0.clone();
    let second = specular.or(diffuse)?.0;
    Some((first, second, made_of))
}

fn converted_factors(extension: &Value) -> Value {
    let Factors { diffuse, specular, glossiness } = Factors::from_extension(extension);
    let Converted { base_color: color, metallic } = convert(diffuse, specular);
    json!({
        "baseColorFactor": [color.x, color.y, color.z, number(&extension["diffuseFactor"][3], 1.0)],
        "metallicFactor": metallic,
        "roughnessFactor": 1.0 - glossiness,
    })
}

fn number(value: &Value, default: f64) -> f64 {
    value.as_f64().unwrap_or(default)
}

/// Factors of the extension, each moved into 0 to 1.
pub struct Factors {
    /// Of the diffuse colour.
    pub diffuse: Vec3,
    /// Of the specular colour.
    pub specular: Vec3,
    /// Of what roughness lacks to 1.
    pub glossiness: f32,
}

impl Factors {
    /// Those of the extension, or of what an image is made of.
    pub fn from_extension(extension: &Value) -> Factors {
        let share = |value: &Value| number(value, 1.0).clamp(0.0, 1.0) as f32;
        let color =
            |name: &str| Vec3::from_array(std::array::from_fn(|channel| share(&extension[name][channel])));
        Factors {
            diffuse: color("diffuseFactor"),
            specular: color("specularFactor"),
            glossiness: share(&extension["glossinessFactor"]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metals_and_plastics_are_told_apart() {
        // Nothing but specular is metal of that colour.
        let gold = Vec3::new(1.0, 0.77, 0.34);
        let converted = convert(Vec3::ZERO, gold);
        assert!(
            (converted.base_color - gold).length() < 1e-5 && converted.metallic > 0.99999,
            "{converted:?}"
        );
        // A specular colour of 0.04 is a dielectric of the diffuse colour.
        let red = Vec3::new(0.8, 0.1, 0.1);
        let converted = convert(red, Vec3::splat(DIELECTRIC));
        assert!((converted.base_color - red).length() < 1e-5 && converted.metallic < 1e-6, "{converted:?}");
    }

    #[test]
    fn both_models_reflect_alike() {
        // Grey, so that one share of metal can serve all channels: F0 and the diffuse albedo are those that were asked for.
        for (diffuse, specular) in [(0.5, 0.04), (0.3, 0.2), (0.1, 0.5), (0.9, 0.1)] {
            let Converted { base_color, metallic } = convert(Vec3::splat(diffuse), Vec3::splat(specular));
            let f0 = DIELECTRIC * (1.0 - metallic) + base_color.x * metallic;
            let albedo = base_color.x * (1.0 - metallic) * (1.0 - DIELECTRIC);
            // The colours of both parts are blended by metallic^2, which is exact only at the ends of its range.
            assert!((f0 - specular).abs() < 0.05, "{diffuse} {specular}: F0 {f0}");
            assert!(
                (albedo - diffuse * (1.0 - specular)).abs() < 0.05,
                "{diffuse} {specular}: albedo {albedo}"
            );
        }
    }
}
