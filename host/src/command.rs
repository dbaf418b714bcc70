//! The subcommands, a file each, and what several of them share.

pub mod animate;
mod aov;
pub mod bar;
pub mod bench;
pub mod compare;
pub mod compile;
pub mod device;
pub mod identity;
pub mod interrupt;
pub mod job;
mod keeper;
mod live;
pub mod merge;
pub mod open;
pub mod options;
pub mod pages;
pub mod pick;
pub mod reference;
pub mod render;
pub mod report;
pub mod report_page;
pub mod say;
pub mod scene;
pub mod stop;
mod survey;
pub mod sweep;
pub mod warn;
