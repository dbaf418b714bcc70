//! The project itself: its dependencies, its rings, its metrics against those of others, and the bits that a refactoring must
//! keep.

mod dependencies;
mod flip;
mod pictures;
mod rings;
