//! Values of a configuration: numbers of light paths, radii, features.

use caustics_kernels::interface::balance::MAX_PATHS;
use caustics_kernels::interface::features::Features;
use caustics_scene::Scene;

use crate::named::Named;

/// Number of light paths of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paths {
    /// No light paths, for methods without them.
    None,
    /// This number.
    Count(u32),
    /// This number per pixel.
    PerPixel(f64),
    /// Number that a frame of this time has (ms). A search finds it, from one a pixel on.
    Time(f64),
    /// Number that serves the image best, by cost and noise of earlier frames.
    Auto,
}

impl Paths {
    /// Returns the maximum number of light paths of a frame of this size.
    pub fn count(&self, width: u32, height: u32) -> u32 {
        let pixels = f64::from(width) * f64::from(height);
        match *self {
            Paths::None => 0,
            Paths::Count(count) => count,
            Paths::PerPixel(paths) => (paths * pixels).round().max(1.0) as u32,
            Paths::Time(_) => pixels as u32,
            Paths::Auto => pixels as u32 * MAX_PATHS,
        }
    }
}

/// Permitted times of a frame (ms), up to ten minutes. A search renders about twenty frames.
const TIME_MS: std::ops::RangeInclusive<f64> = 1e-3..=6e5;

/// Text of a value that earlier frames determine.
pub const AUTO: &str = "auto";

/// Parses a number of light paths: `p0.5` per pixel, `n1024` per frame, `t33ms` by time, `auto`, or an empty text for none.
impl std::str::FromStr for Paths {
    type Err = String;
    fn from_str(text: &str) -> Result<Paths, String> {
        let number =
            |text: &str| text.parse::<f64>().ok().filter(|number| number.is_finite() && *number > 0.0);
        if text.is_empty() {
            Ok(Paths::None)
        } else if text == AUTO {
            Ok(Paths::Auto)
        } else if let Some(count) = text.strip_prefix('n') {
            let count = count.parse().ok().filter(|count| *count > 0);
            count.map(Paths::Count).ok_or_else(|| "it must be auto or a whole number, at least 1".into())
        } else if let Some(ms) = text.strip_prefix('t').and_then(|text| text.strip_suffix("ms")) {
            let ms = number(ms).filter(|ms| TIME_MS.contains(ms)).map(Paths::Time);
            ms.ok_or_else(|| format!("it must be {} to {} ms", TIME_MS.start(), TIME_MS.end()))
        } else {
            let paths = number(text.strip_prefix('p').unwrap_or(text)).filter(|paths| *paths <= 4096.0);
            paths.map(Paths::PerPixel).ok_or_else(|| "it must be more than 0, at most 4096".into())
        }
    }
}

impl std::fmt::Display for Paths {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Paths::None => Ok(()),
            Paths::Auto => formatter.write_str(AUTO),
            Paths::Count(count) => write!(formatter, "n{count}"),
            Paths::PerPixel(paths) => write!(formatter, "p{paths}"),
            Paths::Time(ms) => write!(formatter, "t{ms}ms"),
        }
    }
}

/// Radius of collection points relative to the disc of the pixel's footprint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Radius {
    /// This radius, relative to the disc.
    Px(f32),
    /// Radius 1, and up to 3 where the last frame had few photons.
    Auto,
}

impl Radius {
    /// Returns the radius of all discs (px); for `Auto` the minimum.
    pub fn px(self) -> f32 {
        if let Radius::Px(px) = self { px } else { 1.0 }
    }
}

impl std::str::FromStr for Radius {
    type Err = String;
    fn from_str(text: &str) -> Result<Radius, String> {
        if text == AUTO {
            return Ok(Radius::Auto);
        }
        let radius = text.parse().ok().filter(|radius: &f32| radius.is_finite() && *radius > 0.0);
        radius.map(Radius::Px).ok_or_else(|| "it must be auto or a positive number".into())
    }
}

impl std::fmt::Display for Radius {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Radius::Px(px) => write!(formatter, "{px}"),
            Radius::Auto => formatter.write_str(AUTO),
        }
    }
}

/// Choice of the features that are compiled into the kernels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeatureChoice {
    /// Features that the scene needs.
    Scene,
    /// All features.
    All,
}

impl FeatureChoice {
    /// Returns the features for a scene in its pose. Lobes up to this roughness are specular.
    pub fn features(self, scene: &Scene, specular_roughness: f32) -> Features {
        match self {
            FeatureChoice::Scene => scene.features(specular_roughness),
            FeatureChoice::All => Features::ALL,
        }
    }
}

impl Named for FeatureChoice {
    fn all() -> Vec<Self> {
        vec![FeatureChoice::Scene, FeatureChoice::All]
    }

    fn name(self) -> &'static str {
        match self {
            FeatureChoice::Scene => "scene",
            FeatureChoice::All => "all",
        }
    }

    fn description(self) -> &'static str {
        match self {
            FeatureChoice::Scene => "What the scene needs",
            FeatureChoice::All => "All of it",
        }
    }
}

/// Serde module of a value that is written as its text: `#[serde(with = "as_text")]`.
pub(super) mod as_text {
    use std::fmt::Display;
    use std::str::FromStr;

    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<T: Display, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(value)
    }

    pub fn deserialize<'de, T: FromStr<Err = String>, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<T, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}
