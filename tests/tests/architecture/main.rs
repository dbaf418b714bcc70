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
