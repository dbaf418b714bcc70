//! Tasks: a run configuration of a sweep, and the context in which it is measured.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::PathBuf;

use super::config::SweepConfig;
use super::expand::SweepPart;
use crate::result::{FrameResult, RunResult};
use crate::run_config::RunConfig;
use crate::store::Results;
use caustics::render_config::{Paths, RenderConfig};

/// A run configuration with its scene and identity.
#[derive(Clone, Debug)]
pub struct Task<'a> {
    /// Its scene.
    pub part: &'a SweepPart,
    /// The run configuration.
    pub run: RunConfig,
    /// Hash of everything that decides its measures.
    pub identity: String,
}

impl<'a> Task<'a> {
    /// Returns the task of a run configuration of a part.
    pub fn new(config: &SweepConfig, part: &'a SweepPart, run: &RunConfig) -> Task<'a> {
        Task { part, run: run.clone(), identity: part.identity(config, run) }
    }

    /// Returns the tasks of all run configurations of a part.
    pub fn all(config: &SweepConfig, part: &'a SweepPart) -> Vec<Task<'a>> {
        part.runs.iter().map(|run| Task::new(config, part, run)).collect()
    }

    /// Whether a result has everything that the sweep measures.
    pub fn is_whole(&self, config: &SweepConfig, result: &RunResult) -> bool {
        (config.time.is_none() || result.time.is_some()) && (config.error.is_none() || result.error.is_some())
    }

    /// Whether the results have everything that the sweep measures of this task.
    pub fn is_done(&self, config: &SweepConfig, results: &Results) -> bool {
        results.read(&self.identity).is_some_and(|result| self.is_whole(config, &result))
    }
}

/// Context that all tasks of a sweep share.
pub struct SweepContext<'a> {
    /// The sweep's settings.
    pub config: &'a SweepConfig,
    /// Destination of the results.
    pub results: &'a Results,
    /// Folder of the references.
    pub cache: PathBuf,
    /// Returns whether the run has to stop.
    pub stopped: &'a dyn Fn() -> bool,
    /// Receives messages on the progress.
    pub on_message: &'a dyn Fn(&str),
    /// Light paths found by search, by the identity of the run configuration.
    pub found: RefCell<BTreeMap<String, Paths>>,
}

impl SweepContext<'_> {
    /// Returns the result of a task, or an empty one. `run` is the task's configuration with the light paths that were
    /// found.
    pub fn result(&self, task: &Task, run: &RunConfig) -> RunResult {
        self.results.read(&task.identity).unwrap_or_else(|| {
            let of_error = self.config.error.as_ref().map(|error| (error.width.0, error.height.0));
            let (width, height) = task.part.timed_size.or(of_error).unwrap_or((1, 1));
            let config = RenderConfig { width, height, ..task.part.plan(self.config).config };
            RunResult {
                identity: task.identity.clone(),
                config: run.values(&task.part.scene, &task.part.camera, &config),
                ..RunResult::default()
            }
        })
    }
}

/// Merges frames of two results, each with the values that either has.
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
