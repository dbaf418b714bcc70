//! Run configurations, which an experiment holds against each other.

use caustics::render_config::RenderConfig;
use caustics::session::RunnerChoice;

/// A run configuration: all that can vary in an experiment.
#[derive(Clone, Debug)]
pub struct RunConfig {
    /// Its name in tables, as `name_all` gives it.
    pub name: String,
    /// How frames are rendered; settings of the image are those of its plan.
    pub config: RenderConfig,
    /// Where it runs.
    pub runner: RunnerChoice,
    /// The runner that was asked for, by its name.
    pub asked_runner: &'static str,
}

impl RunConfig {
    /// The same with changed settings.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut RenderConfig)) -> RunConfig {
        change(&mut self.config);
        self
    }
}

/// `cpu`, `gpu-hardware` or `gpu-software`.
pub fn runner_name(runner: &RunnerChoice) -> &'static str {
    match runner {
        RunnerChoice::Cpu { .. } => "cpu",
        RunnerChoice::Gpu { hardware: true, .. } => "gpu-hardware",
        RunnerChoice::Gpu { hardware: false, .. } => "gpu-software",
    }
}
