//! Stage 2, the checks: JSON of a version that is read, whose members have the types of glTF, in terms that the later stages know.

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
    /// Parses a text, refuses what is no glTF 2, and rewrites extensions in terms of what later stages read.
    pub fn read(json: &[u8], context: &mut ImportContext<'_>) -> Result<CheckedJson, SceneError> {
        // Sections are there twice, and so is the text.
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
