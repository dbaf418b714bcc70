//! Result of an experiment for one run configuration: a JSON file, written by `bench` and `sweep`, read by `report`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::cost::Cost;
use super::error::Measure;
use super::parameter::{Parameter, Values};
use crate::renamed;

/// A run configuration, its measures, and where they come from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunResult {
    /// Hash of everything that decides the measures; the file's name.
    pub identity: String,
    /// Scene, camera and settings.
    #[serde(rename = "cell")]
    pub config: ConfigValues,
    /// Times of a frame; none where only errors were measured.
    pub time: Option<TimeResult>,
    /// Errors against the reference; none where only times were measured.
    pub error: Option<ErrorResult>,
    /// Results of each frame, for scenes that move.
    pub frames: Vec<FrameResult>,
    /// Origin of the measures.
    pub provenance: Provenance,
    /// Note for the reader, such as a target time that was not met.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// Scene, camera and settings of a run configuration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ConfigValues {
    /// Name of the scene.
    pub scene: String,
    /// Name of the camera.
    pub camera: String,
    /// `cone` or `finest`; empty in files older than the choice, which used `cone`.
    #[serde(default)]
    pub texture_filter: String,
    /// The value of each parameter by its key.
    #[serde(flatten)]
    values: BTreeMap<String, Value>,
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
enum Value {
    Number(f64),
    Name(String),
}

impl ConfigValues {
    /// Values of a scene and a camera, without parameters.
    pub fn new(scene: &str, camera: &str) -> ConfigValues {
        ConfigValues { scene: scene.into(), camera: camera.into(), ..ConfigValues::default() }
    }

    /// Returns the value of a parameter as text; empty where the file is older than the parameter.
    pub fn text(&self, parameter: &Parameter) -> String {
        match self.values.get(parameter.key) {
            Some(Value::Number(number)) => number.to_string(),
            Some(Value::Name(name)) => name.clone(),
            None => String::new(),
        }
    }

    /// Returns the value of a parameter as a number; 0 where it is not a number.
    pub fn number(&self, parameter: &Parameter) -> f64 {
        if let Some(Value::Number(number)) = self.values.get(parameter.key) { *number } else { 0.0 }
    }

    /// Sets the value of a parameter.
    pub fn set(&mut self, parameter: &Parameter, text: &str) {
        let value = match (parameter.values, text.parse()) {
            (Values::Numbers(_), Ok(number)) => Value::Number(number),
            _ => Value::Name(text.into()),
        };
        self.values.insert(parameter.key.into(), value);
    }

    /// Returns these values with another value of a parameter.
    pub fn with(mut self, parameter: &Parameter, text: &str) -> ConfigValues {
        self.set(parameter, text);
        self
    }

    /// Renames the parameters of older files to their current names.
    pub fn rename(&mut self) {
        for (old, new) in renamed::KEYS {
            if let Some(value) = self.values.remove(*old) {
                self.values.insert((*new).into(), value);
            }
        }
    }
}

/// Time of a frame and of its parts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TimeResult {
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
    /// Median of the ratios of the frame's time to the time of the first run configuration in the same turn.
    pub ratio_to_first: Option<f64>,
    /// Name of that first configuration.
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
    /// Measured and expected costs of passes, where the tracer alone was timed too.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub costs: BTreeMap<String, Cost>,
}

/// Median and interquartile range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quartiles {
    /// Lower quartile.
    pub lower: f64,
    /// The median.
    pub median: f64,
    /// Upper quartile.
    pub upper: f64,
}

/// Errors against the reference; means over seeds and frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorResult {
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
    /// Image of the last frame, from the first seed: name of a PNG beside the JSON.
    #[serde(alias = "picture")]
    pub image: Option<String>,
    /// PNG of the image's FLIP map.
    pub error_map: Option<String>,
    /// PNG of that frame's reference.
    pub reference: Option<String>,
    /// Standard errors of measures between seeds, by their keys; empty for a single seed.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub standard_errors: BTreeMap<String, f64>,
    /// Measures of error by their keys.
    #[serde(flatten)]
    pub values: BTreeMap<String, Option<f64>>,
}

impl ErrorResult {
    /// The standard error of a measure between seeds.
    pub fn standard_error(&self, measure: &Measure) -> Option<f64> {
        self.standard_errors.get(measure.key).copied()
    }

    /// The value of a measure.
    pub fn get(&self, measure: &Measure) -> Option<f64> {
        self.values.get(measure.key).copied().flatten()
    }

    /// Returns these errors with another value of a measure.
    pub fn with(mut self, measure: &Measure, value: Option<f64>) -> ErrorResult {
        self.values.insert(measure.key.into(), value);
        self
    }
}

/// Result of one frame of an animation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameResult {
    /// Index of the frame.
    pub frame: u32,
    /// Time of the frame (ms).
    pub total_ms: Option<f64>,
    /// Measures of error by their keys.
    #[serde(flatten)]
    pub values: BTreeMap<String, Option<f64>>,
}

impl FrameResult {
    /// The value of a measure.
    pub fn get(&self, measure: &Measure) -> Option<f64> {
        self.values.get(measure.key).copied().flatten()
    }
}

/// Origin of a measure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Commit of the program.
    pub commit: String,
    /// Hash of the kernels' sources.
    pub kernels: String,
    /// Device and driver.
    pub device: String,
    /// Processor, memory, system and compiler; empty in results that are older than this field.
    #[serde(default)]
    pub machine: String,
    /// First seed.
    pub seed: u32,
    /// Time that measuring the run configuration took (s).
    pub wall_s: f64,
    /// When it was measured: seconds since 1970.
    pub unix_s: u64,
}
