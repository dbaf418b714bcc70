//! Materials: factors and extensions, resolved.

use caustics_kernels::interface::material::{FLAG_EMIT_BOTH_SIDES, FLAG_THIN, Material};
use glam::Vec3;
use gltf::json;
use serde_json::Value;

use super::document::Document;
use super::unsupported;
use crate::scene::texture::TextureParts;

/// Index of refraction where the file says nothing.
const IOR: f32 = 1.5;

/// All materials of the document and their names; the last is glTF's default material.
pub fn read_all(document: &mut Document) -> (Vec<Material>, Vec<String>) {
    let all = std::mem::take(&mut document.root.materials);
    let mut read = Vec::with_capacity(all.len() + 1);
    for (index, material) in all.iter().enumerate() {
        let name = material.name.clone().unwrap_or_else(|| format!("material {index}"));
        let label = unsupported::label("material", index, material.name.as_deref());
        let mut resolved = resolve(material, |what| document.warn(&label, what));
        resolved.priority = priority(document.sections.materials.get(index)).unwrap_or_else(|what| {
            document.warn(&label, what);
            0
        });
        read.push((resolved, name));
    }
    read.push((resolve(&json::Material::default(), |_| {}), "default".into()));
    read.into_iter().unzip()
}

/// Names media that blend, which are there for every path.
pub fn name_blended_media(
    document: &mut Document,
    materials: &[Material],
    names: &[String],
    textures: &TextureParts,
) {
    for (index, (material, row)) in materials.iter().zip(&textures.materials).enumerate() {
        if row.blends != 0 && material.is_medium() && !textures.is_opaque(row) {
            let label = unsupported::label("material", index, Some(&names[index]));
            document.warn(
                &label,
                "alphaMode BLEND of a volume that transmits is not supported; rendered as OPAQUE",
            );
        }
    }
}

/// `extras.priority` of a material, else 0: where media overlap, that of the highest is there.
fn priority(material: Option<&Value>) -> Result<i32, String> {
    let Some(priority) = material.and_then(|material| material["extras"].get("priority")) else {
        return Ok(0);
    };
    let integer = priority.as_i64().and_then(|number| i32::try_from(number).ok());
    integer.ok_or_else(|| format!("extras.priority is {priority} and should be an integer; taken as 0"))
}

/// Resolves a material's factors. Values out of range stay as they are: `SceneParts::build` refuses them.
fn resolve(material: &json::Material, mut warn: impl FnMut(&str)) -> Material {
    let pbr = &material.pbr_metallic_roughness;
    let extensions = material.extensions.clone().unwrap_or_default();
    let transmission = extensions.transmission.map_or(0.0, |transmission| transmission.transmission_factor.0);
    let roughness = pbr.roughness_factor.0;

    let mut ior = extensions.ior.map_or(IOR, |ior| ior.ior.0);
    if ior == 0.0 {
        warn("ior 0 (a compatibility mode) is not supported; rendered as 1.5");
        ior = IOR;
    }

    let strength = extensions.emissive_strength.map_or(1.0, |strength| strength.emissive_strength.0);
    let emission = Vec3::from(material.emissive_factor.0) * strength;
    let mut flags = 0;
    if material.double_sided && emission != Vec3::ZERO {
        flags |= FLAG_EMIT_BOTH_SIDES;
    }

    // A thickness of zero marks a wall without an inside.
    let mut absorption = Vec3::ZERO;
    match extensions.volume.filter(|volume| volume.thickness_factor.0 != 0.0) {
        Some(volume) => {
            let distance = volume.attenuation_distance.0;
            let per_channel = |color: f32| (0.0 - color.max(1e-6).ln()) / distance;
            absorption = Vec3::from(volume.attenuation_color.0.map(per_channel));
        }
        None if transmission > 0.0 => flags |= FLAG_THIN,
        None => {}
    }

    let [red, green, blue, _] = pbr.base_color_factor.0;
    Material {
        base_color: Vec3::new(red, green, blue),
        roughness,
        emission,
        metallic: pbr.metallic_factor.0,
        absorption,
        ior,
        transmission,
        specular: extensions.specular.map_or(1.0, |specular| specular.specular_factor.0),
        flags,
        priority: 0,
    }
}
