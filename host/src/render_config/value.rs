//! Values of a configuration: numbers of light paths, radii, kernel code.

use caustics_kernels::interface::balance::MAX_PATHS;
use caustics_kernels::interface::features::Features;
use caustics_scene::Scene;

use crate::named::Named;

/// Light paths of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paths {
    /// The method shoots none.
    None,
    /// This many.
    Count(u32),
    /// This many a pixel.
    PerPixel(f64),
    /// As many as a frame of this time has (ms); they are searched for, from one a pixel on.
    Time(f64),
    /// As many as serve the image best, by what earlier frames cost and left to noise.
    Auto,
}

impl Paths {
    /// How many in a frame of this size, at most.
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

/// Times that a frame may be asked to take (ms): up to ten minutes, of which a search renders some twenty frames.
const TIME_MS: std::ops::RangeInclusive<f64> = 1e-3..=6e5;

/// Value that earlier frames decide.
pub const AUTO: &str = "auto";

/// The light paths of a text: `p0.5` a pixel, `n1024` a frame, `t33ms` as many as take so long, `auto`, or none at all.
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
    /// This.
    Px(f32),
    /// 1, and up to three times as wide where the last frame's photons were few.
    Auto,
}

impl Radius {
    /// Radius of every disc (px); where it is `Auto`, the smallest.
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

/// Kernel code that is compiled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeatureChoice {
    /// What the scene needs.
    Scene,
    /// All of it.
    All,
}

impl FeatureChoice {
    /// Kernel code for a scene as it is posed, where lobes of at most this roughness are specular.
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

/// With serde such a value is its text: `#[serde(with = "as_text")]`.
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
