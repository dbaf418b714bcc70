//! Subcommands, one file each, and their shared parts.

pub mod animate;
pub mod bench;
mod checkpoint_writer;
pub mod compare;
pub mod compile;
pub mod console;
pub mod device;
pub mod identity;
pub mod inspect;
pub mod interrupt;
pub mod job;
mod live;
pub mod merge;
pub mod open;
pub mod options;
pub mod pages;
pub mod pick;
pub mod render;
pub mod report;
pub mod report_page;
pub mod scene;
mod shard;
pub mod stop;
mod survey;
pub mod sweep;
pub mod view;
