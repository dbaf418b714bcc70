//! `caustics render`.

use std::process::ExitCode;

use caustics::settings::Settings;
use caustics_kernels::{denoiser as denoisers, method};

use super::job::Job;
use super::options::settings;
use super::stop::Stop;
use crate::cli::{Render, Usage};

/// Averages frames of a method.
pub fn run(options: Render) -> anyhow::Result<ExitCode> {
    let Render { common, method, gather, denoiser, time, light_paths, frames, radius_px } = options;
    let method = method::find(&method).ok_or_else(|| Usage(format!("no method is called {method}")))?;
    let denoiser =
        denoisers::find(&denoiser).ok_or_else(|| Usage(format!("no denoiser is called {denoiser}")))?;
    if !method.takes_denoiser(denoiser) {
        let (denoiser, method) = (denoiser.name, method.name);
        return Err(Usage(format!(
            "--denoiser {denoiser} looks at collection points, and --method {method} makes none; use --method basic"
        ))
        .into());
    }
    let settings = Settings { denoiser, ..settings(&common, light_paths, frames, radius_px)? };
    let stop = Stop { frames: Some(frames), ..Stop::default() };
    Job { common, settings, method, gather, time, stop }.run()
}
