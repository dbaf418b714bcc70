//! Reads glTF 2.0 (.gltf, .glb) into [`SceneParts`](super::SceneParts). Imports the crate gltf's document types.
//!
//! An import has four stages. Each takes the result of the previous stage, and returns its own result or an error:
//!
//! 1. [`Container`]: a file is split into its JSON and its binary chunk.
//! 2. [`CheckedJson`]: the JSON is parsed ([`json`]), its version and types are checked, extensions are translated.
//!    [`Document`]: its members get types, its buffers are loaded.
//! 3. [`decoding`]: passes decode meshopt, Draco and vertex colours. Later stages do not change the document.
//! 4. [`scene_builder`]: the node tree is walked, sharing is planned, images are decoded, meshes and materials are read, and the
//!    tables are assembled.
//!
//! All stages share an [`ImportContext`]: the caller's options, the memory budget and the warnings. Memory is reserved before
//! data is decoded into it. All look-ups in documents are checked: every file gives a scene or an error. Photometric values are
//! used as radiometric ones, number for number.

use std::path::Path;

use self::checked_json::CheckedJson;
use self::container::Container;
use self::context::ImportContext;
use self::document::Document;
use self::options::LoadOptions;
use super::{Scene, SceneError};
use caustics_files::file::read_file;

mod accessor;
mod checked_json;
mod container;
mod context;
mod decoding;
mod document;
pub mod files;
mod json;
pub mod options;
mod primitive;
mod scene_builder;
#[cfg(test)]
mod tests;
mod warning;

impl Scene {
    /// Loads a .gltf or .glb file, at time 0 of its animations. The scene may have no light and no camera
    /// ([`Scene::add_default_light`], [`Scene::place_camera`]). [`resolve`](super::resolve) finds the file of a scene by name.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, is damaged, requires an extension that is not supported, or would not fit into memory. Every
    /// error names the file and the remedy. [`Scene::warnings`] names elements that are left out.
    pub fn load(path: &Path) -> Result<Scene, SceneError> {
        Scene::load_with(path, &LoadOptions::default())
    }

    /// Loads a .gltf or .glb file with options; see [`Scene::load`].
    ///
    /// # Errors
    ///
    /// Errors of [`Scene::load`]; with [`LoadOptions::strict`], also elements that would be replaced.
    pub fn load_with(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
        let file = path.display().to_string();
        let bytes =
            read_file(path).map_err(|source| SceneError::Unreadable { file: file.clone(), source })?;
        let mut scene = read(&file, &bytes, path.parent().unwrap_or(Path::new("")), options)?;
        scene.name = scene_name(path);
        Ok(scene)
    }
}

/// Name of a scene: the stem of the file, or the name of its folder if the stem is generic.
fn scene_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    let folder = path.parent().and_then(Path::file_name).filter(|_| stem == "scene");
    folder.unwrap_or(stem).to_string_lossy().into_owned()
}

/// Imports a file from its bytes. The file must not refer to other files.
pub fn read_alone(bytes: &[u8]) -> Result<Scene, SceneError> {
    read("scene", bytes, Path::new("/no folder"), &LoadOptions::default())
}

/// Imports a file from its bytes; other files are found in `folder`.
fn read(file: &str, bytes: &[u8], folder: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let mut context = ImportContext::new(file, folder, options);
    run_stages(bytes, &mut context).map_err(|error| context.explained(error))
}

/// Runs the four stages.
fn run_stages(bytes: &[u8], context: &mut ImportContext<'_>) -> Result<Scene, SceneError> {
    let container = Container::split(context.file, bytes)?;
    let json = CheckedJson::read(container.json, context)?;
    let document = Document::load(json, container.binary, context)?;
    let model = decoding::decode(document, context)?;
    scene_builder::build(&model, context)
}
