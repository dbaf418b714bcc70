//! What reads files of others, from bytes: for the targets of cargo-fuzz in `fuzz/`, and for the test that replays their
//! corpus. Each says whether the bytes are accepted. No interface for others.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::accumulation::Shape;
use crate::checkpoint::{self, Identity};
use crate::experiment::store;
use crate::experiment::sweep::config::Config;
use crate::image::Channels;
use crate::scene;

/// A .gltf or .glb file, without others beside it, brought to the end of its animations.
pub fn scene(bytes: &[u8]) -> bool {
    scene::read(bytes).is_ok_and(|mut scene| {
        scene.needs(0.25);
        let end = scene.duration();
        scene.pose(0.5 * end).is_ok() & scene.pose(end).is_ok()
    })
}

/// An EXR or PNG file.
pub fn picture(bytes: &[u8]) -> bool {
    let (_folder, path) = written("picture", bytes);
    Channels::read(&path).is_ok_and(|picture| {
        // Every name that is told is known; the beauty layer's own is empty.
        let told = |name: &String| name == "beauty" || picture.layer(name).is_some();
        assert!(picture.layer_names().iter().all(told));
        true
    })
}

/// A checkpoint of a run without any identity, of 2 pixels.
pub fn checkpoint(bytes: &[u8]) -> bool {
    let shape = Shape { width: 2, height: 1, frames: 0, gathers: false };
    checkpoint::parse(Path::new("checkpoint"), bytes, &Identity::default(), shape).is_ok_and(|(sums, _)| {
        drop((sums.mean(), sums.variance(), sums.relative_error()));
        true
    })
}

/// The TOML of a sweep.
pub fn sweep(bytes: &[u8]) -> bool {
    std::str::from_utf8(bytes).is_ok_and(|text| Config::parse(text).is_ok())
}

/// The JSON of a cell's result.
pub fn result(bytes: &[u8]) -> bool {
    let (folder, _) = written("cells/0123456789abcdef.json", bytes);
    store::read_all(folder.path()).is_ok()
}

/// A file of these bytes in a folder of its own.
fn written(name: &str, bytes: &[u8]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::create_dir_all(path.parent().unwrap_or(Path::new("."))).expect("a folder in it");
    std::fs::write(&path, bytes).expect("a file in it");
    (folder, path)
}
