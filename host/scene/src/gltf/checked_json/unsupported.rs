//! Warns of elements that are not rendered. Reads plain JSON, since the document types drop some of them.

use serde_json::Value;

use crate::gltf::context::{ImportContext, label};
use caustics_files::text::cut;

/// Maximum length of a name of an extension or a texture in messages (characters).
const MAX_NAME: usize = 80;

/// Extensions that are rendered, at least in part.
pub const EXTENSIONS: &[&str] = &[
    "EXT_lights_image_based",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

/// Textures that are rendered. Occlusion needs no rendering, since light is traced.
const TEXTURES: [&str; 5] =
    ["baseColorTexture", "metallicRoughnessTexture", "emissiveTexture", "normalTexture", "occlusionTexture"];

/// Sections whose elements warnings name, with the noun for one element.
const SECTIONS: [(&str, &str); 6] = [
    ("materials", "material"),
    ("nodes", "node"),
    ("meshes", "mesh"),
    ("cameras", "camera"),
    ("scenes", "scene"),
    ("animations", "animation"),
];

/// Warns of extensions, textures and factors that are not rendered.
pub fn warn(document: &Value, context: &mut ImportContext<'_>) {
    for (section, kind) in SECTIONS {
        for (index, element) in document[section].as_array().into_iter().flatten().enumerate() {
            let owner = label(kind, index, element["name"].as_str());
            let mut note = |what: String| context.warn(&owner, what);
            walk(element, &mut note);
            if section == "materials" {
                note_material(element, &mut note);
            }
        }
    }
}

/// Finds unknown extensions and textures at any depth.
fn walk(value: &Value, note: &mut impl FnMut(String)) {
    if let Value::Array(elements) = value {
        elements.iter().for_each(|element| walk(element, note));
    }
    let Value::Object(members) = value else { return };
    for (key, member) in members {
        match key.as_str() {
            "extras" => continue,
            "extensions" => {
                let names = member.as_object().into_iter().flat_map(|extensions| extensions.keys());
                for name in names.filter(|name| !EXTENSIONS.contains(&name.as_str())) {
                    note(format!(
                        "extension {:?} is not supported; rendered without it",
                        cut(name, MAX_NAME)
                    ));
                }
            }
            _ if key.ends_with("Texture") && !TEXTURES.contains(&key.as_str()) => {
                note(format!("{:?} is not supported; its factor alone is rendered", cut(key, MAX_NAME)));
            }
            _ => {}
        }
        walk(member, note);
    }
}

fn note_material(material: &Value, note: &mut impl FnMut(String)) {
    let color = &material["extensions"]["KHR_materials_specular"]["specularColorFactor"];
    let is_white = |color: &Value| {
        color.as_array().is_none_or(|channels| channels.iter().all(|channel| channel.as_f64() == Some(1.0)))
    };
    if !is_white(color) {
        note("specularColorFactor is not supported; rendered white".into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn page_on_scenes_lists_exactly_the_rendered_extensions() {
        let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/scenes.md");
        let page = std::fs::read_to_string(page).expect("the page");
        let table = page.split("| extension | what is rendered | what is not |").nth(1).expect("the table");
        let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
        let (mut rendered, mut left_out) = (Vec::new(), Vec::new());
        for row in rows {
            let cells: Vec<&str> = row.split('|').map(str::trim).collect();
            let prefix = cells[1].split(", ").next().and_then(|name| name.rsplit_once("_materials_"));
            for name in cells[1].split(", ") {
                let name = match (name.strip_prefix('_'), prefix) {
                    (Some(end), Some((start, _))) => format!("{start}_materials_{end}"),
                    _ => name.to_string(),
                };
                if cells[2].is_empty() { left_out.push(name) } else { rendered.push(name) }
            }
        }
        rendered.sort();
        assert_eq!(rendered, EXTENSIONS);
        assert!(left_out.len() > 4 && left_out.iter().all(|name| !EXTENSIONS.contains(&name.as_str())));
    }
}
