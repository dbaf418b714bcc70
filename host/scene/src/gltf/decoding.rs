//! Stage 3, decoding: decompresses meshes, and turns vertex colours into materials and textures.
//!
//! Images are decoded later (`scene_builder/image.rs`), once the set of shown images and their memory is known.

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

/// A pass that replaces part of a model by plain buffers, materials and textures.
type DecodingPass = fn(&mut Model, &mut ImportContext<'_>) -> Result<(), SceneError>;

/// Passes in order.
const PASSES: [DecodingPass; 3] = [
    // Compressed buffer views
    meshopt::decompress,
    // Primitives that are compressed as a whole; their streams may lie in such views
    draco::decompress,
    // Vertex colours, whose accessors both passes may create
    vertex_colors::bake,
];

/// Runs all passes on a document.
pub fn decode(document: Document, context: &mut ImportContext<'_>) -> Result<Model, SceneError> {
    let mut model = Model { document, atlases: HashMap::new() };
    for pass in PASSES {
        pass(&mut model, context)?;
    }
    Ok(model)
}
