//! Materials: resolves factors and extensions.

use std::ops::RangeInclusive;

use caustics_kernels::interface::material::{FLAG_EMIT_BOTH_SIDES, FLAG_THIN, Material};
use glam::Vec3;
use gltf::json;
use gltf::json::extensions::material::Volume;

use crate::SceneError;
use crate::gltf::context::{ImportContext, label};
use crate::gltf::decoding::model::Model;
use crate::gltf::document::sections::JsonMaterial;
use crate::texture::TextureParts;

/// Maximum radiance and absorption (W m^-2 sr^-1, 1/m).
const LARGEST: f32 = 1e30;
/// Maximum dispersion: at 40 red is not refracted at all.
const MAX_DISPERSION: f32 = 1000.0;
/// Default index of refraction.
const IOR: f32 = 1.5;

/// Reads all materials of a model and their names; the last is glTF's default material.
pub fn read_all(
    model: &Model,
    context: &mut ImportContext<'_>,
) -> Result<(Vec<Material>, Vec<String>), SceneError> {
    let mut read = Vec::with_capacity(model.root.materials.len() + 1);
    for (index, material) in model.root.materials.iter().enumerate() {
        let section = model.sections.materials.get(index);
        let name = material.name.clone().unwrap_or_else(|| format!("material {index}"));
        let label = label("material", index, material.name.as_deref());
        let mut faults = Vec::new();
        let mut resolved = resolve(material, &mut faults, |what| context.warn(&label, what));
        let dispersion = section.and_then(|section| section.extensions.dispersion.dispersion);
        let dispersion = dispersion.unwrap_or(0.0) as f32;
        resolved.dispersion = within(dispersion, 0.0..=MAX_DISPERSION, "dispersion", &mut faults);
        for Fault { what, instead } in faults {
            let error = context.material_error(&name, &what);
            context.replace(&label, &what, &format!("taken as {instead}"), error)?;
        }
        resolved.priority = priority(section).unwrap_or_else(|what| {
            context.warn(&label, what);
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

/// Clamps a number to its range, and notes a fault if it was outside.
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

/// Warns of media with alpha, which is not rendered.
pub fn warn_of_media_with_alpha(
    context: &mut ImportContext<'_>,
    materials: &[Material],
    names: &[String],
    textures: &TextureParts,
) {
    for (index, (material, record)) in materials.iter().zip(&textures.materials).enumerate() {
        let has_alpha = record.blends != 0 || record.alpha_cutoff > 0.0;
        if has_alpha && material.is_medium() && !textures.is_opaque(record) {
            let label = label("material", index, Some(&names[index]));
            let mode = if record.blends != 0 { "BLEND" } else { "MASK" };
            let what =
                format!("alphaMode {mode} of a volume that transmits is not supported; rendered as OPAQUE");
            context.warn(&label, &what);
        }
    }
}

/// `extras.priority` of a material, or 0. Where media overlap, the highest priority wins.
fn priority(material: Option<&JsonMaterial>) -> Result<i32, String> {
    let Some(priority) = material.and_then(|material| material.priority.as_ref()) else { return Ok(0) };
    let integer = priority.as_i64().and_then(|number| i32::try_from(number).ok());
    integer.ok_or_else(|| format!("extras.priority is {priority} and should be an integer; taken as 0"))
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

    let absorption = extensions.volume.as_ref().and_then(|volume| absorption(volume, faults));
    if absorption.is_none() && transmission > 0.0 {
        flags |= FLAG_THIN;
    }

    Material {
        base_color: Vec3::from(base_color),
        roughness,
        emission: Vec3::from(emission),
        metallic,
        absorption: absorption.unwrap_or(Vec3::ZERO),
        ior,
        transmission,
        specular,
        flags,
        priority: 0,
        dispersion: 0.0,
        medium: 0,
    }
}

/// Absorption of a volume (1/m); `None` for a thin wall, which a thickness of zero marks.
fn absorption(volume: &Volume, faults: &mut Vec<Fault>) -> Option<Vec3> {
    if volume.thickness_factor.0 == 0.0 {
        return None;
    }
    let mut distance = volume.attenuation_distance.0;
    if distance <= 0.0 {
        let what = format!("attenuationDistance {distance} that is not positive");
        faults.push(Fault { what, instead: f32::INFINITY });
        distance = f32::INFINITY;
    }
    let color = volume.attenuation_color.0;
    let color = color.map(|channel| within(channel, 0.0..=1.0, "attenuationColor", faults));
    let per_channel = |color: f32| ((0.0 - color.max(1e-6).ln()) / distance).min(LARGEST);
    Some(Vec3::from(color.map(per_channel)))
}
