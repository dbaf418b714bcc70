//! `caustics render`.

use std::process::ExitCode;

use caustics::settings::Settings;
use caustics_kernels::{filter as filters, method};

use super::job::Job;
use super::options::settings;
use super::stop::Stop;
use crate::cli::{Render, Usage};

/// Averages frames of a method.
pub fn run(options: Render) -> anyhow::Result<ExitCode> {
    let Render { common, method, gather, filter, time, light_paths, frames, radius_px } = options;
    let method = method::find(&method).ok_or_else(|| Usage(format!("no method is called {method}")))?;
    let filter = filters::find(&filter).ok_or_else(|| Usage(format!("no filter is called {filter}")))?;
    if !method.takes_filter(filter) {
        let (filter, method) = (filter.name, method.name);
        return Err(Usage(format!(
            "--filter {filter} looks at collection points, and --method {method} makes none; use --method basic"
        ))
        .into());
    }
    let settings = Settings { filter, ..settings(&common, light_paths, frames, radius_px)? };
    let stop = Stop { frames: Some(frames), ..Stop::default() };
    Job { common, settings, method, gather, time, stop }.run()
}
