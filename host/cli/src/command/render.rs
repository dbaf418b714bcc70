//! `caustics render` and `caustics reference`.

use std::process::ExitCode;

use caustics_bench::run_config::RunConfig;
use caustics_kernels::method::path::PATH;

use super::job::Job;
use super::options::{config, duration};
use super::stop::Stop;
use crate::cli::{Averaged, ParameterOptions, Preset, Reference, Render, Usage};

/// Returns the configuration and the preset for options that are not given. `has_frames`: whether a number of frames is
/// given.
pub fn configuration(
    parameters: &ParameterOptions<Averaged>,
    preset: Option<Preset>,
    has_frames: bool,
) -> Result<(RunConfig, Preset), Usage> {
    let has_render_options = has_frames || parameters.has_render_options();
    // Use a preset's values if it is named, or if no option says how to render. Other frames have the settings of `bench`
    // and `animate`.
    let defaults = preset.or((!has_render_options).then_some(Preset::Preview)).map_or(vec![], Preset::values);
    let preset = preset.unwrap_or(if has_render_options { Preset::Frame } else { Preset::Preview });
    Ok((parameters.checked(parameters.unchecked(&defaults)?)?, preset))
}

/// Averages frames of a method.
pub fn run(options: Render) -> anyhow::Result<ExitCode> {
    let Render { common, parameters, time, preset, frames } = options;
    let (run_config, preset) = configuration(&parameters, preset, frames.is_some())?;
    let max_frames = frames.unwrap_or(preset.frames());
    let config = config(&common.view, &run_config.config, max_frames)?;
    // A given number of frames overrides the preset's error.
    let relative_error = preset.relative_error().filter(|_| frames.is_none());
    let stop = Stop { frames: Some(max_frames), relative_error, ..Stop::default() };
    Job { common, config, runner: run_config.asked_runner, time, stop }.run()
}

/// Path traces until a stop of the reference is reached.
pub fn run_reference(options: Reference) -> anyhow::Result<ExitCode> {
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
    // Take the settings of a mean, whatever the number of samples.
    let run_config = parameters.run_config()?.with(|config| config.method = &PATH).effective();
    let config = config(&common.view, &run_config.config, u32::MAX)?;
    Job { common, config, runner: run_config.asked_runner, time, stop }.run()
}
