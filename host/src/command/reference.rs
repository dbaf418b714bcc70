//! `caustics reference`.

use std::process::ExitCode;
use std::time::Duration;

use caustics::method::path::PATH;

use super::job::{Job, Stop};
use super::options::settings;
use crate::cli::{Reference, Usage};

/// Path traces until a reference is good enough.
pub fn run(options: Reference) -> anyhow::Result<ExitCode> {
    let Reference { common, spp, seconds, target_relmse } = options;
    if let Some(spp @ 0..2) = spp {
        return Err(Usage(format!("--spp {spp}: a variance needs at least 2 samples")).into());
    }
    let positive = |flag: &str, value: Option<f64>| match value {
        Some(value) if !(value.is_finite() && value > 0.0) => {
            Err(Usage(format!("{flag} {value}: give a positive number")))
        }
        value => Ok(value),
    };
    let seconds = positive("--seconds", seconds)?;
    let relative_error = positive("--target-relmse", target_relmse)?;
    let time = seconds.map(Duration::try_from_secs_f64).transpose();
    let time = time.map_err(|error| Usage(format!("--seconds: {error}")))?;
    let endless = time.is_none() && relative_error.is_none();
    let stop = Stop { frames: spp.or(endless.then_some(1024)), time, relative_error };
    let settings = settings(&common, 1, 1, 1.0)?;
    Job { common, settings, method: &PATH, gather: None, stop }.run()
}
