//! What a scene gets that its file does not have: a camera, a light, a floor.

use std::path::Path;

use serde::Deserialize;

use super::{CameraChoice, Edits, EnvironmentMap, Eye, LoadOptions, Recorded, Scene, SceneError, Viewpoint};

/// When a scene gets the default light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DefaultLight {
    /// Where it has none; or where no other light than what its materials emit, no camera, and nobody says where the eye stands:
    /// a thing rather than a scene.
    #[default]
    Auto,
    /// Whatever it has.
    Always,
    /// Not at all: one without any light is refused.
    Never,
}

/// What a person wants beside what a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Staging {
    /// The camera.
    pub camera: CameraChoice,
    /// How the file is read.
    pub load: LoadOptions,
    /// What is changed of it. The nodes are grabbed, and where they say where the camera is that is the first.
    pub edits: Option<Edits>,
    /// Light from all around, in place of the file's.
    pub environment: Option<EnvironmentMap>,
    /// When it gets the default light.
    pub default_light: DefaultLight,
    /// Width over height of the images; a camera that is placed has all in view then.
    pub aspect: f64,
}

/// A scene that can be rendered.
#[derive(Clone, Debug)]
pub struct Staged {
    /// The scene.
    pub scene: Scene,
    /// Name of the camera.
    pub camera: String,
    /// What it got, for people: a line each.
    pub notes: Vec<String>,
}

impl Staging {
    /// Loads a scene and gives it what it lacks and what is asked for.
    ///
    /// # Errors
    ///
    /// Those of [`Scene::load`]; no light where no default is wanted; a camera that is not there, or cannot be placed.
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
            scene.begin()?;
        }
        let camera = self.camera(&mut scene, path, &mut notes)?;
        Ok(Staged { scene, camera, notes })
    }

    /// Adds the default light where it is wanted.
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
            // A thing rather than a scene, whose eyes or headlights glow.
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

    /// Whether options or edits say where the eye stands. An orbit goes round a thing.
    fn places_eye(&self) -> bool {
        let is_at = matches!(self.camera, CameraChoice::Placed(Viewpoint { eye: Some(Eye::At(_)), .. }));
        is_at || self.edits.as_ref().is_some_and(Edits::has_camera)
    }

    /// Name of the camera; places it where it is none of the file.
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
