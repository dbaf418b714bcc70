//! Context of an import: the file's options, the memory budget, and the warnings.

use std::fmt::Display;
use std::path::Path;

use gltf::json::Index;

use super::options::LoadOptions;
use super::warning::Warnings;
use crate::SceneError;
use caustics_files::memory::{Budget, Short};
use caustics_files::text::cut;

/// A required extension that is not supported.
#[derive(Clone, Debug)]
pub struct MissingExtension {
    /// Name of the extension.
    pub extension: String,
    /// Advice to the user.
    pub remedy: &'static str,
}

/// Maximum length of a name in messages (characters).
const MAX_NAME: usize = 80;

/// Context that all stages of an import share. Options go in, warnings come out.
pub struct ImportContext<'a> {
    /// Path of the file, for messages.
    pub file: &'a str,
    /// Folder of the file, to which its references are relative.
    pub folder: &'a Path,
    /// Options of the caller.
    pub options: &'a LoadOptions,
    /// First unsupported extension that the file requires.
    pub missing_extension: Option<MissingExtension>,
    /// Memory budget of the rest of the import.
    budget: Budget,
    warnings: Warnings,
}

impl<'a> ImportContext<'a> {
    /// Begins the import of a file, with a budget of all available memory.
    pub fn new(file: &'a str, folder: &'a Path, options: &'a LoadOptions) -> ImportContext<'a> {
        let (budget, warnings) = (Budget::new(), Warnings::default());
        ImportContext { file, folder, options, missing_extension: None, budget, warnings }
    }

    /// Warns that an element (empty: the file) has a property that is not rendered, or not as described.
    pub fn warn(&mut self, owner: &str, what: impl Display) {
        self.warnings.note(owner, what);
    }

    /// Warns of a fault in an element, and of the replacement. Strict reading returns the error instead.
    pub fn replace(
        &mut self,
        owner: &str,
        what: &str,
        instead: &str,
        error: SceneError,
    ) -> Result<(), SceneError> {
        if self.options.strict {
            return Err(error);
        }
        self.warn(owner, format_args!("{what}; {instead}"));
        Ok(())
    }

    /// Lines of all warnings.
    pub fn warning_lines(&self) -> Vec<String> {
        self.warnings.lines(self.file)
    }

    /// Reserves memory before data is read (bytes, estimated).
    pub fn take(&mut self, bytes: u64, what: impl Display) -> Result<(), SceneError> {
        self.budget.take(bytes).map_err(|Short { needed, available }| SceneError::Memory {
            file: self.file.into(),
            what: what.to_string(),
            needed,
            available,
        })
    }

    /// Reserves memory that is freed before the next object of its kind is read: the growth over the `largest` so far (bytes).
    pub fn take_for_a_while(
        &mut self,
        bytes: u64,
        largest: &mut u64,
        what: impl Display,
    ) -> Result<(), SceneError> {
        self.take(bytes.saturating_sub(*largest), what)?;
        *largest = bytes.max(*largest);
        Ok(())
    }

    /// Looks up an index of an element in a list of the document.
    pub fn get<'b, T>(
        &self,
        list: &'b [T],
        index: Index<T>,
        kind: &'static str,
        owner: &str,
    ) -> Result<&'b T, SceneError> {
        let index = index.value();
        list.get(index).ok_or_else(|| self.index_error(owner, kind, index, list.len()))
    }
}

/// Errors of the file.
impl ImportContext<'_> {
    /// Error of a document that is no glTF.
    pub fn document_error(&self, what: impl Display) -> SceneError {
        SceneError::Document { file: self.file.into(), what: what.to_string() }
    }

    /// Error of an element with an index out of range.
    pub fn index_error(&self, owner: &str, kind: &'static str, index: usize, count: usize) -> SceneError {
        SceneError::Index { file: self.file.into(), owner: owner.into(), kind, index, count }
    }

    /// Error of compressed data.
    pub fn compressed_error(&self, what: impl Display) -> SceneError {
        SceneError::Compressed { file: self.file.into(), what: what.to_string() }
    }

    /// Error of a mesh or a primitive.
    pub fn mesh_error(&self, mesh: &str, what: impl Display) -> SceneError {
        SceneError::Mesh { file: self.file.into(), mesh: mesh.into(), what: what.to_string() }
    }

    /// Error of a node, or of an object on it.
    pub fn node_error(&self, node: &str, what: impl Display) -> SceneError {
        SceneError::Node { file: self.file.into(), node: node.into(), what: what.to_string() }
    }

    /// Error of an animation or one of its channels.
    pub fn animation_error(&self, animation: &str, what: impl Display) -> SceneError {
        SceneError::Animation { file: self.file.into(), animation: animation.into(), what: what.to_string() }
    }

    /// Error of a material with values out of range.
    pub fn material_error(&self, material: &str, what: impl Display) -> SceneError {
        SceneError::Material { file: self.file.into(), material: material.into(), what: what.to_string() }
    }

    /// Error of an image.
    pub fn image_error(&self, image: usize, what: impl Display) -> SceneError {
        SceneError::Image { file: self.file.into(), image, what: what.to_string() }
    }

    /// Error of an environment.
    pub fn environment_error(&self, what: impl Display) -> SceneError {
        SceneError::Environment { file: self.file.into(), what: what.to_string() }
    }

    /// Adds the missing extension to an error as a possible cause. Without a missing extension, returns the error unchanged.
    pub fn explained(&self, error: SceneError) -> SceneError {
        match self.missing_extension.clone() {
            None => error,
            Some(MissingExtension { extension, remedy }) => SceneError::WithoutExtension {
                file: self.file.into(),
                extension,
                remedy,
                source: error.into(),
            },
        }
    }
}

/// Name of an element in messages.
pub fn label(kind: &str, index: usize, name: Option<&str>) -> String {
    let named = |name: &str| format!("{kind} {:?}", cut(name, MAX_NAME));
    name.map_or_else(|| format!("{kind} {index}"), named)
}
