//! The camera that follows the keyframes of edits.

use glam::DVec3;

use super::{CameraEdit, Keyframe};
use crate::animation::{Channel, Path};
use crate::recorded::Recorded;
use crate::viewpoint::{Position, Whole};
use crate::{Scene, SceneCamera, SceneError};

impl Scene {
    /// Adds a camera that follows the keyframes' cameras. Without any, removes it.
    pub(super) fn record(&mut self, keys: &[Keyframe]) -> Result<(), SceneError> {
        let keys: Vec<(f64, &CameraEdit)> =
            keys.iter().filter_map(|key| Some((key.time, key.camera.as_ref()?))).collect();
        if keys.is_empty() {
            self.recorded = None;
            return Ok(());
        }
        let mut channels = [Path::Translation; 3].map(Channel::linear);
        for (time, key) in keys {
            self.camera_at(&key.whole(), Recorded::NAME)?;
            let values = [key.from.into(), key.look_at.into(), DVec3::new(key.fov, 0.0, 0.0)];
            for (channel, value) in channels.iter_mut().zip(values) {
                channel.times.push(time);
                channel.values.push(value.extend(0.0));
            }
        }
        let known = self.cameras.iter().position(|camera| camera.name == Recorded::NAME);
        let recorded = Recorded { camera: known.unwrap_or(self.cameras.len()), channels };
        let camera = self.follow(&recorded, 0.0)?;
        if known.is_none() {
            self.cameras.push(camera);
        }
        self.additions.insert("origin", self.origin.to_string());
        self.recorded = Some(recorded);
        Ok(())
    }

    /// Returns the index of the camera that follows keyframes, and the camera at a time (s).
    pub(crate) fn recorded_camera(&self, time: f64) -> Result<Option<(usize, SceneCamera)>, SceneError> {
        let Some(recorded) = &self.recorded else { return Ok(None) };
        Ok(Some((recorded.camera, self.follow(recorded, time)?)))
    }

    fn follow(&self, recorded: &Recorded, time: f64) -> Result<SceneCamera, SceneError> {
        let (from, look_at, field) = recorded.at(time);
        self.camera_at(&Whole { from: Position(from), look_at: Position(look_at), field }, Recorded::NAME)
    }
}
