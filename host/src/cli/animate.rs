//! Options of `animate`.

use std::ops::Range;

use clap::Args;

use super::Common;
use super::bench::frames;
use super::values::{denoisers, gathers, histories, methods};

/// Options of `animate`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
#[command(before_help = "Examples:
  caustics animate animated-light -o frames/####.exr --video
  caustics animate moving-caster -o frames/caster-####.exr --history none --frames 0..24 --fps 24")]
#[command(mut_arg("output", |arg| arg.help("The EXR files to write; a run of # is the frame's number: frames/####.exr")))]
#[command(mut_arg("exposure", |arg| arg.help("Exposure of the PNGs [stops]")))]
#[command(mut_arg("checkpoint_every", |arg| arg.help("Time between writes of what a history keeps [s]")))]
#[command(mut_arg("force", |arg| arg.help("Remove the frames that are there and render all anew")))]
#[command(mut_arg("png", |arg| arg.long("png-file").hide(true)), mut_arg("resume", |arg| arg.hide(true)))]
#[command(mut_arg("no_ledger", |arg| arg.hide(true)))]
pub struct Animate {
    /// What every command that renders has.
    #[command(flatten)]
    pub common: Common,
    /// How to render
    #[arg(long, default_value = "basic", value_parser = methods())]
    pub method: String,
    /// What the frame before lends to collection points [default: validated with --method basic, else none]
    #[arg(long, value_parser = histories())]
    pub history: Option<String>,
    /// What smooths the path-traced part, caustics excepted
    #[arg(long, default_value = "none", value_parser = denoisers())]
    pub denoiser: String,
    /// How deposits and collection points meet [default: points-rt with ray queries, else photons-grid]
    #[arg(long, value_parser = gathers())]
    pub gather: Option<String>,
    /// The frames, the last one left out (default: all of the scene's animations)
    #[arg(long, value_name = "A..B", value_parser = frames)]
    pub frames: Option<Range<u32>>,
    /// Frames a second: frame k shows the time k / fps
    #[arg(long, default_value_t = 24.0)]
    pub fps: f64,
    /// Light paths a frame
    #[arg(long, default_value_t = 1_048_576)]
    pub light_paths: u32,
    /// Radius of collection points; 1 gives a disc the area of its pixel's footprint
    #[arg(long, default_value_t = 1.0)]
    pub radius_px: f32,
    /// Also write a tone-mapped PNG beside each EXR file
    #[arg(long = "png")]
    pub pngs: bool,
    /// Also write the PNGs, and a video of them, by the program ffmpeg
    #[arg(long)]
    pub video: bool,
}
