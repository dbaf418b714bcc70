//! Materials: factors and extensions, resolved.

use std::ops::RangeInclusive;

use caustics_kernels::interface::material::{FLAG_EMIT_BOTH_SIDES, FLAG_THIN, Material};
use glam::Vec3;
use gltf::json;
use serde_json::Value;

use super::document::Document;
use super::unsupported;
use crate::SceneError;
use crate::texture::TextureParts;

/// Largest radiance and absorption that is rendered (W m^-2 sr^-1, 1/m).
const LARGEST: f32 = 1e30;
/// Largest dispersion that is rendered: at 40 red is not refracted at all.
const MAX_DISPERSION: f32 = 1000.0;
/// Index of refraction where the file says nothing.
const IOR: f32 = 1.5;

/// All materials of the document and their names; the last is glTF's default material.
pub fn read_all(document: &mut Document) -> Result<(Vec<Material>, Vec<String>), SceneError> {
    let all = std::mem::take(&mut document.root.materials);
    let mut read = Vec::with_capacity(all.len() + 1);
    for (index, material) in all.iter().enumerate() {
        let name = material.name.clone().unwrap_or_else(|| format!("material {index}"));
        let label = unsupported::label("material", index, material.name.as_deref());
        let mut faults = Vec::new();
        let mut resolved = resolve(material, &mut faults, |what| document.warn(&label, what));
        resolved.dispersion = dispersion(document.sections.materials.get(index), &mut faults);
        for Fault { what, instead } in faults {
            let (file, material) = (document.file.clone(), name.clone());
            let error = SceneError::Material { file, material, what: what.clone() };
            document.replace(&label, &what, &format!("taken as {instead}"), error)?;
        }
        resolved.priority = priority(document.sections.materials.get(index)).unwrap_or_else(|what| {
            document.warn(&label, what);
            0
        });
        read.push((resolved, name));
    }
    read.push((resolve(&json::Material::default(), &mut Vec::new(), |_| {}), "default".into()));
    Ok(read.into_iter().unzip())
}

/// A number out of glTF's range.
struct Fault {
    what: String,
    instead: f32,
}

/// A number within its range, else its nearer end and a fault.
fn within(number: f32, range: RangeInclusive<f32>, name: &str, faults: &mut Vec<Fault>) -> f32 {
    if range.contains(&number) {
        return number;
    }
    let (low, high) = range.into_inner();
    let instead = if number > high { high } else { low };
    let what = match high {
        LARGEST => format!("{name} {number:e} that is negative or beyond {LARGEST:e}"),
        _ => format!("{name} {number} out of the range {low} to {high}"),
    };
    faults.push(Fault { what, instead });
    instead
}

/// Names media that blend, which are there for every path.
pub fn name_blended_media(
    document: &mut Document,
    materials: &[Material],
    names: &[String],
    textures: &TextureParts,
) {
    for (index, (material, record)) in materials.iter().zip(&textures.materials).enumerate() {
        if record.blends != 0 && material.is_medium() && !textures.is_opaque(record) {
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

/// KHR_materials_dispersion of a material, which the document types do not know.
fn dispersion(material: Option<&Value>, faults: &mut Vec<Fault>) -> f32 {
    let dispersion = material
        .and_then(|material| material["extensions"]["KHR_materials_dispersion"]["dispersion"].as_f64());
    within(dispersion.unwrap_or(0.0) as f32, 0.0..=MAX_DISPERSION, "dispersion", faults)
}

/// Resolves a material's factors.
fn resolve(material: &json::Material, faults: &mut Vec<Fault>, mut warn: impl FnMut(&str)) -> Material {
    let pbr = &material.pbr_metallic_roughness;
    let extensions = material.extensions.clone().unwrap_or_default();
    let mut share = |number: f32, name: &str| within(number, 0.0..=1.0, name, faults);
    let transmission = extensions.transmission.map_or(0.0, |transmission| transmission.transmission_factor.0);
    let transmission = share(transmission, "transmissionFactor");
    let roughness = share(pbr.roughness_factor.0, "roughnessFactor");
    let metallic = share(pbr.metallic_factor.0, "metallicFactor");
    let specular = extensions.specular.map_or(1.0, |specular| specular.specular_factor.0);
    let specular = share(specular, "specularFactor");
    let [red, green, blue, _] = pbr.base_color_factor.0;
    let base_color = [red, green, blue].map(|channel| share(channel, "baseColorFactor"));

    let mut ior = extensions.ior.map_or(IOR, |ior| ior.ior.0);
    if ior == 0.0 {
        warn("ior 0 (a compatibility mode) is not supported; rendered as 1.5");
        ior = IOR;
    }
    let ior = within(ior, 1.0..=100.0, "ior", faults);

    let strength = extensions.emissive_strength.map_or(1.0, |strength| strength.emissive_strength.0);
    let emission = material.emissive_factor.0.map(|factor| factor * strength);
    let emission = emission.map(|radiance| within(radiance, 0.0..=LARGEST, "an emission", faults));
    let mut flags = 0;
    if material.double_sided && emission != [0.0; 3] {
        flags |= FLAG_EMIT_BOTH_SIDES;
    }

    // A thickness of zero marks a wall without an inside.
    let mut absorption = Vec3::ZERO;
    match extensions.volume.filter(|volume| volume.thickness_factor.0 != 0.0) {
        Some(volume) => {
            let mut distance = volume.attenuation_distance.0;
            if distance <= 0.0 {
                let what = format!("attenuationDistance {distance} that is not positive");
                faults.push(Fault { what, instead: f32::INFINITY });
                distance = f32::INFINITY;
            }
            let color = volume.attenuation_color.0;
            let color = color.map(|channel| within(channel, 0.0..=1.0, "attenuationColor", faults));
            let per_channel = |color: f32| ((0.0 - color.max(1e-6).ln()) / distance).min(LARGEST);
            absorption = Vec3::from(color.map(per_channel));
        }
        None if transmission > 0.0 => flags |= FLAG_THIN,
        None => {}
    }

    Material {
        base_color: Vec3::from(base_color),
        roughness,
        emission: Vec3::from(emission),
        metallic,
        absorption,
        ior,
        transmission,
        specular,
        flags,
        priority: 0,
        dispersion: 0.0,
        medium: 0,
    }
}
