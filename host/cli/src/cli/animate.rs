//! Options of `animate`.

use std::ops::Range;

use clap::Args;

use super::Common;
use super::bench::frames;
use super::parameters::{OneConfiguration, ParameterOptions};

/// Options of `animate`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
#[command(before_help = "Examples:
  caustics animate animated-light -o frames/####.exr --video
  caustics animate moving-caster -o frames/caster-####.exr --history none --frames 0..24 --fps 24
  caustics animate moving-caster -o frames/####.exr --history none --emission aimed --light-paths 100000 --shard 3/8")]
#[command(mut_arg("history", |arg| arg.help("Light of the previous frame that collection points reuse [default: validated with --method basic, else none]")))]
#[command(mut_arg("denoiser", |arg| arg.help("What smooths the path-traced part, caustics excepted [default: atrous with a --path-history, else none]")))]
#[command(mut_arg("sampler", |arg| arg.help("Where the random numbers of camera paths come from [default: sobol with a --path-history, else blue]")))]
#[command(mut_arg("path_history", |arg| arg.help("Path-traced light of the previous frame that collection points reuse [default: validated with a --history, else none]")))]
#[command(mut_arg("output", |arg| arg.help("The EXR files to write; a run of # is the frame's number: frames/####.exr")))]
#[command(mut_arg("exposure", |arg| arg.help("Exposure of the PNGs (stops, or auto for what suits the first frame)")))]
#[command(mut_arg("checkpoint_every", |arg| arg.help("Time between writes of what a history keeps (s)")))]
#[command(mut_arg("force", |arg| arg.help("Remove the frames that are there, also the PNGs, and render all anew")))]
#[command(mut_arg("png", |arg| arg.long("png-file").hide(true)), mut_arg("resume", |arg| arg.hide(true)))]
#[command(mut_arg("no_ledger", |arg| arg.hide(true)))]
#[command(mut_arg("tev", |arg| arg.hide(true)), mut_arg("refresh", |arg| arg.hide(true)))]
pub struct Animate {
    /// Options of every command that renders an image.
    #[command(flatten)]
    pub common: Common,
    /// Options of the parameters.
    #[command(flatten)]
    pub parameters: ParameterOptions<OneConfiguration>,
    /// Frames from A up to, but not including, B (default: all of the scene's animations and of the keys of --edits)
    #[arg(long, value_name = "A..B", value_parser = frames)]
    pub frames: Option<Range<u32>>,
    /// Frames a second: frame k shows the time k / fps
    #[arg(long, default_value_t = 24.0)]
    pub fps: f64,
    /// Also write a tone-mapped PNG beside each EXR file
    #[arg(long = "png")]
    pub pngs: bool,
    /// Also write the PNGs, and a video of them, with the program ffmpeg
    #[arg(long)]
    pub video: bool,
}
