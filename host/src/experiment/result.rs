//! What an experiment says of a cell: one JSON file a cell, written by `bench` and `sweep`, read by `report`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// A cell, its measures, and where they come from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CellResult {
    /// Hash of all that decides the measures; the file's name.
    pub identity: String,
    /// What was rendered, and how.
    pub cell: CellConfig,
    /// How long a frame takes; none where only errors were measured.
    pub time: Option<CellTime>,
    /// How far frames are from the reference; none where only times were measured.
    pub error: Option<CellError>,
    /// Frame by frame, of scenes that move.
    pub frames: Vec<FrameResult>,
    /// Where it was measured.
    pub provenance: Provenance,
    /// What a reader should know: a time that could not be met, say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// What was rendered, and how.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CellConfig {
    /// Name of the scene.
    pub scene: String,
    /// Name of the camera.
    pub camera: String,
    /// Name of the method.
    pub method: String,
    /// Name of the gather; empty for methods that choose none.
    pub gather: String,
    /// Name of the history.
    pub history: String,
    /// Name of the filter.
    pub denoiser: String,
    /// `cpu`, `gpu-hardware` or `gpu-software`.
    pub runner: String,
    /// `scene` (what it needs) or `all`.
    pub features: String,
    /// Light paths a pixel and frame.
    pub paths_per_pixel: f64,
    /// Radius of collection points relative to the disc of the pixel's footprint.
    pub radius_px: f32,
    /// Scattering vertices between eye and light, at most.
    pub max_bounces: u32,
    /// `cone` or `finest`; empty in files older than the choice, which are of `cone`.
    #[serde(default)]
    pub texture_filter: String,
}

/// Time of a frame and what it is made of.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CellTime {
    /// Image width (px).
    pub width: u32,
    /// Image height (px).
    pub height: u32,
    /// Light paths a frame.
    pub light_paths: u32,
    /// Triangles of the scene.
    #[serde(default)]
    pub triangles: u64,
    /// Frames measured.
    pub frames: u32,
    /// Time of a frame (ms).
    pub total_ms: Quartiles,
    /// Median of the frame's time over that of the run's first cell in the same turn.
    pub ratio_to_first: Option<f64>,
    /// Name of that first cell.
    pub first: String,
    /// Time of each pass (ms).
    pub pass_ms: BTreeMap<String, Quartiles>,
    /// Rays a frame: camera, shadow and light rays.
    pub rays: f64,
    /// Rays a second, by the passes that trace them.
    pub rays_per_s: f64,
    /// Points gathered a second, by the passes of the gather.
    pub points_per_s: Option<f64>,
    /// Light paths traced and gathered a second, by all passes but those of the camera.
    pub light_paths_per_s: Option<f64>,
    /// Bytes of each buffer.
    pub memory_bytes: BTreeMap<String, u64>,
}

/// Median and interquartile range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quartiles {
    /// A quarter is below.
    pub lower: f64,
    /// The median.
    pub median: f64,
    /// A quarter is above.
    pub upper: f64,
}

/// Errors against the reference; means over seeds and frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CellError {
    /// Image width (px).
    pub width: u32,
    /// Image height (px).
    pub height: u32,
    /// Light paths a frame.
    pub light_paths: u32,
    /// Independent runs.
    pub seeds: u32,
    /// Frames of the progressive reference.
    pub reference_frames: u32,
    /// Mean FLIP.
    pub flip: Option<f64>,
    /// FLIP of the caustics under the reference's other light.
    pub flip_caustics: Option<f64>,
    /// Relative mean squared error.
    pub relmse: Option<f64>,
    /// That of the caustics' layer.
    pub relmse_caustics: Option<f64>,
    /// Picture of the last frame, the first seed's: a PNG beside the JSON.
    pub picture: Option<String>,
    /// FLIP of each of its pixels as PNG.
    pub error_map: Option<String>,
    /// The reference of that frame as PNG.
    pub reference: Option<String>,
}

/// A frame of a cell of an animation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameResult {
    /// Index of the frame.
    pub frame: u32,
    /// Time of the frame (ms).
    pub total_ms: Option<f64>,
    /// Mean FLIP.
    pub flip: Option<f64>,
    /// FLIP of the caustics under the reference's other light.
    pub flip_caustics: Option<f64>,
}

/// Where a measure comes from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Commit of the program.
    pub commit: String,
    /// Hash of the kernels' sources.
    pub kernels: String,
    /// Device and driver.
    pub device: String,
    /// First seed.
    pub seed: u32,
    /// Time that measuring the cell took (s).
    pub wall_s: f64,
    /// When it was measured: seconds since 1970.
    pub unix_s: u64,
}
