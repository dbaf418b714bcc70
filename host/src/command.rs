//! The subcommands, a file each, and what several of them share.

pub mod animate;
pub mod bar;
pub mod bench;
pub mod bench_plan;
pub mod bench_report;
pub mod bench_still;
pub mod compare;
pub mod device;
pub mod identity;
pub mod interrupt;
pub mod job;
mod keeper;
pub mod merge;
pub mod options;
pub mod pick;
pub mod reference;
pub mod render;
pub mod report;
pub mod report_page;
pub mod say;
pub mod scene;
pub mod stop;
pub mod sweep;
pub mod sweep_cell;
pub mod sweep_group;
pub mod warn;
