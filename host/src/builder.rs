//! A session by what differs from the usual.

use caustics_kernels::gather::variant::Variant;
use caustics_kernels::interface::features::Features;
use caustics_kernels::method::Method;

use crate::render_config::RenderConfig;
use crate::session::{RunnerChoice, Session, SessionError};
use caustics_scene::Scene;

/// Describes a [`Session`]: what is not said is as on the command line, on the CPU.
///
/// ```no_run
/// # fn main() -> anyhow::Result<()> {
/// use caustics::{Paths, RenderConfig, Scene, Session, method};
///
/// let scene = Scene::load(std::path::Path::new("scenes/mirror-room/scene.gltf"))?;
/// let config = RenderConfig { width: 480, height: 270, light_paths: Paths::Count(1 << 18), ..RenderConfig::default() };
/// let mut session = Session::builder(&scene).config(config).method(&method::PROGRESSIVE).build()?;
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
    /// Starts to describe a session that renders this scene: method `basic`, all cores of the CPU, the scene's first camera.
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
    /// Looks through the camera of this name instead of the first.
    pub fn camera(self, name: &str) -> Self {
        Self { camera: Some(name.into()), ..self }
    }

    /// Runs the kernels there instead of on the CPU.
    pub fn runner(self, runner: RunnerChoice) -> Self {
        Self { runner, ..self }
    }

    /// Renders with this configuration: size, method, light paths, history, denoiser and more.
    pub fn config(self, config: RenderConfig) -> Self {
        Self { config, ..self }
    }

    /// Renders by this method instead of the configuration's.
    pub fn method(self, method: &'static Method) -> Self {
        Self { method: Some(method), ..self }
    }

    /// Brings photons and collection points together in this way instead of the runner's usual one; the image is the same.
    pub fn gather(self, gather: &'static Variant) -> Self {
        Self { gather: Some(gather), ..self }
    }

    /// Compiles in this kernel code instead of what the scene needs. Code that the scene needs and that is left out makes
    /// the image wrong; `Features::LEDGER` in addition to `Scene::features` fills [`Session::energy`].
    pub fn features(self, features: Features) -> Self {
        Self { features: Some(features), ..self }
    }

    /// Opens the runner and allocates all buffers.
    ///
    /// # Errors
    ///
    /// If the scene has no such camera, no suitable Vulkan device is there, the gather needs ray queries that the runner
    /// does not have, or a frame does not fit into memory.
    pub fn build(self) -> Result<Session, SessionError> {
        let camera = self.scene.camera(self.camera.as_deref())?;
        let method = self.method.unwrap_or(self.config.method);
        let config = RenderConfig { method, gather: self.gather.or(self.config.gather), ..self.config };
        let features = self.features.unwrap_or_else(|| config.features(self.scene));
        Session::new(&self.runner, self.scene, camera, &config, features)
    }
}
