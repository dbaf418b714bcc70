//! `caustics reference`.

use std::process::ExitCode;

use caustics_bench::cell::Cell;
use caustics_kernels::method::path::PATH;

use super::job::Job;
use super::options::{duration, settings};
use super::stop::Stop;
use crate::cli::{Reference, Usage};

/// Path traces until a reference is good enough.
pub fn run(options: Reference) -> anyhow::Result<ExitCode> {
    let Reference { common, parameters, time, spp, seconds, target_relmse } = options;
    if let Some(spp @ 0..2) = spp {
        return Err(Usage(format!("--spp {spp}: a variance needs at least 2 samples")).into());
    }
    if let Some(target) = target_relmse
        && !(target.is_finite() && target > 0.0)
    {
        return Err(Usage(format!("--target-relmse {target}: give a positive number")).into());
    }
    let limit = seconds.map(|seconds| duration("--seconds", seconds)).transpose()?;
    let endless = limit.is_none() && target_relmse.is_none();
    let stop = Stop { frames: spp.or(endless.then_some(1024)), time: limit, relative_error: target_relmse };
    // Averaged, however many samples it will be.
    let cell = Cell { method: &PATH, ..parameters.cell()? }.effective();
    let settings = settings(&common.view, &cell, u32::MAX)?;
    Job { common, settings, cell, time, stop }.run()
}
