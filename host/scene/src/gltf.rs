//! Reads glTF 2.0 (.gltf, .glb) into [`SceneParts`](super::SceneParts). Imports the crate gltf's document types.
//!
//! The document is walked by checked look-ups only: whatever a file holds, it gives a scene or an error. Photometric
//! values are taken as radiometric ones, number for number.

use std::path::Path;

use self::checked_json::missing_extension;
use self::document::Document;
use self::options::LoadOptions;
use super::{Scene, SceneError};
use caustics_files::file::read_file;

mod accessor;
mod checked_json;
mod decoding;
mod document;
pub mod files;
pub mod options;
mod scene_builder;
#[cfg(test)]
mod tests;
mod warning;

impl Scene {
    /// Loads a .gltf or .glb file, at time 0 of its animations; it may be dark and have no camera ([`Scene::add_default_light`],
    /// [`Scene::place_camera`]). [`resolve`](super::resolve) finds the file of a scene by name.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, is damaged, requires an extension that is not supported, or would not fit into memory. Every
    /// error names the file and what to do. What is merely left out stands in [`Scene::warnings`].
    pub fn load(path: &Path) -> Result<Scene, SceneError> {
        Scene::load_with(path, &LoadOptions::default())
    }

    /// Loads a .gltf or .glb file in a way of the caller's; what [`Scene::load`] says holds else.
    ///
    /// # Errors
    ///
    /// Those of [`Scene::load`], and with [`LoadOptions::strict`] where something would be replaced.
    pub fn load_with(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
        let file = path.display().to_string();
        let bytes =
            read_file(path).map_err(|source| SceneError::Unreadable { file: file.clone(), source })?;
        let mut scene = read(&file, &bytes, path.parent().unwrap_or(Path::new("")), options)?;
        scene.name = scene_name(path);
        Ok(scene)
    }
}

/// The file's stem, or its folder's name where the stem says nothing.
fn scene_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    let folder = path.parent().and_then(Path::file_name).filter(|_| stem == "scene");
    folder.unwrap_or(stem).to_string_lossy().into_owned()
}

/// Reads a scene that is one file, from its bytes.
pub fn read_alone(bytes: &[u8]) -> Result<Scene, SceneError> {
    read("scene", bytes, Path::new("/no folder"), &LoadOptions::default())
}

/// Reads a scene from a file's bytes; other files are looked for in `folder`.
fn read(file: &str, bytes: &[u8], folder: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let document = Document::read(file, bytes, folder, options)?;
    let lack = document.lack.clone();
    scene_builder::scene_of(document).map_err(|error| missing_extension::without(lack, error))
}
