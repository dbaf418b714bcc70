//! Checks and translates the JSON of a document.

pub mod missing_extension;
pub mod shape;
pub mod translate;
pub mod unsupported;
pub mod version;
