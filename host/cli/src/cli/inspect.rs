//! Options of `inspect`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;

use super::parameters::{Averaged, ParameterOptions};
use super::{ImageOptions, Loading, Machine, Preset};

/// Options of `inspect`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
#[command(before_help = "Examples:
  caustics inspect mirror-room --pixel 367,337
  caustics inspect still-life --pixel 480,300 --frame 3 --photons 8 --json")]
#[command(mut_arg("exposure", |arg| arg.hide(true)))]
pub struct Inspect {
    /// A .gltf or .glb file, a folder with a scene.gltf, or the name of a folder in scenes/
    pub scene: String,
    /// Column and row of the pixel, from 0,0 in the upper left
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pub pixel: Pixel,
    /// Index of the frame, among those that render averages with the same options; earlier ones are rendered too
    #[arg(long, default_value_t = 0, value_name = "INDEX")]
    pub frame: u32,
    /// Maximum number of photons to print, each with its light path
    #[arg(long, default_value_t = 4, value_name = "NUMBER")]
    pub photons: usize,
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
    /// Time of the scene's animations to show (s); they stand still before their first key and after their last
    #[arg(long, default_value_t = 0.0)]
    pub time: f64,
    /// Options of the parameters.
    #[command(flatten)]
    pub parameters: ParameterOptions<Averaged>,
    /// Values for options that are not given [default: preview where no option says how to render, else frame]
    #[arg(long, value_enum)]
    pub preset: Option<Preset>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// A position in an image (px).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pixel {
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
}

impl FromStr for Pixel {
    type Err = String;

    fn from_str(text: &str) -> Result<Pixel, String> {
        let number = |part: &str| part.trim().parse().ok();
        let parts = text.split_once(',').map(|(x, y)| (number(x), number(y)));
        match parts {
            Some((Some(x), Some(y))) => Ok(Pixel { x, y }),
            _ => Err("give a column and a row, as in 300,400".into()),
        }
    }
}
