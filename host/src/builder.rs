//! Builder of sessions.

use caustics_kernels::gather::variant::Variant;
use caustics_kernels::interface::features::Features;
use caustics_kernels::method::Method;

use crate::render_config::RenderConfig;
use crate::session::{RunnerChoice, Session, SessionError};
use caustics_scene::Scene;

/// Builder of a [`Session`]. Its defaults are those of the command line, with the runner on the CPU.
///
/// ```no_run
/// # fn main() -> anyhow::Result<()> {
/// use caustics::{Paths, RenderConfig, Scene, Session, method};
///
/// let scene = Scene::load(std::path::Path::new("scenes/mirror-room/scene.gltf"))?;
/// // Set the size of the image and the number of light paths.
/// let config = RenderConfig { width: 480, height: 270, light_paths: Paths::Count(1 << 18), ..RenderConfig::default() };
/// // Open the runner and allocate the buffers.
/// let mut session = Session::builder(&scene).config(config).method(&method::PROGRESSIVE).build()?;
/// // Render the first frame.
/// session.frame(0)?;
/// let image = session.image()?;
/// assert_eq!(image.beauty().len(), 480 * 270);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
#[must_use = "a session opens when it is built"]
pub struct SessionBuilder<'a> {
    scene: &'a Scene,
    camera: Option<String>,
    runner: RunnerChoice,
    config: RenderConfig,
    method: Option<&'static Method>,
    gather: Option<&'static Variant>,
    features: Option<Features>,
}

impl Session {
    /// Starts a builder for this scene. Defaults: method `basic`, all cores of the CPU, the scene's first camera.
    pub fn builder(scene: &Scene) -> SessionBuilder<'_> {
        SessionBuilder {
            scene,
            camera: None,
            runner: RunnerChoice::Cpu { threads: 0 },
            config: RenderConfig::default(),
            method: None,
            gather: None,
            features: None,
        }
    }
}

impl SessionBuilder<'_> {
    /// Selects the camera of this name instead of the first.
    pub fn camera(self, name: &str) -> Self {
        Self { camera: Some(name.into()), ..self }
    }

    /// Selects the runner instead of the CPU.
    pub fn runner(self, runner: RunnerChoice) -> Self {
        Self { runner, ..self }
    }

    /// Sets the configuration: size, method, light paths, history, denoiser and more.
    pub fn config(self, config: RenderConfig) -> Self {
        Self { config, ..self }
    }

    /// Selects this method instead of the configuration's.
    pub fn method(self, method: &'static Method) -> Self {
        Self { method: Some(method), ..self }
    }

    /// Selects this gather instead of the runner's default. All gathers give the same image.
    pub fn gather(self, gather: &'static Variant) -> Self {
        Self { gather: Some(gather), ..self }
    }

    /// Selects the code that is compiled into the kernels. The default is the code that the scene needs; without some of it
    /// the image is wrong. `Features::LEDGER` in addition to `Scene::features` fills [`Session::energy`].
    pub fn features(self, features: Features) -> Self {
        Self { features: Some(features), ..self }
    }

    /// Opens the runner and allocates all buffers.
    ///
    /// # Errors
    ///
    /// - If the scene has no such camera, or there is no suitable Vulkan device.
    /// - If the gather needs ray queries and the runner has none.
    /// - If a frame does not fit into memory.
    pub fn build(self) -> Result<Session, SessionError> {
        let camera = self.scene.camera(self.camera.as_deref())?;
        let method = self.method.unwrap_or(self.config.method);
        let config = RenderConfig { method, gather: self.gather.or(self.config.gather), ..self.config };
        let features = self.features.unwrap_or_else(|| config.features(self.scene));
        Session::new(&self.runner, self.scene, camera, &config, features)
    }
}
