//! Ctrl-C: ends after the frame at hand; what is done is saved, and a part of a file never stays. A second one ends at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

/// Catches Ctrl-C from now on; says whether it came. Once in a process.
pub fn watch() -> anyhow::Result<impl Fn() -> bool> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    let handler = move || {
        if flag.swap(true, Ordering::SeqCst) {
            // Nothing is saved: who asks twice wants the machine back. Outputs are in their place or not there at all.
            std::process::exit(130);
        }
        tell!("interrupted: ends after the frame at hand; once more ends at once");
    };
    ctrlc::set_handler(handler).context("cannot catch Ctrl-C")?;
    Ok(move || interrupted.load(Ordering::SeqCst))
}
