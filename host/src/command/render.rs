//! `caustics render`.

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::Context;
use caustics::counters::Counters;
use caustics::kernels;
use caustics::method::settings::Settings;
use caustics::output::target::Target;
use caustics::output::{exr, png};
use caustics::picture::Average;
use caustics::runner::StepTime;
use caustics::scene::{self, Scene, SceneCamera};
use caustics::session::Session;
use caustics::trace_rate::closest_hits_per_second;
use caustics_kernels::interface::counters::Counter;
use caustics_kernels::interface::frame::{PIXEL_FILTER_BOX, PIXEL_FILTER_CENTRE};
use caustics_kernels::interface::needs::Needs;
use glam::Vec3;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use super::pick::pick;
use super::scene::needs_names;
use crate::cli::{NeedsName, PixelFilter, Render, Usage};

/// Renders, writes, reports. 130 after Ctrl-C, with what was done written.
pub fn run(options: Box<Render>) -> anyhow::Result<ExitCode> {
    let settings = settings(&options)?;
    check_outputs(&options)?;
    let file = scene::resolve(&options.scene)?;
    // Ctrl-C ends after the frame at hand; what is done is saved, and a part of a file never stays.
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    ctrlc::set_handler(move || flag.store(true, Ordering::SeqCst)).context("cannot catch Ctrl-C")?;
    let target = Target::claim(&options.output, options.force)?;
    let png_target = options.png.as_ref().map(|path| Target::claim(path, options.force)).transpose()?;

    let scene = Scene::load(&file)?;
    for warning in &scene.warnings {
        eprintln!("warning: {warning}");
    }
    let camera = camera(&scene, options.camera.as_deref())?;
    let (choice, variant, reason) = pick(&options)?;
    let needs = match options.needs {
        NeedsName::Scene => scene.needs(settings.specular_roughness),
        NeedsName::All => Needs::ALL,
    };
    let mut session = Session::new(&choice, &scene, camera, &settings, variant, needs)?;
    eprintln!("{}: {} ({reason}), gather {}", scene.name, session.device(), variant.name);

    if interrupted.load(Ordering::SeqCst) {
        return Ok(ExitCode::from(130));
    }
    let bar = bar(options.frames);
    let mut report = Report::default();
    let mut average = Average::default();
    for frame in 0..options.frames {
        let start = Instant::now();
        let times = session.frame(frame)?;
        report.add(&times, start.elapsed(), &session.counters()?);
        average.add(session.picture()?);
        bar.inc(1);
        if interrupted.load(Ordering::SeqCst) {
            break;
        }
    }
    bar.finish_and_clear();
    for warning in report.counters.warnings() {
        eprintln!("warning: {warning}");
    }

    let picture = average.mean();
    let attributes = [
        ("scene", file.display().to_string()),
        ("method", "basic".to_string()),
        ("gather", variant.name.to_string()),
        ("device", session.device()),
        ("settings", format!("{settings:?}")),
        ("frames", average.frames().to_string()),
        ("seconds", report.wall.as_secs_f64().to_string()),
        ("commit", env!("CAUSTICS_COMMIT").to_string()),
        ("kernels", kernels::SOURCES.to_string()),
    ];
    // All that can fail comes before the first file is in its place.
    let exr = exr::encode(&picture, &attributes)?;
    let png = match png_target {
        Some(target) => {
            let colors = session.display(&picture)?;
            Some((target, png::encode(settings.width, settings.height, &colors)?))
        }
        None => None,
    };
    let mut rates = report.rates();
    if options.json {
        rates.insert("closest_hits_per_s", closest_hits_per_second(&choice, &scene, camera, needs)?);
    }
    target.finish(&exr)?;
    if let Some((target, bytes)) = png {
        target.finish(&bytes)?;
    }
    if options.json {
        let pass_ms = report.pass_ms();
        let out = json!({
            "scene": scene.name, "file": file, "method": "basic", "gather": variant.name,
            "device": session.device(), "why": reason, "camera": camera.name,
            "width": settings.width, "height": settings.height, "frames": average.frames(),
            "light_paths": session.params().light_path_count, "max_bounces": settings.max_bounces,
            "radius_px": settings.radius_px, "specular_roughness": settings.specular_roughness,
            "seed": settings.seed, "needs": needs_names(needs), "triangles": scene.triangles.len(),
            "commit": env!("CAUSTICS_COMMIT"), "kernels": kernels::SOURCES,
            "frame_ms": report.frame_ms(), "pass_ms": pass_ms, "rates": rates, "counters": report.counters,
            "seconds": report.wall.as_secs_f64(),
        });
        println!("{}", serde_json::to_string_pretty(&out)?);
    } else {
        eprintln!("{}: {:.1} ms a frame", options.output.display(), report.frame_ms());
    }
    let code = if interrupted.load(Ordering::SeqCst) { 130 } else { 0 };
    Ok(ExitCode::from(code))
}

/// Largest side [px], and largest area, that a frame may have.
const LARGEST_SIDE: u32 = 16_384;
const LARGEST_AREA: u32 = 1 << 26;

/// Checks the options that no type can.
fn settings(options: &Render) -> Result<Settings, Usage> {
    let (width, height) = (options.width, options.height);
    let within = |side| (1..=LARGEST_SIDE).contains(&side);
    if !within(width) || !within(height) || width * height > LARGEST_AREA {
        return Err(Usage(format!(
            "--width {width} --height {height}: each side must be 1 to {LARGEST_SIDE} px, and the area at most \
             {LARGEST_AREA} px"
        )));
    }
    let counts = [
        ("--light-paths", options.light_paths),
        ("--frames", options.frames),
        ("--max-bounces", options.max_bounces),
    ];
    for (flag, value) in counts {
        if value == 0 {
            return Err(Usage(format!("{flag} 0: there is nothing to do; give at least 1")));
        }
    }
    if options.max_bounces > 64 {
        return Err(Usage(format!("--max-bounces {}: at most 64", options.max_bounces)));
    }
    // The kernels count rays in 32 bits.
    let rays = |paths: u32| u64::from(paths) * u64::from(options.max_bounces + 1);
    if rays(width * height) > u64::from(u32::MAX) || rays(options.light_paths) > u64::from(u32::MAX) {
        return Err(Usage(format!(
            "--light-paths {} or --width {width} --height {height} with --max-bounces {}: more than 2^32 rays a frame; \
             use --frames",
            options.light_paths, options.max_bounces
        )));
    }
    if !(options.radius_px.is_finite() && options.radius_px > 0.0) {
        return Err(Usage(format!("--radius-px {}: give a positive number", options.radius_px)));
    }
    if !(0.0..=1.0).contains(&options.specular_roughness) {
        return Err(Usage(format!("--specular-roughness {}: give 0 to 1", options.specular_roughness)));
    }
    if !(-64.0..=64.0).contains(&options.exposure) {
        return Err(Usage(format!("--exposure {}: give -64 to 64 stops", options.exposure)));
    }
    let background = options.background.as_deref().map(color).transpose()?;
    Ok(Settings {
        width,
        height,
        light_paths: options.light_paths,
        max_bounces: options.max_bounces,
        radius_px: options.radius_px,
        specular_roughness: options.specular_roughness,
        seed: options.seed,
        pixel_filter: match options.pixel_filter {
            PixelFilter::Centre => PIXEL_FILTER_CENTRE,
            PixelFilter::Box => PIXEL_FILTER_BOX,
        },
        exposure: options.exposure,
        background,
    })
}

/// A colour from three numbers with commas between.
fn color(text: &str) -> Result<Vec3, Usage> {
    let wrong =
        || Usage(format!("--background {text}: give three numbers from 0 to 1e30, such as 0.2,0.3,0.5"));
    let channels: Vec<f32> =
        text.split(',').map(|part| part.trim().parse().map_err(|_| wrong())).collect::<Result<_, _>>()?;
    match channels[..] {
        [red, green, blue] if channels.iter().all(|channel| (0.0..=1e30).contains(channel)) => {
            Ok(Vec3::new(red, green, blue))
        }
        _ => Err(wrong()),
    }
}

/// Checks that the files to write are two files.
fn check_outputs(options: &Render) -> Result<(), Usage> {
    let folder = |path: &&PathBuf| path.is_dir();
    if let Some(path) = [Some(&options.output), options.png.as_ref()].into_iter().flatten().find(folder) {
        return Err(Usage(format!("{} is a folder; name a file in it", path.display())));
    }
    if options.png.as_ref().is_some_and(|png| same_file(png, &options.output)) {
        let path = options.output.display();
        return Err(Usage(format!("--png {path}: this is the file of -o; give another name")));
    }
    Ok(())
}

/// Whether two paths, of files that need not exist, name one file.
fn same_file(a: &Path, b: &Path) -> bool {
    let folder = |path: &Path| match path.parent() {
        Some(parent) if parent != Path::new("") => parent.canonicalize().ok(),
        _ => Path::new(".").canonicalize().ok(),
    };
    a == b || (a.file_name() == b.file_name() && folder(a).is_some() && folder(a) == folder(b))
}

fn camera<'a>(scene: &'a Scene, name: Option<&str>) -> Result<&'a SceneCamera, Usage> {
    let found = scene.cameras.iter().find(|camera| name.is_none_or(|name| camera.name == name));
    found.ok_or_else(|| {
        let known: Vec<_> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
        Usage(format!("--camera {}: the scene has {}", name.unwrap_or_default(), known.join(", ")))
    })
}

/// A bar with the time left, on a terminal and for several frames only.
fn bar(frames: u32) -> ProgressBar {
    if frames < 2 || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {eta} left");
    ProgressBar::new(u64::from(frames)).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Times and counters of all frames.
#[derive(Default)]
struct Report {
    frames: u32,
    wall: Duration,
    passes: BTreeMap<String, Duration>,
    counters: Counters,
}

impl Report {
    fn add(&mut self, times: &[StepTime], wall: Duration, counters: &Counters) {
        self.frames += 1;
        self.wall += wall;
        for step in times {
            *self.passes.entry(step.pass.clone()).or_default() += step.time;
        }
        self.counters.add(counters);
    }

    fn frame_ms(&self) -> f64 {
        self.wall.as_secs_f64() * 1e3 / f64::from(self.frames.max(1))
    }

    /// Mean time of each pass in a frame [ms].
    fn pass_ms(&self) -> BTreeMap<&str, f64> {
        let mean = |time: &Duration| time.as_secs_f64() * 1e3 / f64::from(self.frames.max(1));
        self.passes.iter().map(|(name, time)| (name.as_str(), mean(time))).collect()
    }

    /// Rates over the time of the passes that do the work [1/s].
    fn rates(&self) -> BTreeMap<&'static str, f64> {
        let seconds = |prefix: &str| -> f64 {
            let passes = self.passes.iter().filter(|(name, _)| name.starts_with(prefix));
            passes.map(|(_, time)| time.as_secs_f64()).sum()
        };
        let rate = |counters: &[Counter], prefix: &str| {
            let count: u64 = counters.iter().map(|&counter| self.counters.get(counter)).sum();
            if count == 0 { 0.0 } else { count as f64 / seconds(prefix) }
        };
        BTreeMap::from([
            ("camera_rays_per_s", rate(&[Counter::CameraRays, Counter::ShadowRays], "collect")),
            ("light_rays_per_s", rate(&[Counter::LightRays], "shoot")),
            ("light_paths_per_s", rate(&[Counter::LightPaths], "shoot")),
        ])
    }
}
