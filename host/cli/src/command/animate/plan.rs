//! Plan of an animation: the checked options.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;

use caustics::checkpoint::Identity;
use caustics::exposure::Exposure;
use caustics::output::lock;
use caustics::output::target::TargetError;
use caustics::render_config::RenderConfig;
use caustics::rendered_image::Aov;
use caustics::scene::Scene;
use caustics::shard::Shard;
use caustics_bench::parameter::{DENOISER, HISTORY, PATH_HISTORY, SAMPLER};
use caustics_bench::run_config::RunConfig;
use caustics_kernels::interface::choice::{PathHistory, Sampler};
use caustics_kernels::{denoiser, history};

use super::pattern::Pattern;
use crate::cli::{Animate, Usage};
use crate::command::options::{self, check_fps, check_scene_files, duration, layer_names};

/// Maximum number of frames of a run.
const MAX_FRAMES: f64 = 1e6;

/// Plan of an animation.
pub struct AnimationPlan {
    /// Settings of frames and image.
    pub config: RenderConfig,
    /// Name of the runner that the user asked for.
    pub runner: &'static str,
    /// Names of the files.
    pub pattern: Pattern,
    /// Part of the frames to render.
    pub shard: Shard,
    /// Frames of the part.
    pub frames: Range<u32>,
    /// Frames a second [1/s].
    pub fps: f64,
    /// Time between saved states.
    pub every: Duration,
    /// Exposure of the PNGs.
    pub exposure: Exposure,
    /// Additional layers to write.
    pub aov: Vec<Aov>,
    /// Whether each EXR file has a PNG file beside it.
    pub pngs: bool,
}

impl AnimationPlan {
    /// Checks the options, except for the frames.
    pub fn new(options: &Animate) -> anyhow::Result<AnimationPlan> {
        let Animate { common, parameters, fps, .. } = options;
        let is_live = common.tev.is_some() || common.refresh.is_some();
        if common.png.is_some() || common.resume || common.no_ledger || is_live {
            return Err(Usage(
                "animate has no --png-file, --resume, --no-ledger, --tev or --refresh; it always goes on from the frames \
                 that are there"
                    .into(),
            )
            .into());
        }
        check_fps(*fps)?;
        let mut run_config = parameters.unchecked(&[])?;
        let config = &mut run_config.config;
        if !parameters.has(&HISTORY) && config.method.supports_history {
            config.history = &history::VALIDATED;
        }
        if !parameters.has(&PATH_HISTORY) && config.history.settings.is_some() {
            config.path_history = PathHistory::Validated;
        }
        match config.path_history {
            // Validated histories are long: they gain more from samples that are even over frames. They go together with a
            // denoiser.
            PathHistory::Validated if !parameters.has(&DENOISER) => {
                config.denoiser = &denoiser::ATROUS;
            }
            // Without a history each frame is viewed by itself.
            PathHistory::None if !parameters.has(&SAMPLER) => config.sampler = Sampler::Blue,
            _ => {}
        }
        let RunConfig { config, asked_runner: runner, .. } = parameters.checked(run_config)?;
        let config = options::config(&common.view, &config, 1)?.with_defaults_of_method();
        let config = RenderConfig { auxiliary: !common.aov.is_empty(), ..config };
        let mut plan = AnimationPlan {
            config,
            runner,
            pattern: Pattern::parse(&common.output)?,
            shard: common.sharding.asked()?,
            frames: options.frames.clone().unwrap_or_default(),
            fps: *fps,
            every: duration("--checkpoint-every", common.checkpoint_every)?,
            exposure: common.view.exposure,
            aov: common.aov.clone(),
            pngs: options.pngs || options.video,
        };
        // The exposure is the first frame's, which another shard may not have rendered yet.
        if plan.is_part_of_one() && plan.exposure == Exposure::Auto {
            plan.pngs = false;
        }
        Ok(plan)
    }

    /// Sets the frames where none were given: all of the scene's animations and edits, or the shard's part of them. Checks
    /// the frames and their files; none may be one of `files`, which make up the scene.
    pub fn set_frames(&mut self, scene: &Scene, files: Vec<PathBuf>) -> anyhow::Result<()> {
        if self.frames.is_empty() {
            if scene.duration() <= 0.0 {
                let name = &scene.name;
                return Err(Usage(format!("nothing moves in {name}; give --frames A..B")).into());
            }
            // Times of keys have 32 bits: a duration of two seconds may be a little more.
            let end = (scene.duration() * self.fps - 1e-4).ceil().clamp(1.0, f64::from(u32::MAX));
            self.frames = 0..end as u32;
        }
        let count = self.frames.len();
        if count as f64 > MAX_FRAMES {
            return Err(Usage(format!("{count} frames: at most {MAX_FRAMES}; give --frames A..B")).into());
        }
        self.frames = self.shard.frames(self.frames.clone()).map_err(Usage)?;
        let whole = [self.pattern.whole("mp4"), self.state(), lock::path_of(&self.state())];
        let frames = self.frames.clone().flat_map(|k| ["exr", "png"].map(|end| self.pattern.frame(k, end)));
        // Check only frames that share a file name with a file of the scene.
        let real = files.iter().filter_map(|file| file.canonicalize().ok()).collect::<Vec<_>>();
        let scene: Vec<_> = files.into_iter().chain(real).collect();
        let names: BTreeSet<_> = scene.iter().filter_map(|file| file.file_name()).collect();
        let is_named = |path: &PathBuf| path.file_name().is_some_and(|name| names.contains(name));
        for path in whole.iter().cloned().chain(frames).filter(is_named) {
            check_scene_files(&scene, "-o", &path)?;
        }
        let mut files = self.frames.clone().map(|k| self.pattern.frame(k, "exr")).chain(whole);
        if let Some(path) = files.find(|path| path.exists() && !path.is_file()) {
            return Err(TargetError::NoFile(path).into());
        }
        Ok(())
    }

    /// File of the state that outlives a frame; each shard has its own.
    pub fn state(&self) -> PathBuf {
        let AnimationPlan { pattern, shard, .. } = self;
        pattern.whole(&if shard.is_part() { format!("{}.state", shard.name()) } else { "state".into() })
    }

    /// Time that a frame shows (s).
    pub fn time_of(&self, frame: u32) -> f64 {
        f64::from(frame) / self.fps
    }

    /// Whether state outlives a frame, so that no frame can be rendered without those before it.
    pub fn goes_on(&self) -> bool {
        self.config.method.kept(self.config.parts()).next().is_some()
    }

    /// Whether the frames are part of one run's frames, rather than a run of their own.
    pub fn is_part_of_one(&self) -> bool {
        self.shard.is_part() && !self.goes_on()
    }

    /// Identity of the run: everything that decides the bits of every frame, with the part that other commands share. It
    /// excludes the last frame, so that a run can grow.
    pub fn identity(&self, shared: Identity) -> Identity {
        let history = self.config.history.settings;
        let history_settings = history.map_or("none".into(), |settings| format!("{settings:?}"));
        let first = if self.goes_on() { self.frames.start.to_string() } else { "any".into() };
        let own = [
            ("history_settings", history_settings),
            ("aov", layer_names(&self.aov)),
            ("fps", self.fps.to_string()),
            ("first_frame", first),
        ];
        shared.into_iter().chain(own.map(|(name, value)| (name.to_string(), value))).collect()
    }
}
