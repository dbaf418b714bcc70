//! `caustics render`.

use std::process::ExitCode;

use caustics_bench::cell::Cell;

use super::job::Job;
use super::options::settings;
use super::stop::Stop;
use crate::cli::{Averaged, ParameterOptions, Preset, Render, Usage};

/// How to render, and the preset that says what no option does; `has_frames`: whether a number of frames is given.
pub fn configuration(
    parameters: &ParameterOptions<Averaged>,
    preset: Option<Preset>,
    has_frames: bool,
) -> Result<(Cell, Preset), Usage> {
    let has_render_options = has_frames || parameters.has_render_options();
    // Frames that nobody asked for by name are as `bench` and `animate` have them, to be averaged.
    let defaults = preset.or((!has_render_options).then_some(Preset::Preview)).map_or(vec![], Preset::values);
    let preset = preset.unwrap_or(if has_render_options { Preset::Frame } else { Preset::Preview });
    Ok((parameters.cell_of(&defaults)?, preset))
}

/// Averages frames of a method.
pub fn run(options: Render) -> anyhow::Result<ExitCode> {
    let Render { common, parameters, time, preset, frames } = options;
    let (cell, preset) = configuration(&parameters, preset, frames.is_some())?;
    let max_frames = frames.unwrap_or(preset.frames());
    let settings = settings(&common.view, &cell, max_frames)?;
    // A number of frames is a number of frames.
    let relative_error = preset.relative_error().filter(|_| frames.is_none());
    let stop = Stop { frames: Some(max_frames), relative_error, ..Stop::default() };
    Job { common, settings, cell, time, stop }.run()
}
