//! The subcommands, a file each.

pub mod compare;
pub mod device;
pub mod pick;
pub mod render;
pub mod scene;
