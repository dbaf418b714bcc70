//! Files of a scene.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::container::Container;
use super::document::{buffer, scene_extras};
use caustics_files::file::read_file;

/// Lists the document, and the files of its buffers, images and environment. Faults are ignored: loading names them.
pub fn files(path: &Path) -> Vec<PathBuf> {
    let bytes = read_file(path).unwrap_or_default();
    let json = Container::split("", &bytes).map(|container| container.json).unwrap_or_default();
    let document: Value = serde_json::from_slice(json).unwrap_or_default();
    let folder = path.parent().unwrap_or(Path::new(""));
    let uris = ["buffers", "images"].into_iter().flat_map(|section| document[section].as_array()).flatten();
    let uris = uris.chain([&scene_extras(&document)["environment"]]);
    let uris = uris.filter_map(|section| section["uri"].as_str()).filter(|uri| !uri.starts_with("data:"));
    [path.to_path_buf()].into_iter().chain(uris.map(|uri| buffer::path_of(uri, folder))).collect()
}
