//! Writing of checkpoints and other files of an unfinished run: where it fails, the run warns and goes on.

use super::console::error_chain;

/// Warns when a file of an unfinished run cannot be written, once until it can be again.
pub struct CheckpointWriter {
    what: &'static str,
    is_kept: bool,
}

impl CheckpointWriter {
    /// Returns a writer of `what`, which warnings name.
    pub fn new(what: &'static str) -> CheckpointWriter {
        CheckpointWriter { what, is_kept: true }
    }

    /// Takes the result of writing, and warns of a failure.
    pub fn keep(&mut self, result: anyhow::Result<()>) {
        if let (Err(error), true) = (&result, self.is_kept) {
            message!(
                "warning: {} is not written, and the run goes on without: {}",
                self.what,
                error_chain(error)
            );
        }
        self.is_kept = result.is_ok();
    }

    /// Whether it was written the last time.
    pub fn is_kept(&self) -> bool {
        self.is_kept
    }
}
