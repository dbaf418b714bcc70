//! Opens the scene of a command: with what its file lacks, and with the camera that is asked for.

use std::path::Path;

use caustics::scene::{SceneError, Staged, Staging};

use super::options::camera;
use crate::cli::{Usage, View};

/// The scene, and the name of its camera. Says what it got that its file does not have.
pub fn open(file: &Path, view: &View) -> anyhow::Result<Staged> {
    let aspect = f64::from(view.width) / f64::from(view.height);
    let (floor, default_light) = (view.floor, !view.no_default_light);
    let staging = Staging { camera: camera(view)?, default_light, floor, aspect };
    let staged = staging.load(file).map_err(|error| match error {
        SceneError::UnknownCamera { ref camera, .. } => Usage(format!("--camera {camera}: {error}")).into(),
        SceneError::Viewpoint { .. } => Usage(error.to_string()).into(),
        error => anyhow::Error::from(error),
    })?;
    for note in &staged.notes {
        tell!("{note}");
    }
    Ok(staged)
}
