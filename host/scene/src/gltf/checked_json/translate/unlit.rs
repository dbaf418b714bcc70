//! KHR_materials_unlit: a colour independent of light. All surfaces here emit or reflect, so an unlit material becomes diffuse.

use serde_json::{Value, json};

use super::element::{elements, take_extension};
use crate::gltf::context::{ImportContext, label};

/// Makes unlit materials diffuse, with their base colour.
pub fn translate(document: &mut Value, context: &mut ImportContext<'_>) {
    for (index, material) in elements(document, "materials").enumerate() {
        if take_extension(material, "KHR_materials_unlit").is_none() {
            continue;
        }
        let owner = label("material", index, material["name"].as_str());
        let what = "KHR_materials_unlit: colours that need no light are not supported; rendered as a diffuse surface";
        context.warn(&owner, what);
        let Some(members) = material.as_object_mut() else { continue };
        for member in ["emissiveFactor", "emissiveTexture", "normalTexture", "occlusionTexture"] {
            members.remove(member);
        }
        material["extensions"] = json!({ "KHR_materials_specular": { "specularFactor": 0 } });
        if material["pbrMetallicRoughness"].is_null() {
            material["pbrMetallicRoughness"] = json!({});
        }
        let pbr = &mut material["pbrMetallicRoughness"];
        (pbr["metallicFactor"], pbr["roughnessFactor"]) = (json!(0), json!(1));
        pbr["metallicRoughnessTexture"] = Value::Null;
    }
}
