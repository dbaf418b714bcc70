//! Opens the scene of a command: with what its file lacks, and with the camera that is asked for.

use std::path::Path;

use caustics::scene::{SceneError, Staged, Staging};

use super::options::{camera, default_light};
use crate::cli::{Usage, View};

/// The scene, and the name of its camera. Says what it got that its file does not have.
pub fn open(file: &Path, view: &View) -> anyhow::Result<Staged> {
    let aspect = f64::from(view.width) / f64::from(view.height);
    let (camera, default_light) = (camera(view)?, default_light(view));
    let staging = Staging { camera, default_light, floor: view.floor, aspect };
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
