//! Images to files: EXR with every layer, PNG for people. No file is ever half-written.

pub mod attributes;
mod error;
pub mod exr;
mod folder;
pub mod lock;
pub mod png;
pub mod target;

pub use self::error::EncodeError;
