//! Writes images: EXR with every layer, PNG for viewing. A file appears whole or not at all.

pub mod attributes;
mod error;
pub mod exr;
mod folder;
pub mod lock;
pub mod png;
pub mod target;

pub use self::error::EncodeError;
