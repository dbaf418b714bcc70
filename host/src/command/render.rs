//! `caustics render`.

use std::process::ExitCode;

use super::job::Job;
use super::options::settings;
use super::stop::Stop;
use crate::cli::Render;

/// Averages frames of a method.
pub fn run(options: Render) -> anyhow::Result<ExitCode> {
    let Render { common, axes, time, frames } = options;
    let cell = axes.cell()?;
    let settings = settings(&common.view, &cell, frames)?;
    let stop = Stop { frames: Some(frames), ..Stop::default() };
    Job { common, settings, cell, time, stop }.run()
}
