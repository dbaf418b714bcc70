//! Textures of materials: their images, wraps and coordinates.

use caustics_kernels::interface::texture::MaterialTextures;

use self::images::{FLAT, load};
use self::sources::TextureSources;
use crate::SceneError;
use crate::gltf::context::{ImportContext, label};
use crate::gltf::decoding::model::Model;
use crate::gltf::document::sections::{JsonMaterial, TextureInfo};
use crate::texture::{Role, TextureParts};

pub use self::mapping::Mapping;

mod images;
mod mapping;
mod sources;

/// Textures of all materials, before the coordinates of triangles.
pub struct MaterialMaps {
    /// Images, textures and records of materials; the last record is the default material's.
    pub parts: TextureParts,
    /// Mapping of each material; `None` without textures.
    pub mappings: Vec<Option<Mapping>>,
}

/// A kind of texture of a material.
struct Slot<'a> {
    name: &'static str,
    role: Role,
    info: &'a TextureInfo,
}

/// Textures of a material, in the order of their warnings.
fn slots(material: &JsonMaterial) -> impl Iterator<Item = Slot<'_>> {
    let pbr = &material.pbr_metallic_roughness;
    let all = [
        ("baseColorTexture", Role::Color, &pbr.base_color_texture),
        ("metallicRoughnessTexture", Role::Data, &pbr.metallic_roughness_texture),
        ("emissiveTexture", Role::Color, &material.emissive_texture),
        ("normalTexture", Role::Normal, &material.normal_texture),
    ];
    all.into_iter().filter_map(|(name, role, info)| Some(Slot { name, role, info: info.as_deref()? }))
}

/// Reads the textures of all materials and loads their images.
pub fn read(model: &Model, context: &mut ImportContext<'_>) -> Result<MaterialMaps, SceneError> {
    let mut sources = TextureSources::default();
    let mut records = Vec::with_capacity(model.sections.materials.len() + 1);
    let mut mappings = Vec::with_capacity(records.capacity());
    for (index, material) in model.sections.materials.iter().enumerate() {
        let owner = label("material", index, material.name.as_deref());
        let (record, mapping) = read_material(model, context, &mut sources, material, &owner)?;
        records.push(record);
        mappings.push(mapping);
    }
    mappings.push(None);

    // Load images. A fault removes the texture from the records
    let TextureSources { textures, images, .. } = sources;
    let images = load(model, context, &images, &textures, &mut records)?;
    records.push(MaterialTextures::default());
    if records.iter().all(|record| *record == MaterialTextures::default()) {
        records.clear();
    }
    let parts = TextureParts { images, textures, materials: records, ..TextureParts::default() };
    Ok(MaterialMaps { parts, mappings })
}

/// Reads the record of a material and the mapping of its textures.
fn read_material(
    model: &Model,
    context: &mut ImportContext<'_>,
    sources: &mut TextureSources,
    material: &JsonMaterial,
    owner: &str,
) -> Result<(MaterialTextures, Option<Mapping>), SceneError> {
    let mut record = MaterialTextures::default();
    let mut first: Option<(Mapping, &str)> = None;
    for Slot { name, role, info } in slots(material) {
        let index = info.index.unwrap_or(usize::MAX);
        let texture = match sources.texture(model, context, index, role, owner) {
            Ok(texture) => texture,
            Err(error) => {
                let what = match &error {
                    SceneError::Index { kind, index, .. } => {
                        format!("{name} refers to {kind} {index}, which is not there")
                    }
                    _ => format!("{name} has no image of a format that is read"),
                };
                context.replace(owner, &what, FLAT, error)?;
                continue;
            }
        };
        match name {
            "baseColorTexture" => record.base_color = texture,
            "metallicRoughnessTexture" => record.metallic_roughness = texture,
            "emissiveTexture" => record.emissive = texture,
            _ => {
                record.normal = texture;
                record.normal_scale = info.scale.map_or(1.0, |scale| scale as f32);
            }
        }
        let mapping = Mapping::from_info(info);
        match first {
            Some((first, other)) if first != mapping => {
                let what = format!("{name} has other coordinates than {other}, which is not supported");
                context.warn(owner, what + "; it is rendered by those");
            }
            Some(_) => {}
            None => first = Some((mapping, name)),
        }
    }
    set_alpha(&mut record, material);
    move_into_ranges(&mut record, context, owner, material.name.as_deref().unwrap_or(owner))?;
    let has_normal_map = record.normal != MaterialTextures::default().normal;
    if let Some((mapping, _)) = &mut first {
        mapping.has_normal_map = has_normal_map;
    }
    Ok((record, first.map(|(mapping, _)| mapping)))
}

/// Sets the use of a material's alpha.
fn set_alpha(record: &mut MaterialTextures, material: &JsonMaterial) {
    let factor = material.pbr_metallic_roughness.base_color_factor;
    record.alpha = factor.map_or(1.0, |[_, _, _, alpha]| alpha as f32);
    match material.alpha_mode.as_deref() {
        Some("MASK") => record.alpha_cutoff = material.alpha_cutoff.map_or(0.5, |cutoff| cutoff as f32),
        Some("BLEND") => record.blends = 1,
        // Opaque materials ignore alpha.
        _ => record.alpha = 1.0,
    }
}

/// Clamps factors to their ranges.
fn move_into_ranges(
    record: &mut MaterialTextures,
    context: &mut ImportContext<'_>,
    owner: &str,
    name: &str,
) -> Result<(), SceneError> {
    for (member, factor, min, max) in [
        ("baseColorFactor[3]", &mut record.alpha, 0.0, 1.0),
        ("alphaCutoff", &mut record.alpha_cutoff, 0.0, f32::MAX),
        ("normalTexture.scale", &mut record.normal_scale, f32::MIN, f32::MAX),
    ] {
        if (min..=max).contains(factor) {
            continue;
        }
        let what = format!("{member} {factor} out of its range");
        *factor = factor.clamp(min, max);
        let error = context.material_error(name, &what);
        context.replace(owner, &what, &format!("taken as {factor}"), error)?;
    }
    Ok(())
}
