//! A configuration that converges: the frames of `render`, summed.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use caustics::accumulation::{Accumulation, BATCHES};
use caustics::energy::EnergyLedger;
use caustics::render_config::RenderConfig;
use caustics::runner::RunError;
use caustics::scene::{Scene, SceneCamera};
use caustics::session::SessionError;
use caustics_bench::run_config::RunConfig;
use caustics_kernels::interface::features::Features;

use super::look::{DisplayedImage, Layer};
use super::share::Share;
use crate::cli::{ImageOptions, Machine};
use crate::command::open::{Opened, opened};
use crate::command::options;
use crate::command::report::RunReport;

/// Reciprocal of the maximum share of time for estimating the error.
const ESTIMATES: u32 = 16;

/// Configuration of a session.
#[derive(Clone, Debug)]
pub struct JobConfiguration {
    /// Settings of the frames.
    pub run_config: RunConfig,
    /// Size of its frames (px).
    pub size: [u32; 2],
    /// Whether its frames are averaged.
    pub averages: bool,
    /// Kernel code that is compiled in.
    pub features: Features,
}

impl JobConfiguration {
    /// Text of the whole configuration.
    pub fn key(&self) -> String {
        let JobConfiguration { run_config, size, averages, features } = self;
        format!("{} {size:?} {averages} {features:?}", run_config.key())
    }

    /// Returns the settings of its frames, the same as in `render`.
    pub fn config(&self, view: &ImageOptions) -> anyhow::Result<RenderConfig> {
        let [width, height] = self.size;
        // A single frame goes through the centres of its pixels.
        let frames = if self.averages { u32::MAX } else { 1 };
        let view = ImageOptions { width, height, ..view.clone() };
        let config = options::config(&view, &self.run_config.config, frames)?.with_defaults_of_method();
        let batches = if self.averages { BATCHES } else { config.batches };
        Ok(RenderConfig { batches, ..config })
    }
}

/// A session and the sum of its frames.
pub struct RenderJob {
    /// Key of its configuration.
    pub key: String,
    /// Its configuration.
    pub configuration: JobConfiguration,
    /// Its settings.
    pub config: RenderConfig,
    /// Session with its runner.
    pub opened: Opened,
    /// Its frames so far.
    pub sums: Accumulation,
    /// Times and counters of its frames.
    pub report: RunReport,
    /// Estimated relative mean square error of the mean, as last computed.
    pub error: f64,
    estimates: Share,
    /// Number of frames rendered since the start.
    frames: u32,
}

impl RenderJob {
    /// Opens a session at the scene's pose.
    pub fn open(
        configuration: JobConfiguration,
        machine: &Machine,
        view: &ImageOptions,
        scene: &Scene,
        camera: &SceneCamera,
    ) -> anyhow::Result<RenderJob> {
        let config = configuration.config(view)?;
        let JobConfiguration { run_config, features, .. } = &configuration;
        let opened = opened(&config, run_config.asked_runner, machine, scene, camera, *features)?;
        let sums = Accumulation::in_batches(config.batches_of_frames());
        let (report, error) = (RunReport::default(), f64::INFINITY);
        let estimates = Share::new(ESTIMATES, Duration::ZERO);
        Ok(RenderJob {
            key: configuration.key(),
            configuration,
            config,
            opened,
            sums,
            report,
            error,
            estimates,
            frames: 0,
        })
    }

    /// Lets a flag stop its frames.
    pub fn stop_by(&mut self, flag: &Arc<AtomicBool>) {
        self.opened.session.stop_by(flag);
    }

    /// Restarts at the scene's pose.
    pub fn restart(&mut self, scene: &Scene, camera: &SceneCamera) -> Result<(), SessionError> {
        self.opened.session.pose(scene, camera)?;
        self.opened.session.restart()?;
        self.sums = Accumulation::in_batches(self.config.batches_of_frames());
        self.report = RunReport::default();
        self.error = f64::INFINITY;
        self.frames = 0;
        Ok(())
    }

    /// Renders the next frame. Returns its time, or none if it was stopped.
    pub fn frame(&mut self) -> Result<Option<Duration>, SessionError> {
        let start = Instant::now();
        let session = &mut self.opened.session;
        let times = match session.frame(self.frames) {
            Err(SessionError::Run(RunError::Stopped)) => return Ok(None),
            times => times?,
        };
        let took = start.elapsed();
        self.frames += 1;
        self.report.add(&times, took, &session.counters()?, EnergyLedger::default());
        Ok(Some(took))
    }

    /// Adds the last frame to the sums.
    pub fn add(&mut self) -> Result<(), SessionError> {
        self.sums.add(&self.opened.session.image()?);
        let start = Instant::now();
        if self.sums.frames().is_power_of_two() || self.estimates.is_due(start) {
            self.error = self.sums.relative_error();
            self.estimates.spent(start, Instant::now());
        }
        Ok(())
    }

    /// Returns the mean of its frames, with the data that the layer needs.
    pub fn mean(&self, layer: Layer) -> DisplayedImage {
        let variance = (layer == Layer::Variance).then(|| self.sums.variance()).flatten().unwrap_or_default();
        DisplayedImage { image: self.sums.mean(), variance, ..DisplayedImage::default() }
    }
}
