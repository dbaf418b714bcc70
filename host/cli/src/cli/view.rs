//! Options of `view`.

use std::net::IpAddr;
use std::path::PathBuf;

use clap::Args;

use super::parameters::OneConfiguration;
use super::{ImageOptions, Loading, Machine, ParameterOptions};

/// Options of `view`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
#[command(before_help = "Examples:
  caustics view still-life
  caustics view path/to/scene.glb --target-fps 5
  ssh -L 8317:127.0.0.1:8317 server caustics view still-life     # then open the address that it prints")]
pub struct Viewer {
    /// A .gltf or .glb file, a folder with a scene.gltf, or the name of a folder in scenes/
    pub scene: String,
    /// Port of the page; 0 takes any free port
    #[arg(long, default_value_t = 8317)]
    pub port: u16,
    /// Address to serve at; at any but a loopback address, others in the network can reach the page, if they know its token
    #[arg(long, default_value = "127.0.0.1")]
    pub bind: IpAddr,
    /// Frames a second to hold while something moves; frames get smaller if necessary
    #[arg(long, default_value_t = 10.0)]
    pub target_fps: f64,
    /// Time of the scene's animations to show first (s)
    #[arg(long, default_value_t = 0.0)]
    pub time: f64,
    /// Start with the edits in this file, which `render --edits` takes too
    #[arg(long, value_name = "FILE")]
    pub edits: Option<PathBuf>,
    /// Runner of the command.
    #[command(flatten)]
    pub machine: Machine,
    /// Image and camera.
    #[command(flatten)]
    pub view: ImageOptions,
    /// Loading of the scene.
    #[command(flatten)]
    pub loading: Loading,
    /// Options of the parameters.
    #[command(flatten)]
    pub parameters: ParameterOptions<OneConfiguration>,
}
