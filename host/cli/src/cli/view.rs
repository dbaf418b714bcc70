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
    /// Port of the page; 0 takes any that is free
    #[arg(long, default_value_t = 8317)]
    pub port: u16,
    /// Address to serve at; any but a loopback address lets others in your network reach the page, who then need its token
    #[arg(long, default_value = "127.0.0.1")]
    pub bind: IpAddr,
    /// Frames a second to hold while something moves, by smaller frames
    #[arg(long, default_value_t = 10.0)]
    pub target_fps: f64,
    /// Time of the scene's animations that is shown first (s)
    #[arg(long, default_value_t = 0.0)]
    pub time: f64,
    /// Begin with the edits of this file, which `render --edits` takes too
    #[arg(long, value_name = "FILE")]
    pub edits: Option<PathBuf>,
    /// Where it runs.
    #[command(flatten)]
    pub machine: Machine,
    /// What is seen.
    #[command(flatten)]
    pub view: ImageOptions,
    /// How the scene is read.
    #[command(flatten)]
    pub loading: Loading,
    /// How to render.
    #[command(flatten)]
    pub parameters: ParameterOptions<OneConfiguration>,
}
