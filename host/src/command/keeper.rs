//! What a run keeps on disk to go on from: where that fails, the run is worth less, but goes on.

use super::say::told;

/// Says when something cannot be kept, once for as long as it lasts.
pub struct Keeper {
    what: &'static str,
    is_kept: bool,
}

impl Keeper {
    /// Of what is kept.
    pub fn new(what: &'static str) -> Keeper {
        Keeper { what, is_kept: true }
    }

    /// Takes note of how it went.
    pub fn keep(&mut self, result: anyhow::Result<()>) {
        if let (Err(error), true) = (&result, self.is_kept) {
            tell!("warning: {} is not written, and the run goes on without: {}", self.what, told(error));
        }
        self.is_kept = result.is_ok();
    }

    /// Whether it went well the last time.
    pub fn is_kept(&self) -> bool {
        self.is_kept
    }
}
