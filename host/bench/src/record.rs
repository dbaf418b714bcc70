//! A frame of a run configuration, with every measure of it.

use std::collections::BTreeMap;

/// A frame of a run configuration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameRecord {
    /// Index of the frame.
    pub frame: u32,
    /// Name of the run configuration.
    pub run: String,
    /// Measures by name, with the unit at the end of the name; ratios, FLIP and relative errors have no unit.
    pub values: BTreeMap<String, f64>,
}

impl FrameRecord {
    /// Returns a measure.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.values.get(name).copied()
    }

    /// Sets a measure, if there is one.
    pub fn set(&mut self, name: &str, value: Option<f64>) {
        if let Some(value) = value {
            self.values.insert(name.to_string(), value);
        }
    }

    /// Names and times of the passes (ms).
    pub fn passes<'a>(&'a self) -> impl Iterator<Item = (&'a str, f64)> {
        let pass = |name: &'a str| name.strip_prefix("pass.")?.strip_suffix("_ms");
        self.values.iter().filter_map(move |(name, value)| Some((pass(name)?, *value)))
    }
}
