//! Model: the result of decoding.

use std::collections::HashMap;
use std::ops::Deref;

use super::atlas::Atlas;
use crate::gltf::document::Document;

/// Decoded document, from which a scene is built. It does not change any more.
pub struct Model {
    pub(super) document: Document,
    /// Atlases of vertex colours, by the index of the material.
    pub(super) atlases: HashMap<usize, Atlas>,
}

impl Model {
    /// Atlas of a material's vertex colours, if it has them.
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
