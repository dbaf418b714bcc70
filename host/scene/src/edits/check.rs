//! Checks of edits: ranges of values, order of times.

use std::collections::BTreeSet;

use super::{CameraEdit, Edits, EditsError, NodeEdit};
use crate::viewpoint::FIELDS;

/// Largest magnitude of a number: the product of two nodes' values stays finite.
const LARGEST: f64 = 1e30;
/// Latest time of a key (s), equal to the limit of animations.
const LATEST: f64 = 1e9;

impl Edits {
    /// Refuses values that no scene can show.
    ///
    /// # Errors
    ///
    /// The first wrong value, with its path.
    pub fn check(&self) -> Result<(), EditsError> {
        check_camera("camera", self.camera.as_ref())?;
        check_nodes("nodes", &self.nodes)?;
        let mut last = None;
        for (id, key) in self.keys.iter().enumerate() {
            let path = format!("keys[{id}]");
            let what = match key.time {
                time if !(0.0..=LATEST).contains(&time) => {
                    "has a time that is negative, beyond 1e9 s or not a number"
                }
                time if last.is_some_and(|last| last >= time) => {
                    "has a time that is not after that of the key before"
                }
                _ => "",
            };
            if !what.is_empty() {
                return Err(EditsError::Value { path, what });
            }
            last = Some(key.time);
            check_camera(&format!("{path}.camera"), key.camera.as_ref())?;
            check_nodes(&format!("{path}.nodes"), &key.nodes)?;
        }
        Ok(())
    }
}

fn is_usable(values: &[f64]) -> bool {
    values.iter().all(|value| value.abs() <= LARGEST)
}

fn check_camera(path: &str, camera: Option<&CameraEdit>) -> Result<(), EditsError> {
    let Some(CameraEdit { from, look_at, fov }) = camera else { return Ok(()) };
    let what = match () {
        () if !is_usable(from) || !is_usable(look_at) => "has a number that is not finite or beyond 1e30",
        () if !FIELDS.contains(fov) => "has a fov that is not 0.1 to 170 degrees",
        () if from == look_at => "looks at where it is",
        () => return Ok(()),
    };
    Err(EditsError::Value { path: path.into(), what })
}

fn check_nodes(path: &str, nodes: &[NodeEdit]) -> Result<(), EditsError> {
    let mut seen = BTreeSet::new();
    for (id, edit) in nodes.iter().enumerate() {
        let NodeEdit { node, translation, rotation, scale, .. } = edit;
        let parts = [
            translation.as_ref().map(|t| &t[..]),
            rotation.as_ref().map(|r| &r[..]),
            scale.as_ref().map(|s| &s[..]),
        ];
        let length = rotation.map(|rotation| rotation.iter().map(|x| x * x).sum::<f64>().sqrt());
        let what = match () {
            () if !parts.into_iter().flatten().all(is_usable) => {
                "has a number that is not finite or beyond 1e30"
            }
            () if length.is_some_and(|length| length <= 1e-6) => "has a rotation of no length",
            () if u32::try_from(*node).is_err() => "has an index that no node has",
            () if !seen.insert(*node) => "is of a node that another one is of, too",
            () => continue,
        };
        return Err(EditsError::Value { path: format!("{path}[{id}]"), what });
    }
    Ok(())
}
