//! What the server knows.

use std::sync::Arc;

use tokio::sync::Semaphore;

use super::control_token::ControlToken;
use super::guard::Guard;
use super::page::Page;
use super::shared::Shared;

/// What the server knows.
pub struct Site {
    /// What the renderer shares.
    pub shared: Arc<Shared>,
    /// Who may come.
    pub guard: Guard,
    /// The page.
    pub page: Page,
    /// What tells this run of the program from others.
    pub run: String,
    /// The open pages, and which of them has control.
    pub control_token: ControlToken,
    /// Slots for files on their way to a page.
    pub files: Arc<Semaphore>,
    /// Slots for images that are packed for a page.
    pub packers: Arc<Semaphore>,
}
