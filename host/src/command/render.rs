//! `caustics render`.

use std::process::ExitCode;

use caustics::method;

use super::job::Job;
use super::options::settings;
use super::stop::Stop;
use crate::cli::{Render, Usage};

/// Averages frames of a method.
pub fn run(options: Render) -> anyhow::Result<ExitCode> {
    let Render { common, method, gather, light_paths, frames, radius_px } = options;
    let settings = settings(&common, light_paths, frames, radius_px)?;
    let method = method::find(&method).ok_or_else(|| Usage(format!("no method is called {method}")))?;
    let stop = Stop { frames: Some(frames), ..Stop::default() };
    Job { common, settings, method, gather, stop }.run()
}
