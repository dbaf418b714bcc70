//! Files: images, checkpoints and files of any source. Reading stays within the available memory; files are written whole
//! or not at all. Text of unknown origin is made harmless for terminals and shells.

#![cfg_attr(not(test), deny(clippy::print_stderr, clippy::print_stdout))]
#![forbid(unsafe_code)]

pub mod caught;
pub mod exact;
pub mod file;
pub mod hash;
pub mod image_file;
pub mod memory;
pub mod output;
pub mod program;
pub mod rendered_image;
pub mod sealed;
pub mod shell;
pub mod text;

pub use rendered_image::RenderedImage;
