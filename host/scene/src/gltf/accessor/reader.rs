//! Reader of accessors, and its errors.

use std::fmt::Display;

use gltf::json::Index;
use gltf::json::accessor::Accessor;

use crate::SceneError;
use crate::gltf::context::ImportContext;
use crate::gltf::document::Document;

/// Reads accessors of a document for one owner; errors name the file and the owner.
#[derive(Clone, Copy)]
pub struct AccessorReader<'a> {
    pub(super) document: &'a Document,
    pub(super) file: &'a str,
    pub(super) owner: &'a str,
}

impl<'a> AccessorReader<'a> {
    /// Reader of the accessors that an owner, such as a primitive, refers to.
    pub fn new(document: &'a Document, context: &ImportContext<'a>, owner: &'a str) -> AccessorReader<'a> {
        AccessorReader { document, file: context.file, owner }
    }

    /// Looks an accessor up.
    pub(super) fn get(&self, index: Index<Accessor>) -> Result<&'a Accessor, SceneError> {
        let accessors = &self.document.root.accessors;
        let missing = || self.index_error(self.owner, "accessor", index.value(), accessors.len());
        accessors.get(index.value()).ok_or_else(missing)
    }

    /// Error of an accessor that does not fit.
    pub(super) fn error(&self, index: Index<Accessor>, what: impl Display) -> SceneError {
        SceneError::Accessor {
            file: self.file.into(),
            accessor: index.value(),
            owner: self.owner.into(),
            what: what.to_string(),
        }
    }

    /// Error of an index out of range.
    pub(super) fn index_error(
        &self,
        owner: &str,
        kind: &'static str,
        index: usize,
        count: usize,
    ) -> SceneError {
        SceneError::Index { file: self.file.into(), owner: owner.into(), kind, index, count }
    }
}
