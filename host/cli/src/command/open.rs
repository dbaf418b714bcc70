//! Opens the scene of a command, with additions and the selected camera, and its session.

use super::pick::pick;
use caustics::render_config::RenderConfig;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::interface::NONE;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::light::Light;
use std::path::Path;

use caustics::scene::{CameraChoice, Edits, LoadOptions, Scene, SceneCamera, SceneError, Staged, Staging};

use super::options::{camera, default_light, environment};
use crate::cli::{Common, ImageOptions, Loading, Machine, Usage};

/// Opens the scene and selects its camera. Prints the additions that its file does not have.
pub fn open(file: &Path, options: &Common) -> anyhow::Result<Staged> {
    let Common { view, loading, .. } = options;
    open_edited(file, view, loading, options.edits.as_deref())
}

/// Opens the scene with the edits of a file.
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

/// Loads the edits of a file, which may place a camera unless an option does.
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

/// Returns the scene with these edits, and the name of its camera.
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

/// Warns of light that an image will lack.
pub fn warn(scene: &Scene, config: &RenderConfig) {
    for warning in &scene.warnings {
        message!("warning: {warning}");
    }
    let has_casters = scene.features(config.specular_roughness).has(Features::CASTERS);
    // A path that leaves the scene finds the environment.
    let has_no_size = |light: &Light| light.triangle == NONE && light.kind != Features::ENVIRONMENT.0;
    if !config.method.gathers && has_casters && scene.lights.iter().any(has_no_size) {
        message!(
            "warning: no path finds a light without a size: caustics of point, spot and directional lights are \
             missing; render --method progressive sees them"
        );
    }
}

/// A session and its description.
pub struct Opened {
    /// The session.
    pub session: Session,
    /// Runner of the session.
    pub choice: RunnerChoice,
    /// Name of the gather, or `none`.
    pub gather: &'static str,
    /// Reason for the choice of the runner.
    pub reason: String,
}

/// Opens a session with this configuration, on the runner of this name.
pub fn opened(
    config: &RenderConfig,
    runner: &str,
    machine: &Machine,
    scene: &Scene,
    camera: &SceneCamera,
    features: Features,
) -> anyhow::Result<Opened> {
    let method = config.method;
    let (choice, variant, reason) = pick(runner, machine, config.gather.filter(|_| method.chooses_gather))?;
    let config = RenderConfig { gather: Some(variant), ..config.clone() };
    let session = Session::new(&choice, scene, camera, &config, features)?;
    let gather = if method.chooses_gather { variant.name } else { "none" };
    Ok(Opened { session, choice, gather, reason })
}
