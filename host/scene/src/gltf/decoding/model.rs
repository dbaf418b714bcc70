//! Model: the result of decoding.

use std::collections::HashMap;
use std::ops::Deref;

use super::atlas::Atlas;
use crate::gltf::document::Document;

/// Decoded document, of which a scene is built. Nothing changes it any more.
pub struct Model {
    pub(super) document: Document,
    /// Positions of triangles on images of vertex colours, by the index of the material.
    pub(super) atlases: HashMap<usize, Atlas>,
}

impl Model {
    /// Positions of the triangles of a material on an image of vertex colours, if it shows one.
    pub fn atlas(&self, material: usize) -> Option<Atlas> {
        self.atlases.get(&material).copied()
    }
}

impl Deref for Model {
    type Target = Document;

    fn deref(&self) -> &Document {
        &self.document
    }
}
