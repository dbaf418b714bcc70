//! The options of the command line.

use std::io::Write;
use std::path::PathBuf;

use caustics::exposure::Exposure;
use caustics::kernels::Source;
use caustics::named::Named;
use caustics::rendered_image::Aov;
use caustics::scene::{BvhCache, BvhOptions, BvhQuality, LoadOptions, Position};
use caustics_bench::renamed;
use caustics_kernels::interface::choice::{PixelFilter, TextureFilter};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, Parser, Subcommand, ValueEnum};
use thiserror::Error;

mod animate;
mod bench;
mod compare;
mod inspect;
mod pages;
mod parameters;
mod preset;
mod report;
mod sharding;
mod survey;
mod sweep;
mod view;

pub use animate::Animate;
pub use bench::{Bench, Quantity};
pub use compare::{Compare, Limit};
pub use inspect::Inspect;
pub use pages::{Completions, Man};
pub use parameters::{Averaged, ParameterOptions, PathTraced, with_image_denoiser};
pub use preset::Preset;
pub use report::ReportOptions;
pub use sharding::Sharding;
pub use survey::Survey;
pub use sweep::SweepOptions;
pub use view::Viewer;

/// Parses a value by its name, and describes all values in the help.
fn named<T: Named>() -> impl TypedValueParser<Value = T> {
    let values = T::all().into_iter().map(|value| PossibleValue::new(value.name()).help(value.description()));
    PossibleValuesParser::new(values).try_map(|name| T::find(&name))
}

/// Invalid command line: exit code 2.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct Usage(pub String);

/// Renders glTF scenes with indirectly visible caustics.
#[derive(Debug, Parser)]
#[command(name = "caustics", version, propagate_version = true)]
#[command(before_help = "Examples:
  caustics render still-life -o image.exr --png image.png
  caustics render mirror-room -o room.exr --runner gpu --gather points-rt --json")]
pub struct Cli {
    /// Subcommand.
    #[command(subcommand)]
    pub command: Command,
}

impl Cli {
    /// Parses the command line of this process. Exits where it is invalid or asks for help; the message on a renamed option
    /// gives its new name.
    pub fn read() -> Cli {
        Cli::try_parse().unwrap_or_else(|mut error| {
            let unknown = error.get(ContextKind::InvalidArg).map(ToString::to_string);
            let tip = unknown.and_then(|option| renamed::hint(renamed::OPTIONS, &option));
            if let Some(tip) = tip.filter(|_| error.kind() == ErrorKind::UnknownArgument) {
                error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
            }
            let printed = error.print().and_then(|()| std::io::stdout().flush());
            match printed {
                // The help could not be written.
                Err(wrong) if !error.use_stderr() && wrong.kind() != std::io::ErrorKind::BrokenPipe => {
                    message!("error: cannot write to stdout: {wrong}");
                    std::process::exit(1)
                }
                _ => std::process::exit(error.exit_code()),
            }
        })
    }
}

/// Refuses an environment variable that was renamed.
pub fn check_variables() -> Result<(), Usage> {
    let is_set = |name: &str| std::env::var_os(name).is_some();
    let old = renamed::VARIABLES.iter().find(|(old, _)| is_set(old));
    match old.and_then(|(old, _)| renamed::hint(renamed::VARIABLES, old)) {
        Some(hint) => Err(Usage(hint)),
        None => Ok(()),
    }
}

/// Subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to EXR
    Render(Box<Render>),
    /// Serve a page on which a browser shows a scene live
    View(Box<Viewer>),
    /// Render the frames of an animation, one file each; the same command resumes an interrupted run
    Animate(Box<Animate>),
    /// Path trace a reference image of a scene
    Reference(Box<Reference>),
    /// Merge the shards of a render or reference, or references of one view that were rendered with different seeds
    Merge(Merge),
    /// Measure the error of an image against a reference
    Compare(Compare),
    /// Measure time and error of run configurations on one scene: a sweep given by options
    Bench(Box<Bench>),
    /// Measure time and error of a matrix of run configurations over scenes; the same command resumes an interrupted run
    Sweep(Box<SweepOptions>),
    /// Print the light transport of a pixel: its camera path, the photons it gathered, and their light paths
    Inspect(Box<Inspect>),
    /// Make a page of results: charts of speed against accuracy, images, tables
    Report(ReportOptions),
    /// List Vulkan devices, their capabilities and whether they are used; or compile all kernels for one
    Device(Device),
    /// List, inspect or make scenes
    #[command(subcommand)]
    Scene(SceneCommand),
    /// Print a completion script for a shell
    Completions(Completions),
    /// Write man pages, one file per command
    Man(Man),
}

/// Options of the runner: tracer, device, kernels, threads.
#[derive(Args, Clone, Debug)]
pub struct Machine {
    /// Tracer of a GPU; auto takes ray queries if the device has them
    #[arg(long, value_enum, default_value = "auto")]
    pub tracer: Tracer,
    /// Vulkan device, by index or part of its name (default: the best)
    #[arg(long)]
    pub device: Option<String>,
    /// Folder of compiled kernels for a GPU, as written by `cargo kernels --out DIR` [default: the environment variable
    /// CAUSTICS_KERNELS, else the kernels of this program]
    #[arg(long, value_name = "DIR")]
    pub kernels: Option<PathBuf>,
    /// Threads of the CPU runner; 0 takes every core
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
    /// validation: enable the Vulkan validation layer; its messages fail the run
    #[arg(long, value_enum)]
    pub debug: Option<Debug>,
}

impl Machine {
    /// Source of a GPU's kernels.
    pub fn source(&self) -> Source {
        self.kernels.clone().map_or_else(Source::from_environment, Source::Folder)
    }
}

/// Options of the image.
#[derive(Args, Clone, Debug)]
pub struct ImageOptions {
    /// Image width (px)
    #[arg(long, default_value_t = 960)]
    pub width: u32,
    /// Image height (px)
    #[arg(long, default_value_t = 540)]
    pub height: u32,
    /// Number of tiles: bands of rows that are rendered in turn, in the memory of one. Each has its own light paths
    /// [default: as few as the device's bindings allow]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub tiles: Option<u32>,
    /// Reflections of at most this roughness are specular
    #[arg(long, default_value_t = 0.25)]
    pub specular_roughness: f32,
    /// Position of rays within a pixel [default: box where frames are averaged, else centre]
    #[arg(long, value_parser = named::<PixelFilter>())]
    pub pixel_filter: Option<PixelFilter>,
    /// Texture level that the camera sees [default: finest for reference, path, progressive, and means of frames over whole
    /// pixels, else cone]
    #[arg(long, value_parser = named::<TextureFilter>())]
    pub texture_filter: Option<TextureFilter>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 0)]
    pub seed: u32,
    /// Name of the camera, or orbit:AZIMUTH,ELEVATION[,DISTANCE]. An orbit is around the point looked at, in degrees from
    /// +z and up, and metres [default: the first, else a view of all]
    #[arg(long, value_name = "NAME|ORBIT")]
    pub camera: Option<String>,
    /// Place a camera here, in the file's coordinates (m)
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub from: Option<Position>,
    /// Place a camera that looks at this point [default: the middle of the scene]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub look_at: Option<Position>,
    /// Place a camera with this vertical field of view (degrees) [default: 40]
    #[arg(long, value_name = "DEGREES")]
    pub fov: Option<f64>,
    /// Stand the scene on a floor, a wide grey square that receives caustics
    #[arg(long)]
    pub floor: bool,
    /// Add a spot light and a soft sky, whatever light the scene has. Without this option, they are added only to scenes
    /// without light, and to glowing objects where neither the file nor --from has a camera
    #[arg(long)]
    pub default_light: bool,
    /// Refuse a scene that has no light
    #[arg(long, conflicts_with = "default_light")]
    pub no_default_light: bool,
    /// Exposure of the PNG (stops, or auto, which fits the image)
    #[arg(long, default_value = "auto")]
    pub exposure: Exposure,
    /// Light from all around: a latitude-longitude image (.hdr or .exr), or one radiance as R,G,B [default: the scene's]
    #[arg(long)]
    pub environment: Option<String>,
    /// Rotation of the environment's image around the y axis, from +z towards +x (degrees)
    #[arg(long, default_value_t = 0.0, requires = "environment")]
    pub environment_rotation: f32,
    /// Factor on the environment's radiance
    #[arg(long, default_value_t = 1.0, requires = "environment")]
    pub environment_scale: f32,
    /// Radiance behind everything, as R,G,B; it is visible but lights nothing [default: the scene's, else 0,0,0]
    #[arg(long)]
    pub background: Option<String>,
}

/// Options for loading the file of a scene.
#[derive(Args, Clone, Debug)]
pub struct Loading {
    /// Treat missing or out-of-range values in the scene's file as errors, not warnings
    #[arg(long)]
    pub strict: bool,
    /// Variant of the scene's materials, by name (KHR_materials_variants)
    #[arg(long)]
    pub variant: Option<String>,
    /// Name of the scene's animation to play [default: all of them together]
    #[arg(long, value_name = "NAME")]
    pub animation: Option<String>,
    /// Maximum number of triangles in copies of meshes; beyond it, a mesh with several instances is stored once
    #[arg(long, default_value_t = LoadOptions::default().copies, value_name = "TRIANGLES")]
    pub copies: u64,
    /// BVH build quality; changes rounding, not the expected image
    #[arg(long, value_enum, default_value_t, value_name = "QUALITY")]
    pub bvh_quality: BvhQuality,
}

impl Loading {
    /// Returns the options as the library's.
    pub fn options(&self) -> LoadOptions {
        LoadOptions {
            strict: self.strict,
            variant: self.variant.clone(),
            animation: self.animation.clone(),
            copies: self.copies,
            bvh: BvhOptions { quality: self.bvh_quality, cache: BvhCache::for_user() },
            ..LoadOptions::default()
        }
    }
}

/// Options of every command that renders an image. Negative numbers parse, so that the check of their option can name it.
#[derive(Args, Debug)]
pub struct Common {
    /// A .gltf or .glb file, a folder with a scene.gltf, or the name of a folder in scenes/
    pub scene: String,
    /// EXR file to write
    #[arg(short, long)]
    pub output: PathBuf,
    /// Also write a tone-mapped PNG
    #[arg(long)]
    pub png: Option<PathBuf>,
    /// Also write these layers, comma-separated; at mirrors and glass they describe what is visible in them
    #[arg(long, value_enum, value_name = "LAYER", value_delimiter = ',')]
    pub aov: Vec<Aov>,
    /// Send the image to the viewer tev while it converges; tev listens on 127.0.0.1:14158 by default
    #[arg(long, value_name = "HOST:PORT")]
    pub tev: Option<String>,
    /// Minimum time between updates of the PNG and of tev while the image converges (s) [default: only tev, every 2]
    #[arg(long, value_name = "SECONDS")]
    pub refresh: Option<f64>,
    /// Runner of the command.
    #[command(flatten)]
    pub machine: Machine,
    /// Image and camera.
    #[command(flatten)]
    pub view: ImageOptions,
    /// Loading of the scene.
    #[command(flatten)]
    pub loading: Loading,
    /// Apply the edits in this TOML file: transforms of nodes, the camera, and keyframes
    #[arg(long, value_name = "FILE")]
    pub edits: Option<PathBuf>,
    /// Part of the frames to render.
    #[command(flatten)]
    pub sharding: Sharding,
    /// Resume from OUTPUT.checkpoint, which an interrupted run leaves behind
    #[arg(long)]
    pub resume: bool,
    /// Time between checkpoints (s)
    #[arg(long, default_value_t = 60.0)]
    pub checkpoint_every: f64,
    /// Print times, counters and settings to stdout as JSON
    #[arg(long)]
    pub json: bool,
    /// Leave the energy ledger out of the JSON; the ledger makes `shoot` slower
    #[arg(long)]
    pub no_ledger: bool,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
}

/// Options of `render`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
#[command(before_help = "Examples:
  caustics render still-life -o image.exr --png image.png
  caustics render path/to/scene.glb -o out.exr --preset final --width 1920 --height 1080
  caustics render mirror-room -o reference.exr --method progressive --frames 1000 --pixel-filter box --indirect-share none --indirect-end path")]
#[command(mut_arg("denoiser", with_image_denoiser))]
pub struct Render {
    /// Options of every command that renders an image.
    #[command(flatten)]
    pub common: Common,
    /// Time of the scene's animations to show (s); they stand still before their first key and after their last
    #[arg(long, default_value_t = 0.0)]
    pub time: f64,
    /// Options of the parameters.
    #[command(flatten)]
    pub parameters: ParameterOptions<Averaged>,
    /// Values for options that are not given [default: preview where no option says how to render, else frame]
    #[arg(long, value_enum)]
    pub preset: Option<Preset>,
    /// Number of frames to average [default: the preset's]
    #[arg(long)]
    pub frames: Option<u32>,
}

/// Options of `reference`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
#[command(before_help = "Examples:
  caustics reference mirror-room -o reference.exr --spp 4096
  caustics reference mirror-room -o reference.exr --target-relmse 1e-4 --resume
  caustics reference mirror-room -o reference.exr --spp 4096 --shard 3/8")]
pub struct Reference {
    /// Options of every command that renders an image.
    #[command(flatten)]
    pub common: Common,
    /// Options of the parameters.
    #[command(flatten)]
    pub parameters: ParameterOptions<PathTraced>,
    /// Time of the scene's animations to show (s); they stand still before their first key and after their last
    #[arg(long, default_value_t = 0.0)]
    pub time: f64,
    /// Stop at this many samples a pixel [default: 1024, if no other option stops the run]
    #[arg(long)]
    pub spp: Option<u32>,
    /// Stop after this time, earlier parts of a resumed run included (s)
    #[arg(long)]
    pub seconds: Option<f64>,
    /// Stop when the estimated relative mean square error falls below this
    #[arg(long)]
    pub target_relmse: Option<f64>,
}

/// Options of `merge`.
#[derive(Args, Debug)]
#[command(before_help = "Examples:
  caustics merge reference.shard-*.sums -o reference.exr
  caustics merge seed-1.exr seed-2.exr seed-3.exr -o reference.exr")]
pub struct Merge {
    /// Shards of one run of render or reference, or references of one view with different seeds
    #[arg(required = true, num_args = 2..)]
    pub inputs: Vec<PathBuf>,
    /// EXR file to write
    #[arg(short, long)]
    pub output: PathBuf,
    /// Overwrite an existing file
    #[arg(long)]
    pub force: bool,
}

/// Tracers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Tracer {
    /// Ray queries if the device has them, else software
    Auto,
    /// Vulkan ray queries
    Hardware,
    /// The project's own BVH
    Software,
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
    /// Compile every entry point for a device, each in its own process, and print the driver's figures
    #[arg(long)]
    pub compile: bool,
    /// Device to compile for, by index or part of its name (default: the best)
    #[arg(long, requires = "compile")]
    pub device: Option<String>,
    /// Features to compile in: all, none, or those that a scene needs; comma-separated
    #[arg(long, requires = "compile", value_delimiter = ',', default_value = "all")]
    pub features: Vec<String>,
    /// Only these entry points, comma-separated (default: every one)
    #[arg(long, requires = "compile", value_delimiter = ',')]
    pub pass: Vec<String>,
    /// Compile one entry point here: MODULE/ENTRY/BITS
    #[arg(long, requires = "compile", hide = true)]
    pub one: Option<String>,
}

/// Commands on scenes.
#[derive(Debug, Subcommand)]
pub enum SceneCommand {
    /// List the scenes that can be rendered or made by name
    List,
    /// Print the contents of a scene and the kernel features that it needs
    Info {
        /// A file, a folder, or a name
        scene: String,
        /// Reflections of at most this roughness are specular
        #[arg(long, default_value_t = 0.25)]
        specular_roughness: f32,
        /// Loading of the scene.
        #[command(flatten)]
        loading: Loading,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Load every .gltf and .glb file below a folder, each in its own process, and report which cannot be rendered, and why
    Survey(Survey),
    /// Generate a scene's files
    Make {
        /// Name from `scene list`, or `all` for the committed scenes
        name: String,
        /// Parent of the folder to write [default: scenes, or scenes/generated for scenes made on demand]
        #[arg(short, long)]
        output: Option<PathBuf>,
        /// Overwrite existing files
        #[arg(long)]
        force: bool,
    },
}
