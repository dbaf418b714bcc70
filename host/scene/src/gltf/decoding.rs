//! Stage 3, decoding: a document in which nothing is compressed any more and vertex colours are materials and textures.
//!
//! Images are decoded later (`scene_builder/image.rs`): which of them a scene shows, and so how much memory they take, is known
//! only then.

use std::collections::HashMap;

use self::model::Model;
use super::context::ImportContext;
use super::document::Document;
use crate::SceneError;

pub mod atlas;
mod draco;
mod meshopt;
pub mod model;
mod vertex_colors;

/// Pass that replaces a part of a model by plain buffers, materials and textures.
type DecodingPass = fn(&mut Model, &mut ImportContext<'_>) -> Result<(), SceneError>;

/// Passes, in their order.
const PASSES: [DecodingPass; 3] = [
    // Buffer views whose bytes are compressed
    meshopt::decompress,
    // Primitives that are compressed as a whole; their streams may lie in such views
    draco::decompress,
    // Vertex colours, whose accessors both may make
    vertex_colors::bake,
];

/// Decodes a document by all passes.
pub fn decode(document: Document, context: &mut ImportContext<'_>) -> Result<Model, SceneError> {
    let mut model = Model { document, atlases: HashMap::new() };
    for pass in PASSES {
        pass(&mut model, context)?;
    }
    Ok(model)
}
