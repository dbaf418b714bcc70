//! KHR_materials_clearcoat: a second coat, over the material's own. Materials here have one coat. The clearcoat replaces it if
//! the material is a dielectric and the clearcoat dominates its reflection.

use serde_json::{Value, json};

use super::element::{elements, take_extension};
use crate::gltf::context::{ImportContext, label};

/// Minimum clearcoat factor for which the clearcoat replaces both coats.
const MIN_SHARE: f64 = 0.5;

/// Gives dielectrics the roughness of their clearcoat.
pub fn translate(document: &mut Value, context: &mut ImportContext<'_>) {
    for (index, material) in elements(document, "materials").enumerate() {
        let Some(clearcoat) = take_extension(material, "KHR_materials_clearcoat") else { continue };
        let share = clearcoat["clearcoatFactor"].as_f64().unwrap_or(0.0);
        if share <= 0.0 {
            continue;
        }
        let owner = label("material", index, material["name"].as_str());
        let pbr = &material["pbrMetallicRoughness"];
        let is_dielectric =
            pbr["metallicFactor"].as_f64() == Some(0.0) && pbr["metallicRoughnessTexture"].is_null();
        let transmission = &material["extensions"]["KHR_materials_transmission"]["transmissionFactor"];
        if !is_dielectric || share < MIN_SHARE || transmission.as_f64().unwrap_or(0.0) > 0.0 {
            let what = "KHR_materials_clearcoat is supported on opaque dielectrics alone, from a factor of 0.5 on; rendered \
                        without it";
            context.warn(&owner, what);
            continue;
        }
        let textures = ["clearcoatTexture", "clearcoatRoughnessTexture", "clearcoatNormalTexture"];
        let has_texture = textures.iter().any(|texture| !clearcoat[texture].is_null());
        let factors = if has_texture { "; its factors alone are rendered" } else { "" };
        let what =
            "KHR_materials_clearcoat takes the place of the material's own gloss, which is left out under it";
        context.warn(&owner, format_args!("{what}{factors}"));
        material["pbrMetallicRoughness"]["roughnessFactor"] =
            json!(clearcoat["clearcoatRoughnessFactor"].as_f64().unwrap_or(0.0));
        material["extensions"]["KHR_materials_specular"] = json!({ "specularFactor": share.min(1.0) });
        material["extensions"]["KHR_materials_ior"] = json!({ "ior": 1.5 });
    }
}
