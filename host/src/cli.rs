//! The options of the command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use thiserror::Error;

/// The command line asks for something that cannot be: exit code 2.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct Usage(pub String);

/// Renders glTF scenes with indirectly visible caustics.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true)]
#[command(before_help = "Examples:
  caustics render mirror-room -o room.exr --png room.png
  caustics render mirror-room -o room.exr --runner gpu --gather points-rt --json")]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to EXR
    Render(Box<Render>),
    /// List Vulkan devices, what they can do and whether they are used
    Device(Device),
    /// List, inspect or make scenes
    #[command(subcommand)]
    Scene(Scene),
}

/// Options of `render`. A negative number reaches the check of its option, which names it.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
#[command(before_help = "Examples:
  caustics render mirror-room -o room.exr --png room.png
  caustics render path/to/scene.glb -o out.exr --frames 64 --width 1920 --height 1080")]
pub struct Render {
    /// A .gltf or .glb file, a folder with a scene.gltf, or the name of a folder in scenes/
    pub scene: String,
    /// The EXR file to write
    #[arg(short, long)]
    pub output: PathBuf,
    /// Also write a tone-mapped PNG
    #[arg(long)]
    pub png: Option<PathBuf>,
    /// How to render
    #[arg(long, value_enum, default_value = "basic")]
    pub method: Method,
    /// How deposits and collection points meet [default: points-rt with ray queries, else photons-grid]
    #[arg(long, value_parser = clap::builder::PossibleValuesParser::new(gather_names()))]
    pub gather: Option<String>,
    /// Where to run; auto takes a real GPU if there is one, else the CPU
    #[arg(long, value_enum, default_value = "auto")]
    pub runner: RunnerName,
    /// What traces rays; auto takes ray queries if the device has them
    #[arg(long, value_enum, default_value = "auto")]
    pub tracer: Tracer,
    /// Vulkan device, by index or part of its name [default: the best]
    #[arg(long)]
    pub device: Option<String>,
    /// Threads of the CPU runner; 0 takes every core
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
    /// Image width [px]
    #[arg(long, default_value_t = 960)]
    pub width: u32,
    /// Image height [px]
    #[arg(long, default_value_t = 540)]
    pub height: u32,
    /// Light paths a frame
    #[arg(long, default_value_t = 1_048_576)]
    pub light_paths: u32,
    /// Independent frames to average
    #[arg(long, default_value_t = 1)]
    pub frames: u32,
    /// Scattering vertices between eye and light, at most
    #[arg(long, default_value_t = 5)]
    pub max_bounces: u32,
    /// Radius of collection points; 1 gives a disc the area of its pixel's footprint
    #[arg(long, default_value_t = 1.0)]
    pub radius_px: f32,
    /// Reflections of at most this roughness are specular
    #[arg(long, default_value_t = 0.25)]
    pub specular_roughness: f32,
    /// Where in a pixel its rays go
    #[arg(long, value_enum, default_value = "centre")]
    pub pixel_filter: PixelFilter,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 0)]
    pub seed: u32,
    /// Name of the camera [default: the first]
    #[arg(long)]
    pub camera: Option<String>,
    /// Exposure of the PNG [stops]
    #[arg(long, default_value_t = 0.0)]
    pub exposure: f32,
    /// Radiance behind everything, as R,G,B; it is seen and lights nothing [default: what the scene says, else 0,0,0]
    #[arg(long)]
    pub background: Option<String>,
    /// Which kernel code is alive: what the scene needs, or all of it
    #[arg(long, value_enum, default_value = "scene")]
    pub needs: NeedsName,
    /// validation: the Vulkan validation layer watches, and its messages fail the run
    #[arg(long, value_enum)]
    pub debug: Option<Debug>,
    /// Print times, counters and settings to stdout as JSON
    #[arg(long)]
    pub json: bool,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
}

fn gather_names() -> Vec<&'static str> {
    caustics_kernels::gather::variant::ALL.iter().map(|variant| variant.name).collect()
}

/// Methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// OurBasic: no light outlives its frame
    Basic,
}

/// Runners.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RunnerName {
    /// A real GPU if there is one, else the CPU
    Auto,
    /// Any Vulkan device, software ones too
    Gpu,
    /// The kernels as CPU code
    Cpu,
}

/// Tracers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Tracer {
    /// Ray queries if the device has them, else software
    Auto,
    /// Vulkan ray queries
    Hardware,
    /// The project's own tree
    Software,
}

/// Pixel filters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PixelFilter {
    /// Rays through pixel centres
    Centre,
    /// Rays uniform over the pixel
    Box,
}

/// Which code is alive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NeedsName {
    /// What the scene needs
    Scene,
    /// Everything
    All,
}

/// Debugging aids.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Debug {
    /// The Vulkan validation layer
    Validation,
}

/// Options of `device`.
#[derive(Args, Debug)]
pub struct Device {
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Commands on scenes.
#[derive(Debug, Subcommand)]
pub enum Scene {
    /// List the scenes that can be rendered or made by name
    List,
    /// Print what a scene holds and what it needs of the kernels
    Info {
        /// A file, a folder, or a name
        scene: String,
        /// Reflections of at most this roughness are specular
        #[arg(long, default_value_t = 0.25)]
        specular_roughness: f32,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Generate a scene's files
    Make {
        /// A name of `scene list`, or `all`
        name: String,
        /// Folder that gets a folder of that name
        #[arg(short, long, default_value = "scenes")]
        output: PathBuf,
        /// Overwrite existing files
        #[arg(long)]
        force: bool,
    },
}
