//! KHR_materials_variants: alternative materials of a mesh, by the name of a variant.

use serde_json::Value;

use super::element::{elements, take_extension};
use crate::SceneError;
use crate::gltf::context::ImportContext;

/// Gives primitives their materials of the caller's variant, if any.
pub fn choose(document: &mut Value, context: &ImportContext<'_>) -> Result<(), SceneError> {
    let all = document["extensions"]["KHR_materials_variants"]["variants"].as_array();
    let names: Vec<&str> =
        all.into_iter().flatten().map(|variant| variant["name"].as_str().unwrap_or_default()).collect();
    let chosen = match &context.options.variant {
        None => None,
        Some(variant) => {
            let found = names.iter().position(|name| name == variant);
            Some(found.ok_or_else(|| SceneError::UnknownVariant {
                file: context.file.into(),
                variant: variant.clone(),
                known: if names.is_empty() { "none".into() } else { names.join(", ") },
            })?)
        }
    };
    for mesh in elements(document, "meshes") {
        for primitive in elements(mesh, "primitives") {
            let Some(extension) = take_extension(primitive, "KHR_materials_variants") else { continue };
            let mappings = extension["mappings"].as_array().into_iter().flatten();
            let is_chosen = |mapping: &&Value| {
                let variants = mapping["variants"].as_array().into_iter().flatten();
                variants.into_iter().any(|id| chosen.is_some() && id.as_u64() == chosen.map(|id| id as u64))
            };
            if let Some(mapping) = mappings.into_iter().find(is_chosen) {
                primitive["material"] = mapping["material"].clone();
            }
        }
    }
    Ok(())
}
