//! Decodes what is compressed in a document, and its vertex colours.

use super::document::Document;
use crate::SceneError;

pub mod atlas;
mod draco;
mod meshopt;
mod vertex_colors;

/// Pass over a document.
type DecodingPass = fn(&mut Document) -> Result<(), SceneError>;

/// Passes, in their order.
const PASSES: [DecodingPass; 3] = [meshopt::decompress, draco::decompress, vertex_colors::bake];

/// Runs all passes.
pub fn decode(document: &mut Document) -> Result<(), SceneError> {
    PASSES.iter().try_for_each(|pass| pass(document))
}
