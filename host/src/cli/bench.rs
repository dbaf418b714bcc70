//! Options of `bench`.

use std::ops::Range;

use caustics::method::{self, filter, history};
use clap::Args;
use clap::builder::PossibleValuesParser;

use super::{Common, gather_names};

/// Options of `bench`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
#[command(before_help = "Examples:
  caustics bench animated-light --animation --time --frames 0..12 --width 1920 --height 1080 --warm-up 2 -o time
  caustics bench animated-light --animation --error --frames 0..48 --width 240 --height 135 --paths-per-pixel 0.506 -o error")]
#[command(mut_arg("output", |arg| arg.help("The folder to write: frames.csv, summary.json and figures")))]
#[command(mut_arg("json", |arg| arg.help("Print the summary to stdout as JSON instead of a table")))]
#[command(mut_arg("exposure", |arg| arg.help("Exposure of the display that FLIP looks at [stops]")))]
#[command(mut_arg("force", |arg| arg.help("Measure everything anew, and overwrite what the folder holds")))]
#[command(mut_arg("seed", |arg| arg.help("First seed of all random numbers")))]
#[command(mut_arg("png", |arg| arg.hide(true)), mut_arg("resume", |arg| arg.hide(true)))]
#[command(mut_arg("checkpoint_every", |arg| arg.hide(true)), mut_arg("no_ledger", |arg| arg.hide(true)))]
pub struct Bench {
    /// What every command that renders has.
    #[command(flatten)]
    pub common: Common,
    /// Measure the frames of an animation (a scene where nothing moves is one too)
    #[arg(long, required = true)]
    pub animation: bool,
    /// Record the time of every pass
    #[arg(long)]
    pub time: bool,
    /// Record FLIP, relative errors, flicker and gain against references, which are kept in CAUSTICS_CACHE
    #[arg(long)]
    pub error: bool,
    /// Methods to hold against each other, with commas between
    #[arg(long, default_value = "basic", value_delimiter = ',', value_parser = PossibleValuesParser::new(method_names()))]
    pub method: Vec<String>,
    /// Histories to hold against each other, with commas between [default: all]
    #[arg(long, value_delimiter = ',', value_parser = PossibleValuesParser::new(history_names()))]
    pub history: Vec<String>,
    /// Filters to hold against each other, with commas between
    #[arg(long, default_value = "none", value_delimiter = ',', value_parser = PossibleValuesParser::new(filter_names()))]
    pub filter: Vec<String>,
    /// How deposits and collection points meet [default: points-rt with ray queries, else photons-grid]
    #[arg(long, value_parser = PossibleValuesParser::new(gather_names()))]
    pub gather: Option<String>,
    /// The frames, the last one left out
    #[arg(long, value_name = "A..B", default_value = "0..48", value_parser = frames)]
    pub frames: Range<u32>,
    /// Frames a second: frame k shows the time k / fps
    #[arg(long, default_value_t = 24.0)]
    pub fps: f64,
    /// Light paths a frame [default: 1048576]
    #[arg(long, conflicts_with = "paths_per_pixel")]
    pub light_paths: Option<u32>,
    /// Light paths a pixel and frame, instead
    #[arg(long)]
    pub paths_per_pixel: Option<f64>,
    /// Radius of collection points; 1 gives a disc the area of its pixel's footprint
    #[arg(long, default_value_t = 1.0)]
    pub radius_px: f32,
    /// Frames rendered before the first one, at its pose, and not recorded
    #[arg(long, default_value_t = 0)]
    pub warm_up: u32,
    /// Independent runs of each cell for --error
    #[arg(long, default_value_t = 4)]
    pub seeds: u32,
    /// Frames of each reference
    #[arg(long, default_value_t = 256)]
    pub reference_frames: u32,
}

fn method_names() -> Vec<&'static str> {
    // What only traces paths has nothing that a history could lend.
    method::ALL.iter().filter(|method| method.gathers).map(|method| method.name).collect()
}

/// Names of the histories.
pub fn history_names() -> Vec<&'static str> {
    history::ALL.iter().map(|history| history.name).collect()
}

fn filter_names() -> Vec<&'static str> {
    filter::ALL.iter().map(|filter| filter.name).collect()
}

/// Two whole numbers, the first below the second.
pub fn frames(text: &str) -> Result<Range<u32>, String> {
    let wrong = || "it must be A..B, two whole numbers, A below B".to_string();
    let (first, end) = text.split_once("..").ok_or_else(wrong)?;
    let range = first.parse().map_err(|_| wrong())?..end.parse().map_err(|_| wrong())?;
    if range.is_empty() { Err(wrong()) } else { Ok(range) }
}
