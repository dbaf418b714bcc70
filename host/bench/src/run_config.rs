//! Run configurations, which an experiment compares with each other.

use caustics::render_config::RenderConfig;
use caustics::session::RunnerChoice;

/// A run configuration: all that can vary in an experiment.
#[derive(Clone, Debug)]
pub struct RunConfig {
    /// Name in tables, assigned by `name_all`.
    pub name: String,
    /// Settings of the frames; those of the image are the plan's.
    pub config: RenderConfig,
    /// Runner.
    pub runner: RunnerChoice,
    /// Name of the runner that the user asked for.
    pub asked_runner: &'static str,
}

impl RunConfig {
    /// Returns this configuration with changed settings.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut RenderConfig)) -> RunConfig {
        change(&mut self.config);
        self
    }
}

/// Returns `cpu`, `gpu-hardware` or `gpu-software`.
pub fn runner_name(runner: &RunnerChoice) -> &'static str {
    match runner {
        RunnerChoice::Cpu { .. } => "cpu",
        RunnerChoice::Gpu { hardware: true, .. } => "gpu-hardware",
        RunnerChoice::Gpu { hardware: false, .. } => "gpu-software",
    }
}
