//! What the server knows.

use std::sync::Arc;

use tokio::sync::Semaphore;

use super::guard::Guard;
use super::page::Page;
use super::shared::Shared;
use super::wheel::Wheel;

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
    /// Who is at the wheel.
    pub wheel: Wheel,
    /// Slots for files on their way to a page.
    pub files: Arc<Semaphore>,
    /// Slots for images that are packed for a page.
    pub packers: Arc<Semaphore>,
}
