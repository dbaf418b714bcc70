//! Tests of the commands that measure: bench, sweep, compare and report.

mod bench;
mod compare;
mod experiments;
mod report;
mod sweep;
#[path = "../fixture/test_dir.rs"]
#[allow(dead_code)] // Each of the two binaries uses a part.
mod test_dir;
