//! Writes checkpoints and other files of an unfinished run. After a failure the run warns and continues.

use super::console::error_chain;

/// Warns when a file of an unfinished run cannot be written; warns again only after a success.
pub struct CheckpointWriter {
    what: &'static str,
    is_kept: bool,
}

impl CheckpointWriter {
    /// Returns a writer; warnings name the file by `what`.
    pub fn new(what: &'static str) -> CheckpointWriter {
        CheckpointWriter { what, is_kept: true }
    }

    /// Takes the result of a write, and warns of a failure.
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

    /// Whether the last write succeeded.
    pub fn is_kept(&self) -> bool {
        self.is_kept
    }
}
