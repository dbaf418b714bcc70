//! View request, and the messages of the page that change it.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use caustics::exposure::Exposure;
use caustics::scene::{CameraChoice, Edits, NodeEdit, Position};
use caustics::text::cut;
use caustics_bench::limits::{check_rays, check_size};
use caustics_bench::parameter::{HISTORY, PATH_HISTORY, Parameter};
use caustics_bench::run_config::RunConfig;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::look::{Layer, Look};

/// Time after the last movement for which something still counts as moving.
const SETTLES: Duration = Duration::from_millis(250);
/// Maximum number of nodes that can be moved.
pub const MAX_EDITS: usize = 1000;
/// Maximum number of characters of a message that an error repeats.
const MAX_ERROR: usize = 400;
/// Range of frame rates that a page can set (frames a second).
pub const RATES: std::ops::RangeInclusive<f64> = 0.1..=240.0;

/// Edits by the index of their node.
pub type NodeEdits = BTreeMap<usize, NodeEdit>;

/// Image to compare with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Against {
    /// Nothing.
    #[default]
    Nothing,
    /// Another configuration.
    Other,
    /// Path tracing of all light.
    Reference,
}

/// View request: everything that decides the image.
#[derive(Clone, Debug)]
pub struct ViewRequest {
    /// Camera.
    pub camera: CameraChoice,
    /// Time at which the page chose that camera, by its own clock.
    pub at: f64,
    /// Time of the animations (s).
    pub time: f64,
    /// Start of playing, from that time on.
    pub playing: Option<Instant>,
    /// Width and height of the image (px).
    pub size: [u32; 2],
    /// Frames a second to hold while something moves.
    pub target_fps: f64,
    /// Configurations of the image and of the one to compare with.
    pub run_configs: [RunConfig; 2],
    /// Image to compare with.
    pub against: Against,
    /// Display of the image.
    pub look: Look,
    /// End of the time for which something counts as moving.
    pub moves_until: Option<Instant>,
    /// Edits of nodes.
    pub nodes: NodeEdits,
    /// Whether movements are recorded.
    pub records: bool,
    /// Whether rendering is paused.
    pub paused: bool,
}

/// Message of a page.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub enum Message {
    /// Look from a position, in the file's coordinates (m), with this vertical field of view (degrees). `at` is the time of
    /// the page's clock, which the image returns.
    Look {
        from: [f64; 3],
        look_at: [f64; 3],
        fov: f64,
        #[serde(default)]
        at: f64,
    },
    /// Look through a camera of the file.
    Camera { name: String },
    /// Go to a time (s), and play or stop.
    Time { seconds: f64, playing: bool },
    /// Set a parameter, of the image (0) or of the one to compare with (1).
    Axis { side: u8, key: String, value: String },
    /// Size of the image (px).
    Size { width: u32, height: u32 },
    /// Frame rate to hold while something moves (frames a second).
    Rate { fps: f64 },
    /// Exposure, in stops or `auto`.
    Exposure { stops: String },
    /// Layer to show.
    Layer { name: Layer },
    /// Image to compare with.
    Against { what: Against },
    /// Place a node of the file by its own transform.
    Place { node: usize, translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3] },
    /// Reset a node to its transform in the file.
    PutBack { node: usize },
    /// Start or stop recording movements.
    Record { on: bool },
    /// Pause or resume rendering.
    Pause { paused: bool },
    /// Query the first hit of a pixel; positions are shares of width and height.
    Pick { x: f64, y: f64 },
    /// Query the light transport of a pixel; positions are shares of width and height.
    Inspect { x: f64, y: f64 },
    /// Query the description of a node of the file.
    Node { node: usize },
    /// The page has shown an image.
    Shown { serial: u64 },
    /// The sender takes the control token.
    TakeControl,
}

impl Message {
    /// Parses a message in JSON.
    ///
    /// # Errors
    ///
    /// If it is not a message; the text is for the user.
    pub fn parse(json: &[u8]) -> Result<Message, String> {
        serde_json::from_slice(json)
            .map_err(|error| format!("unknown message: {}", cut(&error.to_string(), MAX_ERROR)))
    }
}

impl ViewRequest {
    /// Applies a message. Returns whether the current image is outdated.
    ///
    /// # Errors
    ///
    /// If the message is invalid; the text is for the user.
    pub fn take(&mut self, message: &Message) -> Result<bool, String> {
        match message {
            Message::Look { from, look_at, fov, at } => {
                let [from, look_at] = [from, look_at].map(|position| Position(DVec3::from_array(*position)));
                if !from.0.is_finite() || !look_at.0.is_finite() {
                    return Err("positions of a camera must be finite numbers".into());
                }
                let placed = CameraChoice::from_options(None, Some(from), Some(look_at), Some(*fov))?;
                self.camera = placed;
                self.at = *at;
            }
            Message::Camera { name } => self.camera = CameraChoice::Named(name.clone()),
            Message::Time { seconds, playing } => {
                if !seconds.is_finite() {
                    return Err("a time must be a number of seconds".into());
                }
                self.time = *seconds;
                self.playing = playing.then(Instant::now);
            }
            Message::Axis { side, key, value } => self.set(*side, key, value)?,
            Message::Size { width, height } => self.resize([*width, *height])?,
            Message::Rate { fps } => {
                if !RATES.contains(fps) {
                    return Err(format!("give {} to {} frames a second", RATES.start(), RATES.end()));
                }
                self.target_fps = *fps;
                return Ok(false);
            }
            Message::Exposure { stops } => {
                self.look.exposure = stops.parse::<Exposure>()?;
                return Ok(false);
            }
            Message::Layer { name } => {
                self.look.layer = *name;
                return Ok(false);
            }
            Message::Against { what } => {
                self.against = *what;
                return Ok(false);
            }
            Message::Pause { paused } => {
                self.paused = *paused;
                return Ok(false);
            }
            Message::Place { node, translation, rotation, scale } => {
                let edit = NodeEdit {
                    node: *node,
                    name: None,
                    translation: Some(*translation),
                    rotation: Some(*rotation),
                    scale: Some(*scale),
                };
                if !self.nodes.contains_key(node) && self.nodes.len() >= MAX_EDITS {
                    return Err(format!("at most {MAX_EDITS} nodes can be moved"));
                }
                let nodes = vec![edit.clone()];
                Edits { nodes, ..Edits::default() }.check().map_err(|error| error.to_string())?;
                self.nodes.insert(*node, edit);
            }
            Message::PutBack { node } => {
                self.nodes.remove(node);
            }
            Message::Record { on } => {
                self.records = *on;
                return Ok(false);
            }
            Message::Pick { .. }
            | Message::Inspect { .. }
            | Message::Node { .. }
            | Message::Shown { .. }
            | Message::TakeControl => return Ok(false),
        }
        self.moves_until = Some(Instant::now() + SETTLES);
        Ok(true)
    }

    fn set(&mut self, side: u8, key: &str, value: &str) -> Result<(), String> {
        let parameter = Parameter::find(key).ok_or_else(|| format!("there is no parameter {key:?}"))?;
        let run_config = self.run_configs.get_mut(usize::from(side)).ok_or("there are two sides, 0 and 1")?;
        let mut changed = run_config.clone();
        parameter.set(&mut changed, value).map_err(|wrong| format!("{}: {wrong}", parameter.head))?;
        check_rays(&changed.config, self.size[0], self.size[1])?;
        *run_config = changed;
        Ok(())
    }

    fn resize(&mut self, size: [u32; 2]) -> Result<(), String> {
        let [width, height] = size;
        check_size(width, height)?;
        for run_config in &self.run_configs {
            check_rays(&run_config.config, width, height)?;
        }
        self.size = size;
        Ok(())
    }

    /// Whether something moves now.
    pub fn moves(&self, now: Instant) -> bool {
        self.playing.is_some() || self.moves_until.is_some_and(|until| now < until)
    }

    /// Returns the time of the animations now (s); they repeat after this duration (s).
    pub fn time_at(&self, now: Instant, duration: f64) -> f64 {
        match self.playing {
            Some(since) if duration > 0.0 => (self.time + (now - since).as_secs_f64()).rem_euclid(duration),
            _ => self.time,
        }
    }
}

/// Returns the configuration of a still view, whose frames are averaged as in `render`, so that histories do not help.
pub fn still(run_config: &RunConfig) -> RunConfig {
    let mut run_config = run_config.clone();
    for parameter in [&HISTORY, &PATH_HISTORY] {
        // A parameter's neutral value is always valid.
        let _ = parameter.set(&mut run_config, parameter.neutral);
    }
    run_config.effective()
}
