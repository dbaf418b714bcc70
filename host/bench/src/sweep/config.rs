//! Sweep file (TOML). An error names the line and shows the key.

use std::ops::RangeInclusive;

use caustics_kernels::interface::choice::{PixelFilter, TextureFilter};
use serde::Deserialize;
use toml::Spanned;

use super::matrix_table::MatrixTable;
use super::value::{Count, NonEmpty, Positive, Side};
use crate::reference::SEED;
use crate::renamed;
use caustics::exact;
use caustics::memory;
use caustics::named::{by_name, by_name_if_any};
use caustics::render_config::RenderConfig;
use caustics::scene::{
    BvhCache, BvhOptions, BvhQuality, DefaultLight, EnvironmentMap, LoadOptions, Radiance, SceneError,
};

/// Maximum number of run configurations of a file, counted before any is left out. At a second each, they take more than a
/// day.
const MAX_RUNS: u64 = 100_000;
/// Maximum size of a file (bytes).
const MAX_BYTES: usize = 1 << 24;
/// Maximum number of frames, with those before the first measured one and the warm-up.
const MAX_FRAMES: u64 = 1_000_000;
/// Range of an animation's frame rate (frames a second).
pub const FPS: RangeInclusive<f64> = 1e-3..=1e9;

/// A sweep file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepConfig {
    /// Frames a second of scenes that move.
    #[serde(default = "fps")]
    pub fps: Positive,
    /// First frame of scenes that move.
    #[serde(default)]
    pub first_frame: u32,
    /// First seed.
    #[serde(default)]
    pub seed: u32,
    /// Exposure of the display, for FLIP and for the PNGs (stops).
    #[serde(default)]
    pub exposure: f32,
    /// Texture level that the camera sees, in all run configurations and references.
    #[serde(default = "cone", deserialize_with = "by_name::deserialize")]
    pub texture_filter: TextureFilter,
    /// Maximum roughness of a specular reflection.
    #[serde(default = "specular_roughness")]
    pub specular_roughness: f32,
    /// Position within a pixel of its rays.
    #[serde(default = "centre", deserialize_with = "by_name::deserialize")]
    pub pixel_filter: PixelFilter,
    /// Position of the references' rays within a pixel; none: that of the images. `box` also takes the finest texture level.
    #[serde(default, deserialize_with = "by_name_if_any::deserialize")]
    pub reference_pixel_filter: Option<PixelFilter>,
    /// Radiance behind everything (W m^-2 sr^-1); none: the scene's own.
    #[serde(default, deserialize_with = "exact::optional")]
    pub background: Option<[f32; 3]>,
    /// Light from all around; none: the scene's own.
    pub environment: Option<EnvironmentTable>,
    /// Condition under which scenes get the default light.
    #[serde(default)]
    pub default_light: DefaultLight,
    /// Whether scenes stand on a floor.
    #[serde(default)]
    pub floor: bool,
    /// Whether missing or out-of-range values in a scene's file are errors.
    #[serde(default)]
    pub strict: bool,
    /// Name of a variant of the scenes' materials.
    pub variant: Option<String>,
    /// Name of the animation that plays; none: all of them together.
    pub animation: Option<String>,
    /// Maximum number of triangles in copies of meshes; beyond it, a mesh that has several instances is stored once.
    #[serde(default = "copies")]
    pub copies: u64,
    /// BVH build quality of the scenes.
    #[serde(default)]
    pub bvh_quality: BvhQuality,
    /// Time of the scenes' animations that all frames show (s); none: frame k shows the time k / fps.
    pub moment_s: Option<f64>,
    /// Measurement of times, if any.
    pub time: Option<TimeTable>,
    /// Measurement of errors, if any.
    pub error: Option<ErrorTable>,
    /// The run configurations.
    pub matrix: Vec<Spanned<MatrixTable>>,
}

/// Environment of all scenes.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnvironmentTable {
    /// A latitude-longitude image (.hdr or .exr), or one radiance as `R,G,B`.
    pub source: String,
    /// Rotation around the y axis, from +z towards +x (degrees).
    #[serde(default)]
    pub rotation: f32,
    /// Factor on its radiance.
    #[serde(default = "one")]
    pub scale: f32,
}

impl EnvironmentTable {
    /// Loads the environment.
    pub fn map(&self) -> Result<EnvironmentMap, SceneError> {
        Ok(EnvironmentMap::named(&self.source)?.placed(self.scale, self.rotation))
    }
}

fn one() -> f32 {
    1.0
}

/// Table `[time]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeTable {
    /// Image width (px).
    pub width: Side,
    /// Image height (px).
    pub height: Side,
    /// Number of timed frames.
    #[serde(default = "sixteen")]
    pub frames: Count,
    /// Number of untimed frames before them.
    #[serde(default = "two")]
    pub warm_up: u32,
    /// Whether the tracer alone is timed too, for comparison with the passes that trace.
    #[serde(default)]
    pub tracer_rate: bool,
}

/// Table `[error]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorTable {
    /// Image width (px).
    pub width: Side,
    /// Image height (px).
    pub height: Side,
    /// Independent seeds of each run configuration.
    #[serde(default = "four")]
    pub seeds: Count,
    /// Frames of the progressive reference.
    #[serde(default = "many")]
    pub reference_frames: Count,
    /// Number of frames. Scenes that move: all are measured, each with a reference. Still scenes: only the last is
    /// measured, and the others are rendered where state outlives a frame.
    #[serde(default = "sixteen")]
    pub frames: Count,
    /// Whether every frame of still scenes is measured too.
    #[serde(default)]
    pub every_frame: bool,
    /// The only frames that are measured and have a reference, in all scenes; the first frame is 0.
    #[serde(default)]
    pub compared_frames: Option<NonEmpty<u32>>,
}

impl SweepConfig {
    /// Reads the text of a file.
    pub fn parse(text: &str) -> Result<SweepConfig, String> {
        if text.len() > MAX_BYTES {
            return Err(format!("it has more than {MAX_BYTES} bytes; share its [[matrix]] out among files"));
        }
        memory::check(memory::toml_parse_bytes(text))
            .map_err(|short| format!("it would take {short}; share its [[matrix]] out among files"))?;
        let config: SweepConfig = toml::from_str(text).map_err(|error| {
            let message = error.to_string().trim_end().to_string();
            let unknown = message.split_once("unknown field `").and_then(|(_, rest)| rest.split('`').next());
            let hint = unknown.and_then(|key| renamed::hint(renamed::KEYS, key));
            hint.map_or(message.clone(), |hint| format!("{message}\n{hint}"))
        })?;
        config.check(text)?;
        Ok(config)
    }

    /// Options for loading the scenes.
    pub fn load(&self) -> LoadOptions {
        LoadOptions {
            strict: self.strict,
            variant: self.variant.clone(),
            animation: self.animation.clone(),
            floor: self.floor,
            copies: self.copies,
            bvh: BvhOptions { quality: self.bvh_quality, cache: BvhCache::for_user() },
            ..LoadOptions::default()
        }
    }

    /// Checks the settings against each other; `text` is the file's text, if there is one.
    ///
    /// # Errors
    /// If a setting is invalid; the message gives the key's line in the text.
    pub fn check(&self, text: &str) -> Result<(), String> {
        if self.time.is_none() && self.error.is_none() {
            return Err("there is nothing to measure: give a table [time], [error], or both".into());
        }
        if !(-64.0..=64.0).contains(&self.exposure) {
            return Err(format!("exposure = {}: give -64 to 64 stops", self.exposure));
        }
        if !(0.0..=1.0).contains(&self.specular_roughness) {
            return Err(format!("specular_roughness = {}: give 0 to 1", self.specular_roughness));
        }
        if self.background.is_some_and(|background| Radiance::new(&background).is_none()) {
            return Err("background: give three numbers from 0 to 1e30".into());
        }
        if self.moment_s.is_some_and(|time| !time.is_finite()) {
            return Err("moment_s: give a number of seconds".into());
        }
        let seeds = self.error.as_ref().map_or(1, |error| error.seeds.0);
        let last = self.seed.checked_add(seeds - 1);
        if last.is_none_or(|last| (self.seed..=last).contains(&SEED)) {
            return Err(format!("seed = {}: references have the seed {SEED}; give another", self.seed));
        }
        if !FPS.contains(&self.fps.0) {
            return Err(format!(
                "fps = {}: give {} to {} frames a second",
                self.fps.0,
                FPS.start(),
                FPS.end()
            ));
        }
        let of_time = self.time.as_ref().map_or(0, |time| u64::from(time.frames.0) + u64::from(time.warm_up));
        let of_error = self.error.as_ref().map_or(0, |error| u64::from(error.frames.0));
        let count = u64::from(self.first_frame) + of_time.max(of_error);
        if count > MAX_FRAMES {
            return Err(format!(
                "{count} frames with those before them and to warm up: at most {MAX_FRAMES}"
            ));
        }
        if let Some(error) = &self.error
            && let Some(frames) = &error.compared_frames
            && let Some(wrong) = frames.0.iter().find(|frame| **frame >= error.frames.0)
        {
            let count = error.frames.0;
            return Err(format!("compared_frames: of {count} frames none is {wrong}; the first is 0"));
        }
        let mut count = 0_u64;
        for matrix in &self.matrix {
            let start = matrix.span().start.min(text.len());
            let matrix = matrix.get_ref();
            count = count.saturating_add(matrix.count());
            let wrong = if count > MAX_RUNS {
                format!(
                    "its lists make {count} run configurations with those before it, and at most {MAX_RUNS} are measured; \
                     share them out among files"
                )
            } else if matrix.paths_keys.len() != 1 {
                "give one of light_paths, paths_per_pixel and equal_time_ms".into()
            } else if !matrix.size.is_empty() && self.time.is_none() {
                "size needs a table [time]".into()
            } else if matrix.paths_keys == ["equal_time_ms"] && self.time.is_none() {
                "equal_time_ms needs a table [time]".into()
            } else {
                continue;
            };
            let line = 1 + text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count();
            return Err(format!("line {line}, [[matrix]]: {wrong}"));
        }
        Ok(())
    }
}

fn fps() -> Positive {
    Positive(24.0)
}

fn cone() -> TextureFilter {
    TextureFilter::Cone
}

fn centre() -> PixelFilter {
    PixelFilter::Centre
}

fn copies() -> u64 {
    LoadOptions::default().copies
}

fn specular_roughness() -> f32 {
    RenderConfig::default().specular_roughness
}

fn two() -> u32 {
    2
}

fn four() -> Count {
    Count(4)
}

fn sixteen() -> Count {
    Count(16)
}

fn many() -> Count {
    Count(256)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::{HISTORY, MAX_BOUNCES, RADIUS_PX, RUNNER};

    const GOOD: &str = "[time]\nwidth = 64\nheight = 36\n\n[[matrix]]\nscene = [\"ring\"]\nmethod = [\"basic\"]\n\
                        paths_per_pixel = [1]\n";

    #[test]
    fn missing_keys_have_defaults() {
        let config = SweepConfig::parse(GOOD).unwrap();
        let matrix = config.matrix[0].get_ref();
        assert_eq!((config.fps.0, config.time.unwrap().frames.0), (24.0, 16));
        assert_eq!(config.texture_filter, TextureFilter::Cone);
        let defaults = [&HISTORY, &MAX_BOUNCES, &RADIUS_PX, &RUNNER]
            .map(|parameter| matrix.parameters.values(parameter));
        assert_eq!(defaults, [["none"], ["5"], ["1"], ["auto"]]);
    }

    #[test]
    fn a_wrong_value_is_named_with_its_line() {
        for (from, to, line, named) in [
            ("scene =", "szene =", "line 6", "szene"),
            ("\"basic\"", "\"basik\"", "line 7", "basik"),
            ("[time]", "texture_filter = \"coarse\"\n[time]", "line 1", "finest"),
            ("[1]", "[0]", "line 8", "paths_per_pixel"),
            ("[1]", "[]", "line 8", "paths_per_pixel"),
            ("[1]", "\"one\"", "line 8", "paths_per_pixel"),
            ("width = 64", "width = 64000", "line 2", "width"),
            ("width = 64", "widht = 64", "line 2", "widht"),
            ("[1]", "[1]\nlight_paths = [9]", "line 5", "light_paths"),
            ("[1]", "[1]\nmax_bounces = [65]", "line 9", "max_bounces"),
            ("[1]", "[1]\nrunner = [\"abacus\"]", "line 9", "gpu-software"),
            ("[1]", "[1]\nsize = [[0, 36]]", "line 9", "size"),
            ("[1]", "[1]\nsize = [[64]]", "line 9", "size"),
            ("[1]", "[1]\nsize = [[64, 36, 1]]", "line 9", "length 3"),
            ("[1]", "[1]\nfrom = [1, 2, 3, 4]", "line 9", "length 4"),
            ("[time]", "background = [1, 1, 1, 1]\n[time]", "line 1", "length 4"),
            ("[1]", "[1e400]", "line 8", "paths_per_pixel"),
            ("[1]", "[1]\ngather = [\"sieve\"]", "line 9", "photons-grid"),
            ("[1]", "[1]\nneeds = [\"all\"]", "line 9", "needs is called features now"),
            ("[1]", "[1]\nconnections = [\"power\"]", "line 9", "connections is called light_sampler now"),
            ("[time]", "tree_quality = \"fast\"\n[time]", "line 1", "tree_quality is called bvh_quality now"),
        ] {
            assert!(GOOD.contains(from));
            let error = SweepConfig::parse(&GOOD.replacen(from, to, 1)).unwrap_err();
            assert!(error.contains(line) && error.contains(named), "{to}: {error}");
        }
        let many = |count: usize| {
            let values = |digit: &str| vec![digit; count].join(", ");
            let lists =
                format!("[{}]\nmax_bounces = [{}]\nradius_px = [{}]", values("1"), values("5"), values("1"));
            SweepConfig::parse(&GOOD.replace("[1]", &lists))
        };
        assert!(many(46).is_ok());
        let error = many(47).unwrap_err();
        assert!(error.contains("line 5") && error.contains("103823 run configurations"), "{error}");
        assert!(SweepConfig::parse(&GOOD.replace("[time]\nwidth = 64\nheight = 36\n", "")).is_err());
        let compared = |frames: &str| {
            let error =
                format!("[error]\nwidth = 64\nheight = 36\nframes = 8\ncompared_frames = {frames}\n\n[[");
            SweepConfig::parse(&GOOD.replacen("[[", &error, 1))
        };
        assert!(compared("[0, 7]").is_ok());
        let error = compared("[0, 8]").unwrap_err();
        assert!(error.contains("compared_frames") && error.contains('8'), "{error}");
        assert!(compared("[]").is_err());
    }
}
