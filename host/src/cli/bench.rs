//! Options of `bench`.

use std::ops::Range;
use std::path::PathBuf;

use caustics::experiment::matrix::RUNNERS;
use clap::Args;
use clap::builder::PossibleValuesParser;

use super::values::{denoisers, gathers, histories, methods};
use super::{Common, Debug, NeedsName, PixelFilter, RunnerName, TextureFilter, Tracer};

/// Options of `bench`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
#[command(before_help = "Examples:
  caustics bench mirror-room --gather photons-grid,brute --light-paths 65536 --width 480 --height 270
  caustics bench animated-light --animation --time --frames 0..12 --width 1920 --height 1080 --warm-up 2 -o time
  caustics bench animated-light --animation --error --frames 0..48 --width 240 --height 135 --paths-per-pixel 0.506 -o error")]
pub struct Bench {
    /// A .gltf or .glb file, a folder with a scene.gltf, or the name of a folder in scenes/
    pub scene: String,
    /// The folder to write: cells/*.json, frames.csv and passes.csv; with --animation frames.csv, summary.json and figures
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Measure the frames of an animation (a scene where nothing moves is one too)
    #[arg(long, requires = "output")]
    pub animation: bool,
    /// Record the time of every pass; without --animation it always is
    #[arg(long, requires = "animation")]
    pub time: bool,
    /// Record FLIP, relative errors, flicker and gain against references, which are kept in CAUSTICS_CACHE
    #[arg(long, requires = "animation")]
    pub error: bool,
    /// Methods to hold against each other, with commas between
    #[arg(long, default_value = "basic", value_delimiter = ',', value_parser = methods())]
    pub method: Vec<String>,
    /// Gathers to hold against each other, with commas between [default: points-rt with ray queries, else photons-grid]
    #[arg(long, value_delimiter = ',', value_parser = gathers())]
    pub gather: Vec<String>,
    /// Histories to hold against each other, with commas between (default: none; with --animation all)
    #[arg(long, value_delimiter = ',', value_parser = histories())]
    pub history: Vec<String>,
    /// Filters to hold against each other, with commas between
    #[arg(long, default_value = "none", value_delimiter = ',', value_parser = denoisers())]
    pub denoiser: Vec<String>,
    /// Light paths a frame, with commas between [default: 1048576]
    #[arg(long, value_delimiter = ',', conflicts_with = "paths_per_pixel")]
    pub light_paths: Vec<u32>,
    /// Light paths a pixel and frame instead, with commas between
    #[arg(long, value_delimiter = ',')]
    pub paths_per_pixel: Vec<f64>,
    /// Radii of collection points, with commas between; 1 gives a disc the area of its pixel's footprint
    #[arg(long, default_value = "1", value_delimiter = ',')]
    pub radius_px: Vec<f32>,
    /// Scattering vertices between eye and light, at most; with commas between
    #[arg(long, default_value = "5", value_delimiter = ',')]
    pub max_bounces: Vec<u32>,
    /// Where to run, with commas between; auto takes a real GPU if there is one, else the CPU
    #[arg(long, default_value = "auto", value_delimiter = ',', value_parser = PossibleValuesParser::new(RUNNERS))]
    pub runner: Vec<String>,
    /// Which kernel code is alive: what the scene needs, or all of it; with commas between
    #[arg(long, value_enum, default_value = "scene", value_delimiter = ',')]
    pub features: Vec<NeedsName>,
    /// The frames: how many, or A..B with B left out (default: 16; with --animation 0..48)
    #[arg(long, value_name = "N|A..B", value_parser = count_or_frames)]
    pub frames: Option<Range<u32>>,
    /// Frames rendered before the first one, at its pose, and not recorded (default: 2; with --animation 0)
    #[arg(long)]
    pub warm_up: Option<u32>,
    /// Frames a second of an animation: frame k shows the time k / fps
    #[arg(long, default_value_t = 24.0)]
    pub fps: f64,
    /// Time of the scene's animations that all frames show, without --animation (s)
    #[arg(long, default_value_t = 0.0, conflicts_with = "animation")]
    pub time_s: f64,
    /// Independent runs of each cell for --error
    #[arg(long, default_value_t = 4)]
    pub seeds: u32,
    /// Frames of each reference
    #[arg(long, default_value_t = 256)]
    pub reference_frames: u32,
    /// What traces rays with --runner gpu or auto; auto takes ray queries if the device has them
    #[arg(long, value_enum, default_value = "auto")]
    pub tracer: Tracer,
    /// Vulkan device, by index or part of its name (default: the best)
    #[arg(long)]
    pub device: Option<String>,
    /// Threads of the CPU runner; 0 takes every core
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
    /// Image width (px)
    #[arg(long, default_value_t = 960)]
    pub width: u32,
    /// Image height (px)
    #[arg(long, default_value_t = 540)]
    pub height: u32,
    /// Reflections of at most this roughness are specular
    #[arg(long, default_value_t = 0.25)]
    pub specular_roughness: f32,
    /// Where in a pixel its rays go
    #[arg(long, value_enum, default_value = "centre")]
    pub pixel_filter: PixelFilter,
    /// Which level of its textures the camera sees, in all cells and the references alike
    #[arg(long, value_enum, default_value = "cone")]
    pub texture_filter: TextureFilter,
    /// First seed of all random numbers
    #[arg(long, default_value_t = 0)]
    pub seed: u32,
    /// Name of the camera (default: the first)
    #[arg(long)]
    pub camera: Option<String>,
    /// Exposure of the display that FLIP looks at (stops)
    #[arg(long, default_value_t = 0.0)]
    pub exposure: f32,
    /// Radiance behind everything, as R,G,B; it is seen and lights nothing [default: what the scene says, else 0,0,0]
    #[arg(long)]
    pub background: Option<String>,
    /// validation: the Vulkan validation layer watches, and its messages fail the run
    #[arg(long, value_enum)]
    pub debug: Option<Debug>,
    /// Print the measures to stdout as JSON instead of a table
    #[arg(long)]
    pub json: bool,
    /// Measure everything anew, and overwrite what the folder holds
    #[arg(long)]
    pub force: bool,
}

/// Runner and tracer of a name of [`RUNNERS`]; a name that says no tracer leaves the one that is asked for.
pub fn runner_and_tracer(name: &str, tracer: Tracer) -> (RunnerName, Tracer) {
    match name {
        "cpu" => (RunnerName::Cpu, Tracer::Software),
        "gpu" => (RunnerName::Gpu, tracer),
        "gpu-hardware" => (RunnerName::Gpu, Tracer::Hardware),
        "gpu-software" => (RunnerName::Gpu, Tracer::Software),
        _ => (RunnerName::Auto, tracer),
    }
}

impl Bench {
    /// The options as other commands know them, with one of its runners and bounces.
    pub fn common(&self, runner: &str, max_bounces: u32) -> Common {
        // A device belongs to the runners that have one.
        let device = self.device.clone().filter(|_| runner != "cpu" || self.runner.len() == 1);
        let (runner, tracer) = runner_and_tracer(runner, self.tracer);
        Common {
            scene: self.scene.clone(),
            output: self.output.clone().unwrap_or_default(),
            device,
            threads: self.threads,
            width: self.width,
            height: self.height,
            max_bounces,
            specular_roughness: self.specular_roughness,
            pixel_filter: Some(self.pixel_filter),
            texture_filter: Some(self.texture_filter),
            seed: self.seed,
            camera: self.camera.clone(),
            exposure: self.exposure,
            background: self.background.clone(),
            debug: self.debug,
            json: self.json,
            force: self.force,
            ..Common::of(runner, tracer)
        }
    }
}

impl Common {
    /// A runner and a tracer, with what all other options are where they are not given.
    pub fn of(runner: RunnerName, tracer: Tracer) -> Common {
        Common {
            scene: String::new(),
            output: PathBuf::new(),
            png: None,
            runner,
            tracer,
            device: None,
            threads: 0,
            width: 960,
            height: 540,
            max_bounces: 5,
            specular_roughness: 0.25,
            pixel_filter: Some(PixelFilter::Centre),
            texture_filter: None,
            seed: 0,
            camera: None,
            exposure: 0.0,
            background: None,
            features: NeedsName::Scene,
            debug: None,
            resume: false,
            checkpoint_every: 60.0,
            json: false,
            no_ledger: false,
            force: false,
        }
    }
}

/// Two whole numbers, the first below the second.
pub fn frames(text: &str) -> Result<Range<u32>, String> {
    let wrong = || "it must be A..B, two whole numbers, A below B".to_string();
    let (first, end) = text.split_once("..").ok_or_else(wrong)?;
    let range = first.parse().map_err(|_| wrong())?..end.parse().map_err(|_| wrong())?;
    if range.is_empty() { Err(wrong()) } else { Ok(range) }
}

/// The same, or a number of frames from 0 on.
fn count_or_frames(text: &str) -> Result<Range<u32>, String> {
    match text.parse::<u32>() {
        Ok(0) => Err("give at least 1".into()),
        Ok(count) => Ok(0..count),
        Err(_) => frames(text).map_err(|wrong| format!("{wrong}, or a number of frames")),
    }
}
