//! A camera that follows keyframes.

use glam::DVec3;

use super::animation::Channel;

/// A camera that follows keyframes; eye, target and field of view are interpolated linearly.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// Index among the scene's cameras.
    pub camera: usize,
    /// Eye (m), target (m) and vertical field of view (degrees, in x), with equal key times.
    pub channels: [Channel; 3],
}

impl Recorded {
    /// Name of the camera: the option that sets it.
    pub const NAME: &str = "--edits";

    /// Eye (m), target (m) and vertical field of view (degrees) at a time (s).
    pub fn at(&self, time: f64) -> (DVec3, DVec3, f64) {
        let time = if time.is_nan() { 0.0 } else { time };
        let [from, look_at, field] = self.channels.each_ref().map(|channel| channel.at(time).truncate());
        (from, look_at, field.x)
    }

    /// Time of the last key (s).
    pub fn duration(&self) -> f64 {
        self.channels[0].times.last().copied().unwrap_or(0.0)
    }
}
