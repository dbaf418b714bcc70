//! A run of frames: opens the session, renders until a stop is reached, keeps checkpoints, writes and reports.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use caustics::accumulation::{Accumulation, BATCHES, Shape};
use caustics::checkpoint::{self, Checkpoint, CheckpointError, Identity};
use caustics::energy::EnergyLedger;
use caustics::kernels;
use caustics::oidn::{Denoised, Oidn};
use caustics::output::lock::{self, FileLock};
use caustics::output::target::{Target, TargetError, remove};
use caustics::output::{exr, png};
use caustics::program::program;
use caustics::render_config::{Radius, RenderConfig};
use caustics::scene::{self, Staged};
use caustics::sealed::Unusable;
use caustics::session::{Session, SessionError};
use caustics::trace_rate::closest_hits_per_second;
use caustics_kernels::interface::choice::TextureFilter;
use caustics_kernels::interface::features::Features;
use serde_json::json;

use super::checkpoint_writer::CheckpointWriter;
use super::console::{bar, print};
use super::identity::{attributes, end, identity};
use super::interrupt;
use super::live::Live;
use super::open::{Opened, open, opened, warn};
use super::options::{check_outputs, check_scene_files, duration, layer_attributes, scene_files};
use super::report::RunReport;
use super::scene::feature_names;
use super::shard::{ShardFrames, warn_of_reuse};
use super::stop::Stop;
use crate::cli::{Common, Usage};

/// A run of frames of one view.
pub struct Job {
    /// Options common to all commands.
    pub common: Common,
    /// Settings of frames and image.
    pub config: RenderConfig,
    /// Name of the runner that the user asked for.
    pub runner: &'static str,
    /// Time of the animations to show (s).
    pub time: f64,
    /// Condition that ends the run.
    pub stop: Stop,
}

impl Job {
    /// Renders, writes and reports. Returns exit code 130 after Ctrl-C; finished frames are written.
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let Job { common: options, config, runner, time, stop } = self;
        let method = config.method;
        let auxiliary = !options.aov.is_empty() || config.denoises_image();
        let config = RenderConfig { batches: BATCHES, auxiliary, ..config.with_defaults_of_method() };
        if !time.is_finite() {
            return Err(Usage(format!("--time {time}: give a number of seconds")).into());
        }
        check_outputs(&options)?;
        let every = duration("--checkpoint-every", options.checkpoint_every)?;
        let file = scene::resolve(&options.scene)?;
        let scene_files = scene_files(&file, &options);
        check_scene_files(&scene_files, "-o", &options.output)?;
        if let Some(png) = &options.png {
            check_scene_files(&scene_files, "--png", png)?;
        }
        let is_interrupted = interrupt::watch()?;
        let force = options.force || options.resume;
        let part = ShardFrames::from_options(&options, &config, &stop)?;
        // Find a missing library before the first frame.
        let threads = options.machine.threads;
        let oidn = config.denoises_image().then(|| Oidn::from_environment(threads)).transpose()?;
        let output = part.as_ref().map_or(&options.output, |part| &part.file);
        let checkpoint = part.as_ref().map_or_else(|| checkpoint::path_of(output), |part| part.file.clone());
        for path in [&checkpoint, &lock::path_of(output)] {
            check_scene_files(&scene_files, "-o", path)?;
        }
        // All runs with this output share its checkpoint.
        let _lock = FileLock::take(output)?;
        let target = if part.is_some() { None } else { Some(Target::claim(output, force)?) };
        let mut png_target = options.png.as_ref().map(|path| Target::claim(path, force)).transpose()?;
        let mut live = Live::new(&options)?;
        if let Some(path) = options.png.as_ref().filter(|_| live.has_png()) {
            // From now on, the PNG shows the image so far.
            png_target = Some(Target::claim(path, true)?);
        }
        if part.is_none() && checkpoint.exists() && !force {
            return Err(TargetError::Exists(checkpoint).into());
        }

        let Staged { mut scene, camera, .. } = open(&file, &options)?;
        scene.begin_at(time)?;
        let camera = scene.camera(Some(&camera))?.clone();
        warn(&scene, &config);
        let (first, stop) = match &part {
            Some(ShardFrames { frames, .. }) => {
                warn_of_reuse(&config, frames.start);
                (frames.start, Stop { frames: Some(frames.len() as u32), ..stop })
            }
            None => (0, stop),
        };
        let features = config.features(&scene);
        // The energy ledger costs time, so only the JSON output turns it on.
        let has_ledger = options.json && !options.no_ledger;
        let features = if has_ledger { features | Features::LEDGER } else { features };
        let Opened { mut session, choice, gather, reason } =
            opened(&config, runner, &options.machine, &scene, &camera, features)?;
        message!("{}: {} ({reason}), method {}, gather {gather}", scene.name, session.device(), method.name);
        let identity = identity(&scene, &camera.name, &config, gather, &choice, &session);
        let triangles = scene.triangles.len();
        if !options.json {
            // Only the measurement of the tracer's rate reads the tables again.
            scene.leave_tables();
        }
        let (width, height) = (config.width as usize, config.height as usize);
        let batches = config.batches_of_frames();
        let shape = Shape { width, height, first, frames: 0, gathers: method.gathers, batches, auxiliary };
        let mut about = attributes(identity.clone(), &file, &session);
        about.extend(layer_attributes(&options.aov, &scene));
        let identity = part.as_ref().map_or(identity.clone(), |part| part.identity(&identity));
        let kept = Kept { path: checkpoint, identity, about };
        // A shard resumes without --resume, as the frames of an animation do.
        let resumes = if part.is_some() { kept.path.exists() && !options.force } else { options.resume };
        let Checkpoint { mut sums, spent: before, state, .. } = match resumes {
            true => checkpoint::load(&kept.path, &kept.identity, shape)?,
            false => Checkpoint { sums: Accumulation::from_frame(first, batches), ..Checkpoint::default() },
        };
        if resumes && let Some(last) = sums.shape.end().checked_sub(1) {
            session.restore(last, &state).map_err(|error| damaged(&kept.path, error))?;
        }
        let mut checkpoint_writer = CheckpointWriter::new("a checkpoint");

        let bar = bar();
        let mut report = RunReport::default();
        let (mut saved, mut saved_frames) = (Instant::now(), 0);
        let done = loop {
            let relative_error = if stop.relative_error.is_some() { sums.relative_error() } else { 0.0 };
            let progress = stop.progress(sums.frames(), before + report.wall, relative_error);
            bar.set_position((progress * bar.length().unwrap_or(1) as f64) as u64);
            bar.set_message(format!("{} frames", sums.frames()));
            if progress >= 1.0 || is_interrupted() {
                break progress >= 1.0;
            }
            let start = Instant::now();
            let frame = sums.shape.end();
            let times = session.frame(frame)?;
            let wall = start.elapsed();
            let energy = if has_ledger { session.energy()? } else { EnergyLedger::default() };
            report.add(&times, wall, &session.counters()?, energy);
            sums.add(&session.image()?);
            live.show(|| sums.mean());
            if saved.elapsed() >= every {
                checkpoint_writer.keep(kept.save(&mut sums, before + report.wall, &mut session));
                saved = Instant::now();
                saved_frames = if checkpoint_writer.is_kept() { sums.frames() } else { 0 };
            }
        };
        bar.finish_and_clear();
        if sums.frames() == 0 {
            return Ok(ExitCode::from(130));
        }
        for warning in report.counters.warnings() {
            message!("warning: {warning}");
        }
        // Save a long finished run too, before anything that may fail.
        let is_long = report.wall >= every && saved_frames != sums.frames();
        if !done || is_long || part.is_some() {
            let saved = kept.save(&mut sums, before + report.wall, &mut session);
            // The checkpoint is the only result of a shard.
            if part.is_some() { saved? } else { checkpoint_writer.keep(saved) }
        }
        if !done {
            let hint = match part {
                _ if !checkpoint_writer.is_kept() => "",
                Some(_) => "; the same command goes on",
                None => "; --resume goes on",
            };
            message!("interrupted after {} frames{hint}", sums.frames());
        }

        let mut image = sums.mean();
        let seconds = (before + report.wall).as_secs_f64();
        let (device, frames, relative_error) = (session.device(), sums.frames(), sums.relative_error());
        // The variance of the mean is not that of a denoised image.
        let variance = sums.variance().filter(|_| oidn.is_none()).map(|variance| (variance, frames));
        // Free memory for the steps that follow.
        drop(sums);
        let denoised = oidn.map(|oidn| oidn.denoise(&mut image)).transpose()?;
        denoised.iter().for_each(print_denoised);
        image.auxiliary.keep(&options.aov);
        let stops = options.view.exposure.stops_for(&image);
        let colors = match &png_target {
            Some(_) => {
                session.expose(stops as f32);
                session.display(&image)?
            }
            None => Vec::new(),
        };
        drop(session);
        let mut rates = report.rates(u64::from(config.width) * u64::from(config.height));
        if options.json {
            rates.insert("closest_hits_per_s", closest_hits_per_second(&choice, &scene, &camera, features)?);
        }
        // Do everything that can fail before the first file is in its place.
        let exr = match target {
            Some(target) => {
                let mut attributes = kept.about;
                end(&mut attributes, frames, seconds);
                attributes.extend(denoised.iter().flat_map(Denoised::attributes));
                Some((target, exr::encode(&image, variance, &attributes)?))
            }
            None => None,
        };
        let png = match png_target {
            Some(target) => Some((target, png::encode(config.width, config.height, &colors)?)),
            None => None,
        };
        live.send(&image);
        for (target, bytes) in exr.into_iter().chain(png) {
            target.finish(&bytes)?;
        }
        if done
            && part.is_none()
            && let Err(error) = remove(&kept.path)
        {
            message!("warning: {error:#}");
        }
        if options.json {
            let out = json!({
                "scene": scene.name, "file": file, "method": method.name, "gather": gather,
                "denoiser": config.denoiser.name, "sampler": config.sampler.name(),
                "device": device, "why": reason, "camera": camera.name, "time_s": time,
                "width": config.width, "height": config.height, "frames": frames,
                "light_paths": report.light_paths(), "max_bounces": config.max_bounces,
                "radius_px": config.radius.px(), "widens": config.radius == Radius::Auto,
                "specular_roughness": config.specular_roughness,
                "texture_filter": config.texture_filter.map(TextureFilter::name),
                "exposure": stops,
                "seed": config.seed, "features": feature_names(features), "triangles": triangles,
                "commit": program().commit, "kernels": kernels::SOURCES,
                "frame_ms": report.frame_ms(), "pass_ms": report.pass_ms(), "rates": rates,
                "counters": report.counters, "seconds": seconds,
                "energy": (method.gathers && has_ledger).then(|| report.energy()),
                "estimated_relmse": relative_error.is_finite().then_some(relative_error),
                "oidn": denoised,
            });
            print(serde_json::to_string_pretty(&out)?)?;
        } else {
            let frames = report.frames();
            message!("{}: {frames} frames rendered, {:.1} ms a frame", output.display(), report.frame_ms());
        }
        Ok(if done { ExitCode::SUCCESS } else { ExitCode::from(130) })
    }
}

/// Change of energy by a denoiser above which a warning says so.
const MAX_ENERGY_CHANGE: f64 = 0.05;

/// Prints the record of a denoised image.
fn print_denoised(denoised: &Denoised) {
    let Denoised { version, energy_ratio, ms, non_finite_count } = denoised;
    if *non_finite_count > 0 {
        message!(
            "warning: {non_finite_count} pixels of the path layer are not finite; the denoiser takes them as black"
        );
    }
    message!(
        "Open Image Denoise {version}: {ms:.0} ms; the denoised path layer had {energy_ratio:.5} of the energy, and was divided by that"
    );
    if (energy_ratio - 1.0).abs() > MAX_ENERGY_CHANGE {
        message!(
            "warning: the denoiser removed or added much light, and the whole layer was scaled; give more --frames"
        );
    }
}

/// Turns a checkpoint that a run cannot resume from into an error of its file.
fn damaged(path: &Path, error: SessionError) -> anyhow::Error {
    match error {
        SessionError::State { .. } | SessionError::NotFinite { .. } => {
            CheckpointError::Unusable { path: path.into(), why: Unusable::damaged(error) }.into()
        }
        error => error.into(),
    }
}

/// Checkpoint of a run, to resume from or to merge: its path, identity and attributes.
struct Kept {
    path: PathBuf,
    identity: Identity,
    about: BTreeMap<String, String>,
}

impl Kept {
    /// Writes the sums so far, with the state that the last frame passes to the next.
    fn save(&self, sums: &mut Accumulation, spent: Duration, session: &mut Session) -> anyhow::Result<()> {
        let state = session.state()?.into_iter().map(|(name, bytes)| (name.to_string(), bytes)).collect();
        // Move the sums into the checkpoint and back: memory may not hold them twice.
        let about = self.about.clone();
        let checkpoint = Checkpoint { sums: std::mem::take(sums), spent, about, state };
        let saved = checkpoint::save(&self.path, &self.identity, &checkpoint);
        *sums = checkpoint.sums;
        Ok(saved?)
    }
}
