//! Required extensions that are not supported. glTF demands to refuse such files; they are rendered with a warning if they can be
//! read without the extension.

use serde_json::Value;

use super::unsupported;
use crate::SceneError;
use crate::gltf::context::{ImportContext, MissingExtension};
use caustics_files::text::cut;

/// Warns of required extensions that are not supported, and keeps the first for later errors. Strict reading refuses them.
pub fn check(document: &Value, context: &mut ImportContext<'_>) -> Result<(), SceneError> {
    let required = document["extensionsRequired"].as_array().into_iter().flatten();
    for name in required.filter_map(Value::as_str).filter(|name| !unsupported::EXTENSIONS.contains(name)) {
        let (extension, remedy) = (cut(name, 80), remedy(name));
        if context.options.strict {
            return Err(SceneError::RequiredExtension { file: context.file.into(), extension, remedy });
        }
        context.warn(
            "",
            format_args!(
                "requires the extension {extension:?}, which is not supported; rendered without it, which may \
                 show another thing than the file means ({remedy})"
            ),
        );
        context.missing_extension.get_or_insert(MissingExtension { extension, remedy });
    }
    Ok(())
}

/// Advice on a file that requires an unsupported extension.
fn remedy(extension: &str) -> &'static str {
    match extension {
        "EXT_texture_avif" => {
            "convert its textures: npx @gltf-transform/cli png --formats \"*\" IN.glb OUT.glb"
        }
        "KHR_techniques_webgl" => "convert its materials: npx gltf-pipeline -i OLD.gltf -o NEW.gltf",
        _ => "export the scene without it, or take it out of extensionsRequired if it can be seen without",
    }
}
