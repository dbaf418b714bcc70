//! Staging: adds a camera, a light and a floor that a file lacks.

use std::path::Path;

use serde::Deserialize;

use super::{CameraChoice, Edits, EnvironmentMap, Eye, LoadOptions, Recorded, Scene, SceneError, Viewpoint};

/// Condition for the default light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DefaultLight {
    /// If the scene has no light. Also if it is a single object: only its materials emit, it has no camera, and the user does not
    /// place the eye.
    #[default]
    Auto,
    /// In every scene.
    Always,
    /// In no scene: a scene without light is refused.
    Never,
}

/// Choices of the user besides the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Staging {
    /// Choice of the camera.
    pub camera: CameraChoice,
    /// Options of loading.
    pub load: LoadOptions,
    /// Edits of the scene. The edited nodes are loaded as grabbed, and a camera of the edits becomes the first.
    pub edits: Option<Edits>,
    /// Environment in place of the file's.
    pub environment: Option<EnvironmentMap>,
    /// Condition for the default light.
    pub default_light: DefaultLight,
    /// Aspect ratio of the images (width over height), by which a placed camera shows the whole scene.
    pub aspect: f64,
}

/// A scene that is ready to render.
#[derive(Clone, Debug)]
pub struct Staged {
    /// The scene.
    pub scene: Scene,
    /// Name of the camera.
    pub camera: String,
    /// Additions, one line each, for the user.
    pub notes: Vec<String>,
}

impl Staging {
    /// Loads a scene, adds missing parts, and applies the choices of the user.
    ///
    /// # Errors
    ///
    /// Errors of [`Scene::load`]; a missing light without a default light; a camera that does not exist or cannot be placed.
    pub fn load(&self, path: &Path) -> Result<Staged, SceneError> {
        let mut load = self.load.clone();
        load.grabbed.extend(self.edits.iter().flat_map(Edits::grabbed));
        let mut scene = Scene::load_with(path, &load)?;
        if let Some(environment) = &self.environment {
            scene.set_environment(environment.clone())?;
        }
        let mut notes = Vec::new();
        self.light(&mut scene, &path.display().to_string(), &mut notes)?;
        if let Some(edits) = &self.edits {
            scene.play(edits)?;
            scene.additions.insert("edits", edits.fingerprint());
            scene.begin_at(0.0)?;
        }
        let camera = self.camera(&mut scene, path, &mut notes)?;
        Ok(Staged { scene, camera, notes })
    }

    /// Adds the default light if its condition holds.
    fn light(&self, scene: &mut Scene, file: &str, notes: &mut Vec<String>) -> Result<(), SceneError> {
        match (scene.is_dark(), self.default_light) {
            (true, DefaultLight::Never) => return Err(SceneError::NoLight { file: file.into() }),
            (true, _) => {
                let lights = scene.add_default_light()?;
                notes.push(format!("no light in {file}: lit by {lights}; --no-default-light refuses this"));
            }
            (false, DefaultLight::Always) => {
                notes.push(format!("beside its own light: {}", scene.add_default_light()?));
            }
            // A single object whose parts glow, such as headlights.
            (false, DefaultLight::Auto)
                if scene.cameras.is_empty() && !self.places_eye() && scene.only_glows() =>
            {
                let lights = scene.add_default_light()?;
                notes.push(format!(
                    "no camera in {file}, and no light but what its materials emit: lit by {lights} too; --no-default-light, or a \
                     camera by --from, leaves it as it is, and --default-light keeps this light"
                ));
            }
            (false, _) => {}
        }
        Ok(())
    }

    /// Whether options or edits place the eye. An orbit does not: it goes round a single object.
    fn places_eye(&self) -> bool {
        let is_at = matches!(self.camera, CameraChoice::Placed(Viewpoint { eye: Some(Eye::At(_)), .. }));
        is_at || self.edits.as_ref().is_some_and(Edits::has_camera)
    }

    /// Returns the name of the camera; places the camera if the file does not have it.
    fn camera(&self, scene: &mut Scene, path: &Path, notes: &mut Vec<String>) -> Result<String, SceneError> {
        let edited = self.edits.as_ref().and_then(|edits| edits.camera);
        let (viewpoint, why) = match &self.camera {
            CameraChoice::First if scene.recorded.is_some() => return Ok(Recorded::NAME.into()),
            CameraChoice::First if let Some(camera) = edited => (camera.viewpoint(), "camera:".into()),
            CameraChoice::First if scene.cameras.is_empty() => {
                (Viewpoint::default(), format!("no camera in {}: seen by", path.display()))
            }
            CameraChoice::First => return Ok(scene.camera(None)?.name.clone()),
            CameraChoice::Named(name) => return Ok(scene.camera(Some(name))?.name.clone()),
            CameraChoice::Placed(viewpoint) => (*viewpoint, "camera:".into()),
        };
        let name = scene.place_camera(&viewpoint, self.aspect)?.name.clone();
        notes.push(format!("{why} {name}"));
        Ok(name)
    }
}
