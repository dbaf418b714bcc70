//! A camera that goes from key to key.

use glam::DVec3;

use super::{CameraEdit, Key};
use crate::scene::animation::{Channel, Path};
use crate::scene::viewpoint::{Place, Whole};
use crate::scene::{Scene, SceneCamera, SceneError};

/// A camera that goes from key to key: eye, what it looks at and field of view on lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// Its index among the scene's cameras.
    camera: usize,
    /// Eye (m), what it looks at (m), and the vertical field of view (degrees, in x).
    channels: [Channel; 3],
}

impl Recorded {
    /// Name of the camera: the option that gives it.
    pub const NAME: &str = "--edits";

    /// Where it is at a time (s).
    fn at(&self, time: f64) -> Whole {
        let [from, look_at, field] = self.channels.each_ref().map(|channel| channel.at(time));
        Whole { from: Place(from.truncate()), look_at: Place(look_at.truncate()), field: field.x }
    }

    /// Time of its last key (s).
    pub(in crate::scene) fn duration(&self) -> f64 {
        self.channels[0].times.last().copied().unwrap_or(0.0)
    }

    /// Bytes that tell it apart.
    pub(in crate::scene) fn bytes(&self) -> impl Iterator<Item = u8> + '_ {
        self.channels.iter().flat_map(Channel::bytes)
    }
}

impl Scene {
    /// Has a camera follow what keys say of one, if they do; else none.
    pub(super) fn record(&mut self, keys: &[Key]) -> Result<(), SceneError> {
        let keys: Vec<(f64, &CameraEdit)> =
            keys.iter().filter_map(|key| Some((key.time, key.camera.as_ref()?))).collect();
        if keys.is_empty() {
            self.recorded = None;
            return Ok(());
        }
        let mut channels = [Path::Translation; 3].map(Channel::linear);
        for (time, key) in keys {
            self.camera_at(&key.whole(), "")?;
            let values = [key.from.into(), key.look_at.into(), DVec3::new(key.fov, 0.0, 0.0)];
            for (channel, value) in channels.iter_mut().zip(values) {
                channel.times.push(time);
                channel.values.push(value.extend(0.0));
            }
        }
        let known = self.cameras.iter().position(|camera| camera.name == Recorded::NAME);
        let recorded = Recorded { camera: known.unwrap_or(self.cameras.len()), channels };
        let camera = self.camera_at(&recorded.at(0.0), Recorded::NAME)?;
        if known.is_none() {
            self.cameras.push(camera);
        }
        self.additions.insert("origin", self.origin.to_string());
        self.recorded = Some(recorded);
        Ok(())
    }

    /// The camera that follows keys, at a time (s), and its index.
    pub(in crate::scene) fn recorded_camera(
        &self,
        time: f64,
    ) -> Result<Option<(usize, SceneCamera)>, SceneError> {
        let Some(recorded) = &self.recorded else { return Ok(None) };
        let time = if time.is_nan() { 0.0 } else { time };
        Ok(Some((recorded.camera, self.camera_at(&recorded.at(time), Recorded::NAME)?)))
    }
}
