//! A camera that goes from key to key.

use glam::DVec3;

use super::animation::Channel;

/// A camera that goes from key to key: eye, what it looks at and field of view on lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// Its index among the scene's cameras.
    pub camera: usize,
    /// Eye (m), what it looks at (m), and the vertical field of view (degrees, in x), with the same keys.
    pub channels: [Channel; 3],
}

impl Recorded {
    /// Name of the camera: the option that gives it.
    pub const NAME: &str = "--edits";

    /// Eye (m), what it looks at (m), and the vertical field of view (degrees), at a time (s).
    pub fn at(&self, time: f64) -> (DVec3, DVec3, f64) {
        let time = if time.is_nan() { 0.0 } else { time };
        let [from, look_at, field] = self.channels.each_ref().map(|channel| channel.at(time).truncate());
        (from, look_at, field.x)
    }

    /// Time of its last key (s).
    pub fn duration(&self) -> f64 {
        self.channels[0].times.last().copied().unwrap_or(0.0)
    }
}
