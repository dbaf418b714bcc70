//! Ctrl-C: ends after the frame at hand; what is done is saved, and a part of a file never stays.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

/// Catches Ctrl-C from now on; says whether it came. Once in a process.
pub fn watch() -> anyhow::Result<impl Fn() -> bool> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    ctrlc::set_handler(move || flag.store(true, Ordering::SeqCst)).context("cannot catch Ctrl-C")?;
    Ok(move || interrupted.load(Ordering::SeqCst))
}
