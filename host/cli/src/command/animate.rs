//! `caustics animate`: the frames of an animation, one file each.

use std::process::ExitCode;

use anyhow::Context;
use caustics::kernels;
use caustics::output::lock::FileLock;
use caustics::program::program;
use caustics::render_config::{Paths, Radius};
use caustics::scene::{self, Staged};
use caustics_kernels::interface::choice::TextureFilter;
use serde_json::json;

use self::plan::AnimationPlan;
use self::record::{RenderedFrame, sums};
use self::run::Run;
use super::checkpoint_writer::CheckpointWriter;
use super::console::print;
use super::identity::pose_independent;
use super::interrupt;
use super::open::{Opened, open, opened, warn};
use super::options::scene_files;
use super::scene::feature_names;
use super::shard::warn_of_reuse;
use crate::cli::Animate;

mod kept;
mod pattern;
mod plan;
mod record;
mod run;
mod state;
mod video;

/// Renders the missing frames. Returns exit code 130 after Ctrl-C; finished frames are written.
pub fn run(options: &Animate) -> anyhow::Result<ExitCode> {
    let common = &options.common;
    let mut plan = AnimationPlan::new(options)?;
    let file = scene::resolve(&common.scene)?;
    let is_interrupted = interrupt::watch()?;
    let Staged { scene, camera: name, .. } = open(&file, common)?;
    plan.set_frames(&scene, scene_files(&file, common))?;
    let video = plan.pattern.whole("mp4");
    let wants_video = options.video && !plan.shard.is_part();
    if wants_video {
        video::check(&video, common.force)?;
    }
    let has_video = wants_video && video::has_ffmpeg();
    if wants_video && !has_video {
        message!("warning: there is no ffmpeg on the PATH: PNGs are written, but no video");
    }
    warn(&scene, &plan.config);
    if plan.shard.is_part() {
        warn_of_reuse(&plan.config, plan.frames.start);
        let waits = options.video || options.pngs && !plan.pngs;
        if waits && plan.is_part_of_one() {
            message!("PNGs and video that are missing, the same command without --shard writes");
        } else if waits {
            message!("warning: a shard writes no video; make one of the PNGs");
        }
    }
    let view = scene.camera(Some(&name))?;
    let features = plan.config.features(&scene);
    let Opened { session, choice, gather, reason } =
        opened(&plan.config, plan.runner, &common.machine, &scene, view, features)?;
    let (method, history) = (plan.config.method.name, plan.config.history.name);
    message!(
        "{}: {} ({reason}), method {method}, gather {gather}, history {history}",
        scene.name,
        session.device()
    );
    let folder = plan.pattern.folder();
    std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    // All runs of a part share one state file.
    let _lock = FileLock::take(&plan.state())?;
    let shared = pose_independent(&scene, &name, &plan.config, gather, &choice, &session);
    let identity = plan.identity(shared);
    let mut run = Run {
        plan,
        scene,
        camera: name,
        session,
        identity,
        posed: None,
        checkpoint_writer: CheckpointWriter::new("a state"),
    };
    if common.force {
        run.forget()?;
    }
    let plan = &run.plan;
    let missing = kept::missing(&plan.pattern, &plan.frames, &run.identity, plan.pngs)?;
    let (records, done) = run.render(&missing, &is_interrupted)?;
    if done && run.plan.pngs {
        run.write_kept_pngs(&missing)?;
    }
    let (counters, frame_ms) = sums(&records);
    for warning in counters.warnings() {
        message!("warning: {warning}");
    }
    if done && has_video {
        video::write(&run.plan.pattern, &run.plan.frames, run.plan.fps, &video)?;
    }
    print_summary(&run, &missing, &records, frame_ms, done);
    if common.json {
        let Run { plan, scene, camera, session, .. } = &run;
        let config = &plan.config;
        let out = json!({
            "scene": scene.name, "file": file, "method": method, "gather": gather, "history": history,
            "denoiser": config.denoiser.name, "device": session.device(), "why": reason, "camera": camera,
            "fps": plan.fps, "first": plan.frames.start, "end": plan.frames.end,
            "width": config.width, "height": config.height,
            "light_paths": if config.light_paths == Paths::Auto { json!("auto") } else { json!(config.max_light_paths()) },
            "max_bounces": config.max_bounces, "radius_px": config.radius.px(), "widens": config.radius == Radius::Auto,
            "specular_roughness": config.specular_roughness,
            "texture_filter": config.texture_filter.map(TextureFilter::name), "seed": config.seed,
            "features": feature_names(features), "commit": program().commit, "kernels": kernels::SOURCES,
            "kept": plan.frames.len() - missing.len(), "done": done,
            "video": (done && has_video).then_some(video),
            "frames": records, "frame_ms": frame_ms, "counters": counters,
        });
        print(serde_json::to_string_pretty(&out)?)?;
    }
    Ok(if done { ExitCode::SUCCESS } else { ExitCode::from(130) })
}

/// Prints a summary of the run.
fn print_summary(run: &Run, missing: &[u32], records: &[RenderedFrame], frame_ms: f64, done: bool) {
    let name = run.plan.pattern.frame(run.plan.frames.start, "exr");
    let all = run.plan.frames.len();
    if missing.is_empty() {
        message!("{}: all {all} frames are there; nothing to render", name.display());
        return;
    }
    let written = records.iter().filter(|record| record.written).count();
    let again = records.len() - written;
    message!(
        "{}: {written} frames rendered, {again} rendered again for their history, {} kept; {frame_ms:.1} ms a frame",
        name.display(),
        all - missing.len()
    );
    if !done {
        message!("interrupted; the same command goes on");
    }
}
