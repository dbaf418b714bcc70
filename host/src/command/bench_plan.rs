//! What `bench` measures: its options checked, as a plan with cells.

use caustics::experiment::cell::{Code, Paths, has_ray_queries};
use caustics::experiment::matrix::{Cells, Matrix};
use caustics::experiment::plan::{ErrorPlan, Plan};
use caustics::experiment::reference::SEED;
use caustics::scene::Scene;
use caustics::settings::Settings;
use caustics_kernels::gather::variant;
use caustics_kernels::method::{self};
use caustics_kernels::{denoiser, history};

use super::options::{camera, settings};
use super::pick::pick;
use crate::cli::{Bench, NeedsName, Usage};

/// The talk's light paths: 1024^2.
const LIGHT_PATHS: u32 = 1024 * 1024;
/// Most light paths a pixel.
const MAX_PER_PIXEL: f64 = 4096.0;

/// Checks what no type can.
pub fn check(options: &Bench) -> Result<Settings, Usage> {
    if options.animation && !options.time && !options.error {
        return Err(Usage("bench --animation: give --time, --error or both".into()));
    }
    if !(options.fps.is_finite() && options.fps > 0.0) {
        return Err(Usage(format!("--fps {}: give a positive number", options.fps)));
    }
    if !options.time_s.is_finite() {
        return Err(Usage(format!("--time-s {}: give a number of seconds", options.time_s)));
    }
    let warm_up = options.warm_up.unwrap_or(0);
    if options.error && warm_up > 0 {
        return Err(Usage(format!(
            "--warm-up {warm_up}: with --error a history must not know frames before the first"
        )));
    }
    if options.error && !(2..=1024).contains(&options.seeds) {
        return Err(Usage(format!("--seeds {}: give 2 to 1024, a variance takes two", options.seeds)));
    }
    if options.error && options.max_bounces.len() > 1 {
        return Err(Usage("--max-bounces: with --error give one, the truth depends on it".into()));
    }
    if options.reference_frames == 0 {
        return Err(Usage("--reference-frames 0: give at least 1".into()));
    }
    let is_wrong = |paths: &&f64| !(**paths > 0.0 && **paths <= MAX_PER_PIXEL);
    if let Some(paths) = options.paths_per_pixel.iter().find(is_wrong) {
        return Err(Usage(format!("--paths-per-pixel {paths}: give more than 0, at most {MAX_PER_PIXEL}")));
    }
    // Each value is checked; what cells have in common is that of the last.
    let mut common = Settings::default();
    for &max_bounces in &options.max_bounces {
        for &radius_px in &options.radius_px {
            for paths in paths(options) {
                let light_paths = paths.count(options.width.max(1), options.height.max(1));
                common = settings(&options.common("cpu", max_bounces), light_paths, 1, radius_px)?;
            }
        }
    }
    if options.error {
        let last = common.seed.checked_add(options.seeds - 1);
        if last.is_none_or(|last| (common.seed..=last).contains(&SEED)) {
            return Err(Usage(format!(
                "--seed {}: references have the seed {SEED}; give another",
                common.seed
            )));
        }
    }
    Ok(common)
}

/// The plan, and why its runners were taken.
pub fn plan(options: &Bench, settings: Settings, scene: &Scene) -> anyhow::Result<(Plan, String)> {
    let camera = camera(scene, options.camera.as_deref())?.name.clone();
    let (Cells { cells, skipped }, reason) = cells(options)?;
    for line in skipped {
        tell!("{line}");
    }
    let error = ErrorPlan { seeds: options.seeds, reference_frames: options.reference_frames };
    let (frames, warm_up) = if options.animation { (0..48, 0) } else { (0..16, 2) };
    let plan = Plan {
        cells,
        settings,
        camera,
        frames: options.frames.clone().unwrap_or(frames),
        fps: options.fps,
        moment: (!options.animation).then_some(options.time_s),
        warm_up: options.warm_up.unwrap_or(warm_up),
        time: options.time || !options.animation,
        error: options.error.then_some(error),
    };
    Ok((plan, reason))
}

fn cells(options: &Bench) -> anyhow::Result<(Cells, String)> {
    let (mut runners, mut reasons) = (Vec::new(), Vec::new());
    // A gather that is asked for alone must be there.
    let alone = match &options.gather[..] {
        [gather] if options.runner.len() == 1 => Some(gather.as_str()),
        _ => None,
    };
    let methods = found(&options.method, method::find)?;
    let alone = alone.filter(|_| methods.iter().all(|method| method.gathers));
    for name in &options.runner {
        let (choice, _, reason) = pick(&options.common(name, 1), alone)?;
        runners.push(choice);
        reasons.push(reason);
    }
    let code = |features: &NeedsName| match features {
        NeedsName::Scene => Code::Scene,
        NeedsName::All => Code::All,
    };
    let histories = match (options.history.is_empty(), options.animation) {
        (true, true) => history::ALL.to_vec(),
        (true, false) => vec![&history::NONE],
        (false, _) => found(&options.history, history::find)?,
    };
    let has_any = runners.iter().any(has_ray_queries);
    let matrix = Matrix {
        methods,
        gathers: found(&options.gather, variant::find)?,
        histories,
        denoisers: found(&options.denoiser, denoiser::find)?,
        paths: paths(options),
        radii: options.radius_px.clone(),
        bounces: options.max_bounces.clone(),
        runners,
        codes: options.features.iter().map(code).collect(),
    };
    let cells = matrix.cells();
    if cells.cells.is_empty() {
        let why = if has_any { "" } else { ": they need ray queries, and no runner has any" };
        return Err(Usage(format!("--gather {}: none is left{why}", options.gather.join(","))).into());
    }
    Ok((cells, reasons.join(", ")))
}

fn found<T>(names: &[String], find: impl Fn(&str) -> Option<T>) -> Result<Vec<T>, Usage> {
    let unknown = |name: &str| Usage(format!("nothing is called {name}"));
    names.iter().map(|name| find(name).ok_or_else(|| unknown(name))).collect()
}

fn paths(options: &Bench) -> Vec<Paths> {
    if !options.paths_per_pixel.is_empty() {
        return options.paths_per_pixel.iter().map(|paths| Paths::PerPixel(*paths)).collect();
    }
    let counts = if options.light_paths.is_empty() { &[LIGHT_PATHS][..] } else { &options.light_paths };
    counts.iter().map(|count| Paths::Count(*count)).collect()
}
