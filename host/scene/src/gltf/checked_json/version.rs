//! Version of glTF.

use serde_json::Value;

use crate::SceneError;
use crate::gltf::context::ImportContext;
use caustics_files::text::cut;

/// Refuses documents that are not glTF 2. Documents with a later minimum version are read as far as possible.
pub fn check(document: &Value, context: &mut ImportContext<'_>) -> Result<(), SceneError> {
    let version = document["asset"]["version"].as_str().unwrap_or_default();
    // In glTF 1.0, sections are objects and the version is optional.
    let is_old =
        version.starts_with("1.") || ["nodes", "meshes"].iter().any(|name| document[name].is_object());
    if is_old && !version.starts_with("2.") {
        return Err(SceneError::OldVersion { file: context.file.into() });
    }
    if !version.starts_with("2.") {
        let what = format!("asset.version is {version:?} and should be \"2.0\"");
        return Err(context.document_error(what));
    }
    let min_version = document["asset"]["minVersion"].as_str();
    if let Some(min_version) = min_version.filter(|min_version| *min_version != "2.0") {
        let what = format!("asset.minVersion is {:?}, but only \"2.0\" is read", cut(min_version, 80));
        if context.options.strict || !min_version.starts_with("2.") {
            return Err(context.document_error(what));
        }
        context.warn("", format_args!("{what}; rendered as far as it is known"));
    }
    Ok(())
}
