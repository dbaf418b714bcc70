//! Stage 2, the checks: the version, the types of all members, and the translation of extensions for later stages.

use serde_json::Value;

use super::context::ImportContext;
use super::json;
use crate::SceneError;
use caustics_files::memory::json_tree_bytes;

mod missing_extension;
mod shape;
pub mod translate;
mod unsupported;
mod version;

/// JSON of a document, checked and translated.
pub struct CheckedJson {
    /// The document.
    pub value: Value,
    /// Length of its text (bytes).
    pub bytes: u64,
}

impl CheckedJson {
    /// Parses a text, refuses documents that are not glTF 2, and rewrites extensions for later stages.
    pub fn read(json: &[u8], context: &mut ImportContext<'_>) -> Result<CheckedJson, SceneError> {
        // Twice: the text and the sections are copied once.
        context.take(2 * json_tree_bytes(json), "its JSON")?;
        let mut value = json::parse(json).map_err(|error| context.document_error(error))?;

        // Check
        version::check(&value, context)?;
        shape::check(&value).map_err(|what| context.document_error(what))?;
        missing_extension::check(&value, context)?;

        // Translate
        translate::translate(&mut value, context)?;
        unsupported::warn(&value, context);
        Ok(CheckedJson { value, bytes: json.len() as u64 })
    }
}
