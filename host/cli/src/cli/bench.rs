//! Options of `bench`.

use std::ops::Range;
use std::path::PathBuf;

use caustics_kernels::interface::choice::PixelFilter;
use clap::{Args, ValueEnum};

use super::parameters::{ManyConfigurations, ParameterOptions};
use super::{ImageOptions, Loading, Machine, named};

/// Options of `bench`, which runs a sweep of one scene.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
#[command(before_help = "Examples:
  caustics bench mirror-room --gather photons-grid,brute --light-paths 65536 --width 480 --height 270
  caustics bench animated-light --history none,validated --frames 0..12 --width 1920 --height 1080 -o time
  caustics bench animated-light --history none,paper,validated --measure error --frames 0..48 --width 240 --height 135 -o error")]
#[command(mut_arg("exposure", |arg| arg.default_value("0").help("Exposure of the display that FLIP looks at, and of PNGs (stops)")))]
#[command(mut_arg("pixel_filter", |arg| arg.help("Where in a pixel its rays go [default: centre]")))]
#[command(mut_arg("texture_filter", |arg| arg.help("Which level of its textures the camera sees, in all run configurations and the references alike [default: cone]")))]
#[command(mut_arg("seed", |arg| arg.help("First seed of all random numbers")))]
pub struct Bench {
    /// A .gltf or .glb file, a folder with a scene.gltf, or the name of a folder in scenes/
    pub scene: String,
    /// Folder to write: cells/*.json, cells.csv, passes.csv, frames.csv; results already in it are not measured again
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Quantities to measure: time, or error against references (kept in CAUSTICS_CACHE); both with a comma
    #[arg(long, value_enum, default_value = "time", value_delimiter = ',')]
    pub measure: Vec<Quantity>,
    /// Options of the parameters.
    #[command(flatten)]
    pub parameters: ParameterOptions<ManyConfigurations>,
    /// Frames: a number, or A..B without B. All frames of a still image are timed, and the last is compared
    #[arg(long, value_name = "N|A..B", default_value = "16", value_parser = count_or_frames)]
    pub frames: Range<u32>,
    /// Frames rendered before the timed ones, at the pose of the first
    #[arg(long, default_value_t = 2)]
    pub warm_up: u32,
    /// Frames a second of an animation: frame k shows the time k / fps
    #[arg(long, default_value_t = 24.0)]
    pub fps: f64,
    /// Time of the scene's animations that all frames show (s) (default: each frame's own)
    #[arg(long, value_name = "SECONDS")]
    pub moment: Option<f64>,
    /// Independent seeds of each run configuration that is compared with references
    #[arg(long, default_value_t = 4)]
    pub seeds: u32,
    /// Compare every frame of still scenes too, not only the last
    #[arg(long)]
    pub every_frame: bool,
    /// Frames of each reference
    #[arg(long, default_value_t = 256)]
    pub reference_frames: u32,
    /// Position of the references' rays within a pixel; box also takes the finest texture level [default: that of the images]
    #[arg(long, value_parser = named::<PixelFilter>())]
    pub reference_pixel_filter: Option<PixelFilter>,
    /// Runner of the command.
    #[command(flatten)]
    pub machine: Machine,
    /// Image and camera.
    #[command(flatten)]
    pub view: ImageOptions,
    /// Loading of the scene.
    #[command(flatten)]
    pub loading: Loading,
    /// Print the results to stdout as JSON instead of a table
    #[arg(long)]
    pub json: bool,
    /// Measure everything again, and overwrite what the folder holds
    #[arg(long)]
    pub force: bool,
}

/// Quantities to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Quantity {
    /// Time of frames and of their passes
    Time,
    /// Error of frames against references: FLIP, relative errors, flicker, variance
    Error,
}

/// Parses A..B, two whole numbers, the first below the second.
pub fn frames(text: &str) -> Result<Range<u32>, String> {
    let wrong = || "it must be A..B, two whole numbers, A below B".to_string();
    let (first, end) = text.split_once("..").ok_or_else(wrong)?;
    let range = first.parse().map_err(|_| wrong())?..end.parse().map_err(|_| wrong())?;
    if range.is_empty() { Err(wrong()) } else { Ok(range) }
}

/// Parses A..B, or a number of frames from 0 on.
fn count_or_frames(text: &str) -> Result<Range<u32>, String> {
    match text.parse::<u32>() {
        Ok(0) => Err("give at least 1".into()),
        Ok(count) => Ok(0..count),
        Err(_) => frames(text).map_err(|wrong| format!("{wrong}, or a number of frames")),
    }
}
