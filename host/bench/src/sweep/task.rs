//! What is measured with what: a cell of a sweep, and the sweep that it belongs to.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::PathBuf;

use super::config::SweepConfig;
use super::expand::SweepPart;
use crate::cell::Cell;
use crate::result::{CellResult, FrameResult};
use crate::store::Results;
use caustics::render_config::{Paths, RenderConfig};

/// A cell and what it is known by.
#[derive(Clone, Debug)]
pub struct Task<'a> {
    /// Its scene.
    pub part: &'a SweepPart,
    /// The cell.
    pub cell: Cell,
    /// Hash of all that decides its measures.
    pub identity: String,
}

impl<'a> Task<'a> {
    /// A cell of a part.
    pub fn new(config: &SweepConfig, part: &'a SweepPart, cell: &Cell) -> Task<'a> {
        Task { part, cell: cell.clone(), identity: part.identity(config, cell) }
    }

    /// All cells of a part.
    pub fn all(config: &SweepConfig, part: &'a SweepPart) -> Vec<Task<'a>> {
        part.cells.iter().map(|cell| Task::new(config, part, cell)).collect()
    }

    /// Whether a result is all that is asked for.
    pub fn is_whole(&self, config: &SweepConfig, result: &CellResult) -> bool {
        (config.time.is_none() || result.time.is_some()) && (config.error.is_none() || result.error.is_some())
    }

    /// Whether all that is asked for is among the results.
    pub fn is_done(&self, config: &SweepConfig, results: &Results) -> bool {
        results.read(&self.identity).is_some_and(|result| self.is_whole(config, &result))
    }
}

/// What all cells are measured with.
pub struct SweepContext<'a> {
    /// What is measured.
    pub config: &'a SweepConfig,
    /// Where results go.
    pub results: &'a Results,
    /// Where references are kept.
    pub cache: PathBuf,
    /// Whether the run is to stop.
    pub stopped: &'a dyn Fn() -> bool,
    /// Receives messages on the progress.
    pub on_message: &'a dyn Fn(&str),
    /// Light paths that were searched for, by the cell's identity.
    pub found: RefCell<BTreeMap<String, Paths>>,
}

impl SweepContext<'_> {
    /// The result that a task has; an empty one where it has none. `cell` is the task's with the light paths that were found.
    pub fn result(&self, task: &Task, cell: &Cell) -> CellResult {
        self.results.read(&task.identity).unwrap_or_else(|| {
            let of_error = self.config.error.as_ref().map(|error| (error.width.0, error.height.0));
            let (width, height) = task.part.timed_size.or(of_error).unwrap_or((1, 1));
            let config = RenderConfig { width, height, ..task.part.plan(self.config).config };
            CellResult {
                identity: task.identity.clone(),
                cell: cell.values(&task.part.scene, &task.part.camera, &config),
                ..CellResult::default()
            }
        })
    }
}

/// Frames of both, each with what either knows.
pub fn joined(a: &[FrameResult], b: &[FrameResult]) -> Vec<FrameResult> {
    let mut all: BTreeMap<u32, FrameResult> = BTreeMap::new();
    for result in a.iter().chain(b) {
        let frame = all
            .entry(result.frame)
            .or_insert_with(|| FrameResult { frame: result.frame, ..Default::default() });
        frame.total_ms = result.total_ms.or(frame.total_ms);
        frame.values.extend(result.values.iter().map(|(key, value)| (key.clone(), *value)));
    }
    all.into_values().collect()
}
