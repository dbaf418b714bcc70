//! Which version of glTF a document is of.

use serde_json::Value;

use super::options::LoadOptions;
use super::warning::Warnings;
use crate::SceneError;
use caustics_files::text::cut;

/// Refuses what is no glTF 2; of a document that asks for a later reader, all that is known is read.
pub fn check(
    file: &str,
    document: &Value,
    options: &LoadOptions,
    warnings: &mut Warnings,
) -> Result<(), SceneError> {
    let wrong = |what: String| SceneError::Document { file: file.into(), what };
    let version = document["asset"]["version"].as_str().unwrap_or_default();
    // Sections of glTF 1.0 are objects, and an asset needs no version.
    let is_old =
        version.starts_with("1.") || ["nodes", "meshes"].iter().any(|name| document[name].is_object());
    if is_old && !version.starts_with("2.") {
        return Err(SceneError::OldVersion { file: file.into() });
    }
    if !version.starts_with("2.") {
        return Err(wrong(format!("asset.version is {version:?} and should be \"2.0\"")));
    }
    if let Some(min_version) =
        document["asset"]["minVersion"].as_str().filter(|min_version| *min_version != "2.0")
    {
        let what = format!("asset.minVersion is {:?}, but only \"2.0\" is read", cut(min_version, 80));
        if options.strict || !min_version.starts_with("2.") {
            return Err(wrong(what));
        }
        warnings.note("", format_args!("{what}; rendered as far as it is known"));
    }
    Ok(())
}
