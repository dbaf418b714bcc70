//! `caustics render`.

use std::process::ExitCode;

use super::job::Job;
use super::options::settings;
use super::stop::Stop;
use crate::cli::{Preset, Render};

/// Averages frames of a method.
pub fn run(options: Render) -> anyhow::Result<ExitCode> {
    let Render { common, axes, time, preset, frames } = options;
    let says_how = frames.is_some() || axes.says_how();
    // Frames that nobody asked for by name are as `bench` and `animate` have them, to be averaged.
    let usual = preset.or((!says_how).then_some(Preset::Preview)).map_or(vec![], Preset::values);
    let preset = preset.unwrap_or(if says_how { Preset::Frame } else { Preset::Preview });
    let cell = axes.cell_of(&usual)?;
    let most = frames.unwrap_or(preset.frames());
    let settings = settings(&common.view, &cell, most)?;
    // A number of frames is a number of frames.
    let relative_error = preset.relative_error().filter(|_| frames.is_none());
    let stop = Stop { frames: Some(most), relative_error, ..Stop::default() };
    Job { common, settings, cell, time, stop }.run()
}
