//! Opens the scene of a command: with what its file lacks, and with the camera that is asked for.

use std::path::Path;

use caustics::scene::{CameraChoice, Edits, LoadOptions, SceneError, Staged, Staging};

use super::options::{camera, default_light, environment};
use crate::cli::{Common, ImageOptions, Loading, Usage};

/// The scene, and the name of its camera. Says what it got that its file does not have.
pub fn open(file: &Path, options: &Common) -> anyhow::Result<Staged> {
    let Common { view, loading, .. } = options;
    open_edited(file, view, loading, options.edits.as_deref())
}

/// The same, with the edits of a file.
pub fn open_edited(
    file: &Path,
    view: &ImageOptions,
    loading: &Loading,
    edited: Option<&Path>,
) -> anyhow::Result<Staged> {
    let edits = edited.map(|path| edits(path, view)).transpose()?;
    let staged = staged(file, view, loading, edits)?;
    for note in &staged.notes {
        message!("{note}");
    }
    Ok(staged)
}

/// The edits of a file, which may place a camera if no option does.
pub fn edits(path: &Path, view: &ImageOptions) -> anyhow::Result<Edits> {
    let edits = Edits::load(path)?;
    if edits.has_camera() && camera(view)? != CameraChoice::First {
        return Err(Usage(format!(
            "--edits {}: the file says where the camera is, and so does --camera, --from, --look-at or --fov; leave one out",
            path.display()
        ))
        .into());
    }
    Ok(edits)
}

/// The scene with these edits, and the name of its camera.
pub fn staged(
    file: &Path,
    view: &ImageOptions,
    loading: &Loading,
    edits: Option<Edits>,
) -> anyhow::Result<Staged> {
    let camera = camera(view)?;
    let aspect = f64::from(view.width) / f64::from(view.height);
    let load = LoadOptions { floor: view.floor, ..loading.options() };
    let (environment, default_light) = (environment(view)?, default_light(view));
    let staging = Staging { camera, load, edits, environment, default_light, aspect };
    staging.load(file).map_err(|error| match error {
        SceneError::UnknownCamera { ref camera, .. } => Usage(format!("--camera {camera}: {error}")).into(),
        SceneError::Viewpoint { .. } => Usage(error.to_string()).into(),
        error => anyhow::Error::from(error),
    })
}
