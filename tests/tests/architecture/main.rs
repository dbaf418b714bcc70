//! Tests of the project itself: its dependencies, its layers, its metrics against those of others, its corpus, and the
//! bits that a refactoring must keep.

mod ci;
mod corpus;
mod dependencies;
mod flip;
mod images;
mod layers;
mod prose;
mod quotes;
mod ray_queries;
mod reading;
mod unused;
mod words;

use std::path::{Path, PathBuf};

/// Root of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Path of a file from the root of the repository, with slashes.
fn name(path: &Path) -> String {
    path.strip_prefix(root()).expect("a file below the root").to_string_lossy().replace('\\', "/")
}
