//! Opens the scene of a command: with what its file lacks, and with the camera that is asked for.

use std::path::Path;

use caustics::scene::{CameraChoice, Edits, LoadOptions, SceneError, Staged, Staging};

use super::options::{camera, default_light, environment};
use crate::cli::{Common, Usage};

/// The scene, and the name of its camera. Says what it got that its file does not have.
pub fn open(file: &Path, options: &Common) -> anyhow::Result<Staged> {
    let Common { view, loading, .. } = options;
    let camera = camera(view)?;
    let edits = options.edits.as_deref().map(Edits::load).transpose()?;
    if let (Some(path), Some(edits)) = (&options.edits, &edits)
        && edits.has_camera()
        && camera != CameraChoice::First
    {
        return Err(Usage(format!(
            "--edits {}: the file says where the camera is, and so does --camera, --from, --look-at or --fov; leave one out",
            path.display()
        ))
        .into());
    }
    let aspect = f64::from(view.width) / f64::from(view.height);
    let load = LoadOptions { floor: view.floor, ..loading.options() };
    let (environment, default_light) = (environment(view)?, default_light(view));
    let staging = Staging { camera, load, edits, environment, default_light, aspect };
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
