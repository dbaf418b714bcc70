//! The reference of each frame: many frames of `progressive` at that frame's pose, rendered once and kept on disk.
//!
//! Light paths and radii of a reference do not depend on the run configurations, so all configurations of a view share it.
//! Radii start as the disc of a pixel's footprint and shrink with the frames, to less than half of it in 256 frames.
//! Configurations with a smaller radius are not blurred more than their reference. All frames use one seed: where nothing
//! moves, the reference does not change at all.
//!
//! References may have a pixel filter of their own: against a box, errors of rays through pixel centres include aliasing.

use caustics::render_config::{Paths, Radius};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context;
use bytemuck::pod_collect_to_vec;
use glam::Vec3;

use super::identity::{self, pose};
use super::plan::MeasurementPlan;
use super::run_config::RunConfig;
use caustics::accumulation::{Accumulation, BATCHES};
use caustics::file::read_file;
use caustics::hash::digest;
use caustics::image_file::Channels;
use caustics::output::target::Target;
use caustics::output::{attributes, exr};
use caustics::render_config::RenderConfig;
use caustics::rendered_image::RenderedImage;
use caustics::scene::Scene;
use caustics::session::Session;
use caustics_kernels::interface::choice::{IndirectEnd, IndirectShare, Sampler};
use caustics_kernels::method::progressive::PROGRESSIVE;
use caustics_kernels::{denoiser, history};

/// Seed of all references; no run configuration may have it.
pub const SEED: u32 = 0x7265_6665;
/// Light paths a pixel in each frame of a reference. The frame's camera paths cost as much in any case.
const LIGHT_PATHS_PER_PIXEL: u32 = 4;

/// References of the frames of a plan.
#[derive(Debug)]
pub struct References<'a> {
    plan: &'a MeasurementPlan,
    run: &'a RunConfig,
    /// Scene, posed for one frame after another.
    scene: RefCell<Scene>,
    config: RenderConfig,
    frames: u32,
    folder: PathBuf,
    /// Identity of each frame's reference, once computed.
    identities: RefCell<BTreeMap<u32, String>>,
}

/// Outcome of [`References::keep`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// The file existed.
    Reused,
    /// It was rendered.
    Rendered,
    /// The file existed, but was damaged or another reference's, and was rendered anew.
    Replaced,
    /// The run was stopped before the reference was done.
    Stopped,
}

impl<'a> References<'a> {
    /// References of a scene as loaded, in a folder of their own below `cache`. They have the maximum bounces of the run
    /// configuration, and its runner renders them.
    pub fn new(
        plan: &'a MeasurementPlan,
        run: &'a RunConfig,
        scene: &Scene,
        frames: u32,
        cache: &Path,
    ) -> References<'a> {
        let pixels = plan.config.width * plan.config.height;
        let filter = plan.reference_pixel_filter;
        let config = RenderConfig {
            pixel_filter: filter.unwrap_or(plan.config.pixel_filter),
            texture_filter: filter
                .and_then(RenderConfig::texture_filter_of_means)
                .or(plan.config.texture_filter),
            method: &PROGRESSIVE,
            light_paths: Paths::Count(LIGHT_PATHS_PER_PIXEL * pixels),
            radius: Radius::Px(1.0),
            max_bounces: run.config.max_bounces,
            seed: SEED,
            history: &history::NONE,
            denoiser: &denoiser::NONE,
            indirect_share: Some(IndirectShare::None),
            indirect_end: Some(IndirectEnd::Path),
            sampler: Sampler::Sobol,
            batches: BATCHES,
            exposure: 0.0,
            ..plan.config.clone()
        };
        let view = identity::view(scene, &plan.camera, &config);
        let name = digest(&format!("{view}frames {frames} fps {}", plan.fps));
        let folder = cache.join("references").join(name);
        let (scene, identities) = (RefCell::new(scene.clone()), RefCell::default());
        References { plan, run, scene, config, frames, folder, identities }
    }

    /// Folder of the references.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// File of a frame's reference; all frames share it where nothing moves.
    pub fn path(&self, frame: u32) -> PathBuf {
        self.folder.join(format!("{:04}.exr", self.known_as(frame)))
    }

    /// Index of the frame under which a frame's reference is kept.
    fn known_as(&self, frame: u32) -> u32 {
        if self.plan.moment.is_none() { frame } else { 0 }
    }

    /// Renders the reference of a frame, unless it exists.
    ///
    /// # Errors
    /// If the scene cannot be posed or rendered, or the folder cannot be written.
    pub fn keep(&self, frame: u32, stopped: &dyn Fn() -> bool) -> anyhow::Result<Kept> {
        let identity = self.identity(frame)?;
        let path = self.path(frame);
        let was_there = path.exists();
        if was_there && self.read(&path, &identity).is_ok() {
            return Ok(Kept::Reused);
        }
        pose(&mut self.scene.borrow_mut(), self.plan.time_of(frame))?;
        let rendered = self.render(&self.scene.borrow(), &identity, stopped)?;
        let Some(bytes) = rendered else { return Ok(Kept::Stopped) };
        std::fs::create_dir_all(&self.folder)
            .with_context(|| format!("cannot create {}; set CAUSTICS_CACHE", self.folder.display()))?;
        Target::claim(&path, true)?.finish(&bytes)?;
        Ok(if was_there { Kept::Replaced } else { Kept::Rendered })
    }

    /// Loads the reference of a frame, which must have been kept.
    ///
    /// # Errors
    /// If the file is missing, damaged, or another reference's.
    pub fn load(&self, frame: u32) -> anyhow::Result<RenderedImage> {
        self.read(&self.path(frame), &self.identity(frame)?)
    }

    /// Text of everything that decides a frame's reference, except the runner, which changes its last digits only.
    fn identity(&self, frame: u32) -> anyhow::Result<String> {
        let known_as = self.known_as(frame);
        if let Some(known) = self.identities.borrow().get(&known_as) {
            return Ok(known.clone());
        }
        let mut scene = self.scene.borrow_mut();
        pose(&mut scene, self.plan.time_of(frame))?;
        let view = identity::view(&scene, &self.plan.camera, &self.config);
        let identity = format!("{view}frames {}", self.frames);
        self.identities.borrow_mut().insert(known_as, identity.clone());
        Ok(identity)
    }

    fn render(
        &self,
        scene: &Scene,
        identity: &str,
        stopped: &dyn Fn() -> bool,
    ) -> anyhow::Result<Option<Vec<u8>>> {
        let RunConfig { runner, .. } = self.run;
        let features = scene.features(self.config.specular_roughness);
        let camera = scene.camera(Some(&self.plan.camera))?;
        let mut session = Session::new(runner, scene, camera, &self.config, features)?;
        let mut sums = Accumulation::in_batches(self.config.batches_of_frames());
        for frame in 0..self.frames {
            if stopped() {
                return Ok(None);
            }
            session.frame(frame)?;
            sums.add(&session.image()?);
        }
        let attributes = BTreeMap::from([
            ("identity".to_string(), digest(identity)),
            ("what".into(), identity.trim().replace('\n', "; ")),
            ("device".into(), session.device()),
        ]);
        let variance = sums.variance().map(|variance| (variance, sums.frames()));
        Ok(Some(exr::encode(&sums.mean(), variance, &attributes)?))
    }

    /// Reads both layers of a file, if it is whole and has this identity.
    fn read(&self, path: &Path, identity: &str) -> anyhow::Result<RenderedImage> {
        let bytes = read_file(path).with_context(|| format!("cannot read {}", path.display()))?;
        anyhow::ensure!(attributes::is_whole(&bytes) == Some(true), "{} is damaged", path.display());
        let channels = Channels::decode(&bytes).map_err(anyhow::Error::msg)?;
        let size = (channels.width, channels.height);
        let expected = (self.config.width as usize, self.config.height as usize);
        let known = channels.attributes.get("identity").is_some_and(|found| *found == digest(identity));
        anyhow::ensure!(size == expected && known, "{} is another's reference", path.display());
        let layer = |name: &str| -> anyhow::Result<Vec<Vec3>> {
            let rgb = channels.layer(name);
            let rgb = rgb.with_context(|| format!("{} has no layer {name}", path.display()))?;
            let values = (0..size.0 * size.1).flat_map(|pixel| rgb.map(|channel| channel[pixel]));
            let values: Vec<f32> = values.collect();
            anyhow::ensure!(values.iter().all(|value| value.is_finite()), "{} is damaged", path.display());
            Ok(pod_collect_to_vec(&values))
        };
        let (path, caustics) = (layer("path")?, layer("caustics")?);
        Ok(RenderedImage { width: size.0, height: size.1, path, caustics, ..RenderedImage::default() })
    }
}
