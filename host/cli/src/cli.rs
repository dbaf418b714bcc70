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
pub use parameters::{Averaged, ParameterOptions, PathTraced};
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

/// The command line asks for something that cannot be: exit code 2.
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
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

impl Cli {
    /// The command line of this process. Exits where it is wrong, or asks for help; an option that was renamed answers with
    /// its new name.
    pub fn read() -> Cli {
        Cli::try_parse().unwrap_or_else(|mut error| {
            let unknown = error.get(ContextKind::InvalidArg).map(ToString::to_string);
            let tip = unknown.and_then(|option| renamed::hint(renamed::OPTIONS, &option));
            if let Some(tip) = tip.filter(|_| error.kind() == ErrorKind::UnknownArgument) {
                error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
            }
            let printed = error.print().and_then(|()| std::io::stdout().flush());
            match printed {
                // Help that nobody gets.
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

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to EXR
    Render(Box<Render>),
    /// Look at a scene in a browser, live: a page that this program serves
    View(Box<Viewer>),
    /// Render the frames of an animation, a file each; the same command resumes where it was interrupted
    Animate(Box<Animate>),
    /// Path trace a scene until it is a reference
    Reference(Box<Reference>),
    /// Join the shards of a render or reference, or references of one view that were rendered with different seeds
    Merge(Merge),
    /// Measure how far an image is from a reference
    Compare(Compare),
    /// Measure what frames of a scene cost and how far off they are, configuration by configuration: a sweep from options
    Bench(Box<Bench>),
    /// Measure a matrix of configurations over scenes, time and error; the same command resumes where it was interrupted
    Sweep(Box<SweepOptions>),
    /// Tell what light transport did at a pixel: its camera path, the photons that it took, and their light paths
    Inspect(Box<Inspect>),
    /// Make a page of results: charts of speed against accuracy, images, tables
    Report(ReportOptions),
    /// List Vulkan devices, what they can do and whether they are used; or compile all kernels for one
    Device(Device),
    /// List, inspect or make scenes
    #[command(subcommand)]
    Scene(SceneCommand),
    /// Print what completes this program's options in a shell
    Completions(Completions),
    /// Write man pages, a file a command
    Man(Man),
}

/// Options of the machine that renders.
#[derive(Args, Clone, Debug)]
pub struct Machine {
    /// What traces rays on a GPU; auto takes ray queries if the device has them
    #[arg(long, value_enum, default_value = "auto")]
    pub tracer: Tracer,
    /// Vulkan device, by index or part of its name (default: the best)
    #[arg(long)]
    pub device: Option<String>,
    /// Folder of compiled kernels that a GPU takes, as `cargo kernels --out DIR` writes it [default: what the environment variable
    /// CAUSTICS_KERNELS names, else those of this program]
    #[arg(long, value_name = "DIR")]
    pub kernels: Option<PathBuf>,
    /// Threads of the CPU runner; 0 takes every core
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
    /// validation: the Vulkan validation layer watches, and its messages fail the run
    #[arg(long, value_enum)]
    pub debug: Option<Debug>,
}

impl Machine {
    /// Where a GPU's kernels come from.
    pub fn source(&self) -> Source {
        self.kernels.clone().map_or_else(Source::from_environment, Source::Folder)
    }
}

/// Options of the image, however it is rendered.
#[derive(Args, Clone, Debug)]
pub struct ImageOptions {
    /// Image width (px)
    #[arg(long, default_value_t = 960)]
    pub width: u32,
    /// Image height (px)
    #[arg(long, default_value_t = 540)]
    pub height: u32,
    /// Render the image in so many tiles, bands of rows one after another, in the memory of one; each has light paths of its own
    /// [default: as few as the device's bindings allow]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub tiles: Option<u32>,
    /// Reflections of at most this roughness are specular
    #[arg(long, default_value_t = 0.25)]
    pub specular_roughness: f32,
    /// Where in a pixel its rays go [default: box where frames are averaged, else centre]
    #[arg(long, value_parser = named::<PixelFilter>())]
    pub pixel_filter: Option<PixelFilter>,
    /// Which level of its textures the camera sees [default: finest for reference, path, progressive, and means of frames over
    /// whole pixels, else cone]
    #[arg(long, value_parser = named::<TextureFilter>())]
    pub texture_filter: Option<TextureFilter>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 0)]
    pub seed: u32,
    /// Name of the camera, or orbit:AZIMUTH,ELEVATION[,DISTANCE]: round what is looked at, in degrees from +z and up, and metres
    /// [default: the first; where there is none, a view of all]
    #[arg(long, value_name = "NAME|ORBIT")]
    pub camera: Option<String>,
    /// Place a camera here, in the file's coordinates (m)
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub from: Option<Position>,
    /// Place a camera that looks at this [default: the middle of the scene]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub look_at: Option<Position>,
    /// Place a camera with this vertical field of view (degrees) [default: 40]
    #[arg(long, value_name = "DEGREES")]
    pub fov: Option<f64>,
    /// Stand the scene on a floor, a wide grey square, so that caustics fall on something
    #[arg(long)]
    pub floor: bool,
    /// Light the scene by a lamp and a soft sky whatever it has, as else only one without light, or a thing that glows
    /// where neither the file nor --from has a camera
    #[arg(long)]
    pub default_light: bool,
    /// Refuse a scene that has no light
    #[arg(long, conflicts_with = "default_light")]
    pub no_default_light: bool,
    /// Exposure of the PNG (stops, or auto for what suits the image)
    #[arg(long, default_value = "auto")]
    pub exposure: Exposure,
    /// Light from all around: a latitude-longitude image (.hdr or .exr), or one radiance as R,G,B [default: what the scene says]
    #[arg(long)]
    pub environment: Option<String>,
    /// By how much that image is turned around the y axis, from +z towards +x (degrees)
    #[arg(long, default_value_t = 0.0, requires = "environment")]
    pub environment_rotation: f32,
    /// Factor on its radiance
    #[arg(long, default_value_t = 1.0, requires = "environment")]
    pub environment_scale: f32,
    /// Radiance behind everything, as R,G,B; it is seen and lights nothing [default: what the scene says, else 0,0,0]
    #[arg(long)]
    pub background: Option<String>,
}

/// Options of how the file of a scene is read.
#[derive(Args, Clone, Debug)]
pub struct Loading {
    /// What is missing or out of range in the scene's file is an error, not a warning
    #[arg(long)]
    pub strict: bool,
    /// Variant of the scene's materials, by name (KHR_materials_variants)
    #[arg(long)]
    pub variant: Option<String>,
    /// The scene's animation that plays, by name; else all of them together
    #[arg(long, value_name = "NAME")]
    pub animation: Option<String>,
    /// Triangles that copies of meshes may take; beyond, a mesh that has several instances is stored once
    #[arg(long, default_value_t = LoadOptions::default().copies, value_name = "TRIANGLES")]
    pub copies: u64,
    /// BVH build quality; another one gives another sample of the same image
    #[arg(long, value_enum, default_value_t, value_name = "QUALITY")]
    pub bvh_quality: BvhQuality,
}

impl Loading {
    /// As the library takes them.
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

/// Options of every command that renders an image. A negative number reaches the check of its option, which names it.
#[derive(Args, Debug)]
pub struct Common {
    /// A .gltf or .glb file, a folder with a scene.gltf, or the name of a folder in scenes/
    pub scene: String,
    /// The EXR file to write
    #[arg(short, long)]
    pub output: PathBuf,
    /// Also write a tone-mapped PNG
    #[arg(long)]
    pub png: Option<PathBuf>,
    /// Also write these layers of what is seen, behind mirrors and glass what is seen in them; several by commas
    #[arg(long, value_enum, value_name = "LAYER", value_delimiter = ',')]
    pub aov: Vec<Aov>,
    /// Send the image to the viewer tev while it converges; tev listens on 127.0.0.1:14158 unless told otherwise
    #[arg(long, value_name = "HOST:PORT")]
    pub tev: Option<String>,
    /// Write the PNG anew while it converges, at most every so many seconds; what tev is sent, too [default: only tev, every 2]
    #[arg(long, value_name = "SECONDS")]
    pub refresh: Option<f64>,
    /// Where it runs.
    #[command(flatten)]
    pub machine: Machine,
    /// What is seen.
    #[command(flatten)]
    pub view: ImageOptions,
    /// How the scene is read.
    #[command(flatten)]
    pub loading: Loading,
    /// Change the scene as this TOML file says: where its nodes stand, the camera, and keys by which they move
    #[arg(long, value_name = "FILE")]
    pub edits: Option<PathBuf>,
    /// Which part of the frames is rendered.
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
    /// Leave the energy ledger out of the JSON: it costs `shoot` time
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
  caustics render mirror-room -o reference.exr --method progressive --frames 1000 --pixel-filter box")]
pub struct Render {
    /// What every command that renders has.
    #[command(flatten)]
    pub common: Common,
    /// Time of the scene's animations that is shown (s); before their first key and after their last they stand still
    #[arg(long, default_value_t = 0.0)]
    pub time: f64,
    /// How to render.
    #[command(flatten)]
    pub parameters: ParameterOptions<Averaged>,
    /// All that no other option says [default: preview where none says how to render, else frame]
    #[arg(long, value_enum)]
    pub preset: Option<Preset>,
    /// Frames to average [default: what the preset says]
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
    /// What every command that renders has.
    #[command(flatten)]
    pub common: Common,
    /// How to render.
    #[command(flatten)]
    pub parameters: ParameterOptions<PathTraced>,
    /// Time of the scene's animations that is shown (s); before their first key and after their last they stand still
    #[arg(long, default_value_t = 0.0)]
    pub time: f64,
    /// Stop at this many samples a pixel [default: 1024, if nothing else stops it]
    #[arg(long)]
    pub spp: Option<u32>,
    /// Stop after this time, that of resumed runs included (s)
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
    /// The shards of one run of render or reference; or references of one view with different seeds
    #[arg(required = true, num_args = 2..)]
    pub inputs: Vec<PathBuf>,
    /// The EXR file to write
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
    /// Compile every entry point for a device, in a process each, and print what its driver made of them
    #[arg(long)]
    pub compile: bool,
    /// Device to compile for, by index or part of its name (default: the best)
    #[arg(long, requires = "compile")]
    pub device: Option<String>,
    /// Code that is compiled in: all, none, or what a scene needs; several by commas
    #[arg(long, requires = "compile", value_delimiter = ',', default_value = "all")]
    pub features: Vec<String>,
    /// Only these entry points, by commas (default: every one)
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
    /// Print what a scene holds and what it needs of the kernels
    Info {
        /// A file, a folder, or a name
        scene: String,
        /// Reflections of at most this roughness are specular
        #[arg(long, default_value_t = 0.25)]
        specular_roughness: f32,
        /// How the scene is read.
        #[command(flatten)]
        loading: Loading,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Load every .gltf and .glb file below a folder, each in a process of its own, and say what keeps which from being rendered
    Survey(Survey),
    /// Generate a scene's files
    Make {
        /// A name of `scene list`, or `all` for those that are committed
        name: String,
        /// Folder that gets a folder of that name [default: scenes, or scenes/generated for those made on demand]
        #[arg(short, long)]
        output: Option<PathBuf>,
        /// Overwrite existing files
        #[arg(long)]
        force: bool,
    },
}
