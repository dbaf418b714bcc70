//! State of the server.

use std::sync::Arc;

use tokio::sync::Semaphore;

use super::control_token::ControlToken;
use super::guard::Guard;
use super::page::Page;
use super::shared::Shared;

/// State of the server.
pub struct Site {
    /// State shared with the renderer.
    pub shared: Arc<Shared>,
    /// Access control.
    pub guard: Guard,
    /// The page.
    pub page: Page,
    /// Identifier of this run of the program.
    pub run: String,
    /// Open pages, and the one that has control.
    pub control_token: ControlToken,
    /// Slots for files in transfer to pages.
    pub files: Arc<Semaphore>,
    /// Slots for images that are being encoded for pages.
    pub packers: Arc<Semaphore>,
}
