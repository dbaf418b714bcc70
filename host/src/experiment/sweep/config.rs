//! The file of a sweep: TOML. An error names the line and shows the key.

use caustics_kernels::gather::variant::Variant;
use serde::Deserialize;
use toml::Spanned;

use super::value::{Bounces, ByName, Count, NonEmpty, PathsPerPixel, Positive, Runner, Side};
use crate::experiment::cell::Code;
use crate::experiment::reference::SEED;
use caustics_kernels::declare::TextureFilter;
use caustics_kernels::denoiser::Denoiser;
use caustics_kernels::history::History;
use caustics_kernels::method::Method;

/// Most cells of a file, counted before any is left out.
const MAX_CELLS: u64 = 1_000_000;

/// The whole file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Frames a second of scenes that move.
    #[serde(default = "fps")]
    pub fps: Positive,
    /// First frame of scenes that move.
    #[serde(default)]
    pub first_frame: u32,
    /// First seed.
    #[serde(default)]
    pub seed: u32,
    /// Exposure of the display that FLIP looks at, and of the PNGs (stops).
    #[serde(default)]
    pub exposure: f32,
    /// Which level of its textures the camera sees, in all cells and the references alike.
    #[serde(default = "cone")]
    pub texture_filter: ByName<TextureFilter>,
    /// How times are measured, if they are.
    pub time: Option<TimeTable>,
    /// How errors are measured, if they are.
    pub error: Option<ErrorTable>,
    /// The cells.
    pub matrix: Vec<Spanned<MatrixTable>>,
}

/// `[time]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeTable {
    /// Image width (px).
    pub width: Side,
    /// Image height (px).
    pub height: Side,
    /// Frames that are timed.
    #[serde(default = "sixteen")]
    pub frames: Count,
    /// Frames before them that are not.
    #[serde(default = "two")]
    pub warm_up: u32,
}

/// `[error]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorTable {
    /// Image width (px).
    pub width: Side,
    /// Image height (px).
    pub height: Side,
    /// Independent runs of each cell.
    #[serde(default = "four")]
    pub seeds: Count,
    /// Frames of the progressive reference.
    #[serde(default = "many")]
    pub reference_frames: Count,
    /// Frames of scenes that move, each with a reference; of still ones, frames of which a history's last is measured.
    #[serde(default = "sixteen")]
    pub frames: Count,
}

/// `[[matrix]]`: lists, of which all combinations are cells.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MatrixTable {
    /// Files or names.
    pub scene: NonEmpty<String>,
    /// Name of the camera; the first where there is none.
    pub camera: Option<String>,
    /// Methods.
    pub method: NonEmpty<ByName<&'static Method>>,
    /// Gathers; none: the runner's usual one.
    #[serde(default)]
    pub gather: Vec<ByName<&'static Variant>>,
    /// Histories.
    #[serde(default = "none")]
    pub history: NonEmpty<ByName<&'static History>>,
    /// Filters.
    #[serde(default = "none")]
    pub denoiser: NonEmpty<ByName<&'static Denoiser>>,
    /// Light paths of a frame as it is timed, else as its error is measured.
    pub light_paths: Option<NonEmpty<Count>>,
    /// Light paths a pixel instead.
    pub paths_per_pixel: Option<NonEmpty<PathsPerPixel>>,
    /// As many light paths as a frame of this time has instead (ms).
    pub equal_time_ms: Option<Positive>,
    /// Widths and heights of the pictures that are timed; none: that of `[time]`.
    #[serde(default)]
    pub size: Vec<(Side, Side)>,
    /// Radii of collection points relative to the disc of a pixel's footprint.
    #[serde(default = "one")]
    pub radius_px: NonEmpty<Positive>,
    /// Largest numbers of scattering vertices.
    #[serde(default = "usual_bounces")]
    pub max_bounces: NonEmpty<Bounces>,
    /// Runners.
    #[serde(default = "auto")]
    pub runner: NonEmpty<ByName<Runner>>,
    /// Kernel code.
    #[serde(default = "scene_code")]
    pub features: NonEmpty<ByName<Code>>,
}

impl Config {
    /// Reads the text of a file.
    pub fn parse(text: &str) -> Result<Config, String> {
        let config: Config =
            toml::from_str(text).map_err(|error| error.to_string().trim_end().to_string())?;
        config.check(text)?;
        Ok(config)
    }

    fn check(&self, text: &str) -> Result<(), String> {
        if self.time.is_none() && self.error.is_none() {
            return Err("there is nothing to measure: give a table [time], [error], or both".into());
        }
        if !(-64.0..=64.0).contains(&self.exposure) {
            return Err(format!("exposure = {}: give -64 to 64 stops", self.exposure));
        }
        let seeds = self.error.as_ref().map_or(1, |error| error.seeds.0);
        let last = self.seed.checked_add(seeds - 1);
        if last.is_none_or(|last| (self.seed..=last).contains(&SEED)) {
            return Err(format!("seed = {}: references have the seed {SEED}; give another", self.seed));
        }
        let mut count = 0_u64;
        for matrix in &self.matrix {
            let start = matrix.span().start.min(text.len());
            let line = 1 + text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count();
            let matrix = matrix.get_ref();
            count = count.saturating_add(matrix.count());
            if count > MAX_CELLS {
                return Err(format!(
                    "line {line}, [[matrix]]: its lists make {count} cells with those before it, and at most {MAX_CELLS} \
                     are measured; share them out among files"
                ));
            }
            let given = [
                matrix.light_paths.is_some(),
                matrix.paths_per_pixel.is_some(),
                matrix.equal_time_ms.is_some(),
            ];
            if given.iter().filter(|given| **given).count() != 1 {
                let keys = "light_paths, paths_per_pixel and equal_time_ms";
                return Err(format!("line {line}, [[matrix]]: give one of {keys}"));
            }
            if !matrix.size.is_empty() && self.time.is_none() {
                return Err(format!("line {line}, [[matrix]]: size needs a table [time]"));
            }
            if matrix.equal_time_ms.is_some() && self.time.is_none() {
                return Err(format!("line {line}, [[matrix]]: equal_time_ms needs a table [time]"));
            }
        }
        Ok(())
    }
}

impl MatrixTable {
    /// Combinations of its lists.
    fn count(&self) -> u64 {
        let paths = |length: Option<usize>| length.unwrap_or(1);
        let lengths = [
            self.scene.0.len(),
            self.method.0.len(),
            self.gather.len().max(1),
            self.history.0.len(),
            self.denoiser.0.len(),
            paths(self.light_paths.as_ref().map(|paths| paths.0.len())),
            paths(self.paths_per_pixel.as_ref().map(|paths| paths.0.len())),
            self.size.len().max(1),
            self.radius_px.0.len(),
            self.max_bounces.0.len(),
            self.runner.0.len(),
            self.features.0.len(),
        ];
        lengths.into_iter().fold(1, |count: u64, length| count.saturating_mul(length as u64))
    }
}

fn fps() -> Positive {
    Positive(24.0)
}

fn cone() -> ByName<TextureFilter> {
    ByName(TextureFilter::Cone)
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

fn none<T: super::value::Known>() -> NonEmpty<ByName<T>> {
    NonEmpty::of(ByName::new("none"))
}

fn one() -> NonEmpty<Positive> {
    NonEmpty::of(Some(Positive(1.0)))
}

fn usual_bounces() -> NonEmpty<Bounces> {
    NonEmpty::of(Some(Bounces(5)))
}

fn auto() -> NonEmpty<ByName<Runner>> {
    NonEmpty::of(ByName::new("auto"))
}

fn scene_code() -> NonEmpty<ByName<Code>> {
    NonEmpty::of(ByName::new("scene"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "[time]\nwidth = 64\nheight = 36\n\n[[matrix]]\nscene = [\"ring\"]\nmethod = [\"basic\"]\n\
                        paths_per_pixel = [1]\n";

    #[test]
    fn what_is_not_said_has_a_default() {
        let config = Config::parse(GOOD).unwrap();
        let matrix = config.matrix[0].get_ref();
        assert_eq!((config.fps.0, config.time.unwrap().frames.0), (24.0, 16));
        assert_eq!(config.texture_filter.0, TextureFilter::Cone);
        assert_eq!(matrix.history.0[0].0.name, "none");
        assert_eq!((matrix.max_bounces.0[0].0, matrix.radius_px.0[0].0), (5, 1.0));
        assert_eq!(matrix.runner.0[0].0, Runner("auto"));
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
            ("[1]", "[1]\ngather = [\"sieve\"]", "line 9", "photons-grid"),
        ] {
            assert!(GOOD.contains(from));
            let error = Config::parse(&GOOD.replacen(from, to, 1)).unwrap_err();
            assert!(error.contains(line) && error.contains(named), "{to}: {error}");
        }
        let many = |count: usize| {
            let values = |digit: &str| vec![digit; count].join(", ");
            let lists =
                format!("[{}]\nmax_bounces = [{}]\nradius_px = [{}]", values("1"), values("5"), values("1"));
            Config::parse(&GOOD.replace("[1]", &lists))
        };
        assert!(many(100).is_ok());
        let error = many(101).unwrap_err();
        assert!(error.contains("line 5") && error.contains("1030301 cells"), "{error}");
        assert!(Config::parse(&GOOD.replace("[time]\nwidth = 64\nheight = 36\n", "")).is_err());
    }
}
