//! What an experiment measures: what its cells have in common.

use std::ops::Range;

use super::cell::Cell;
use crate::settings::Settings;

/// What is measured.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What is rendered, in the order of tables.
    pub cells: Vec<Cell>,
    /// Settings of all cells; what a cell has is its own.
    pub settings: Settings,
    /// Name of the camera.
    pub camera: String,
    /// Indices of the frames.
    pub frames: Range<u32>,
    /// Frames a second; frame k shows the time k / fps.
    pub fps: f64,
    /// The time that all frames show instead (s).
    pub moment: Option<f64>,
    /// Frames rendered at the first frame's pose before it, and not recorded.
    pub warm_up: u32,
    /// Whether times are recorded.
    pub time: bool,
    /// How errors are measured, if they are.
    pub error: Option<ErrorPlan>,
}

/// How errors are measured.
#[derive(Clone, Copy, Debug)]
pub struct ErrorPlan {
    /// Independent runs of each cell: seeds from that of the settings on.
    pub seeds: u32,
    /// Frames of the progressive reference.
    pub reference_frames: u32,
}

impl Plan {
    /// Time that a frame shows (s).
    pub fn time_of(&self, frame: u32) -> f64 {
        self.moment.unwrap_or(f64::from(frame) / self.fps)
    }

    /// Runs of each cell.
    pub fn seeds(&self) -> u32 {
        self.error.map_or(1, |error| error.seeds)
    }
}
