//! `caustics inspect`: light transport at a pixel.

use std::process::ExitCode;

use caustics::accumulation::BATCHES;
use caustics::inspect::Inspection;
use caustics::program::program;
use caustics::render_config::RenderConfig;
use caustics::scene::{self, Staged};
use serde::Serialize;

use self::table::table;
use super::console::print;
use super::open::{Opened, open_edited, opened, warn};
use super::options::config;
use super::render::configuration;
use crate::cli::{Inspect, Usage};

mod table;

/// JSON output.
#[derive(Serialize)]
struct Output<'a> {
    scene: &'a str,
    file: String,
    camera: &'a str,
    time_s: f64,
    method: &'static str,
    emission: &'static str,
    caustics: &'static str,
    width: u32,
    height: u32,
    max_bounces: u32,
    seed: u32,
    device: String,
    commit: &'static str,
    #[serde(flatten)]
    inspection: &'a Inspection,
}

/// Renders the frame and those before it, and prints the light transport of the pixel.
pub fn run(options: &Inspect) -> anyhow::Result<ExitCode> {
    let Inspect { pixel, frame, view, time, .. } = options;
    let (run_config, preset) = configuration(&options.parameters, options.preset, *frame > 0)?;
    let frames = frame.checked_add(1).ok_or_else(|| Usage(format!("--frame {frame}: give a smaller one")))?;
    let method = run_config.config.method;
    let config = config(view, &run_config.config, preset.frames().max(frames))?;
    let config = RenderConfig { batches: BATCHES, ..config.with_defaults_of_method() };
    if !time.is_finite() {
        return Err(Usage(format!("--time {time}: give a number of seconds")).into());
    }
    if pixel.x >= view.width || pixel.y >= view.height {
        let (x, y, width, height) = (pixel.x, pixel.y, view.width, view.height);
        return Err(Usage(format!("--pixel {x},{y}: the image has {width} by {height} px")).into());
    }
    let file = scene::resolve(&options.scene)?;
    let Staged { mut scene, camera, .. } =
        open_edited(&file, view, &options.loading, options.edits.as_deref())?;
    scene.begin_at(*time)?;
    let camera = scene.camera(Some(&camera))?;
    warn(&scene, &config);
    let features = config.features(&scene);
    let Opened { mut session, .. } =
        opened(&config, run_config.asked_runner, &options.machine, &scene, camera, features)?;
    session.keep_starts(true);
    for frame in 0..frames {
        session.frame(frame)?;
    }
    let inspection = session.inspect(&scene, pixel.x, pixel.y, options.photons)?;
    if options.json {
        let output = Output {
            scene: &scene.name,
            file: file.display().to_string(),
            camera: &camera.name,
            time_s: *time,
            method: method.name,
            emission: config.emission.name,
            caustics: config.caustics.name(),
            width: config.width,
            height: config.height,
            max_bounces: config.max_bounces,
            seed: config.seed,
            device: session.device(),
            commit: &program().commit,
            inspection: &inspection,
        };
        print(serde_json::to_string_pretty(&output)?)?;
    } else {
        print(format_args!("{}, method {}, {}", scene.name, method.name, session.device()))?;
        print(table(&inspection))?;
    }
    Ok(ExitCode::SUCCESS)
}
