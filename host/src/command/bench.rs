//! `caustics bench --animation`: what each frame of an animation costs, and how far off it is, method by method.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use caustics::experiment::cell::Cell;
use caustics::experiment::identity;
use caustics::experiment::measure::measure;
use caustics::experiment::plan::{ErrorPlan, Plan};
use caustics::experiment::reference::{Kept, References, SEED};
use caustics::experiment::row::{self, Row};
use caustics::experiment::summary::set_gains;
use caustics::method::settings::Settings;
use caustics::method::{self, filter, history};
use caustics::output::target::Target;
use caustics::scene::{self, Scene};

use super::bench_report::report;
use super::interrupt;
use super::options::{camera, needs, settings};
use super::pick::pick;
use crate::cli::{Bench, Usage};

/// The talk's light paths: 1024^2.
const LIGHT_PATHS: u32 = 1024 * 1024;

/// Measures and writes. 130 after Ctrl-C, with the frames that were done written.
pub fn run(options: &Bench) -> anyhow::Result<ExitCode> {
    let settings = check(options)?;
    let common = &options.common;
    let scene = Scene::load(&scene::resolve(&common.scene)?)?;
    for warning in &scene.warnings {
        eprintln!("warning: {warning}");
    }
    let camera = camera(&scene, common.camera.as_deref())?.name.clone();
    let (choice, gather, reason) = pick(common, options.gather.as_deref())?;
    let needs = needs(common, &scene, &settings);
    let error = ErrorPlan { seeds: options.seeds, reference_frames: options.reference_frames };
    let plan = Plan {
        cells: cells(options)?,
        settings,
        camera,
        gather,
        needs,
        choice,
        frames: options.frames.clone(),
        fps: options.fps,
        warm_up: options.warm_up,
        time: options.time,
        error: options.error.then_some(error),
    };
    if plan.error.is_some() && !plan.cells.iter().any(|cell| cell.history.name == "none") {
        eprintln!("warning: --history without none: nothing to measure the gain against");
    }
    let folder = &common.output;
    std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let stopped = interrupt::watch()?;

    let table = folder.join("frames.csv");
    let mut rows = known(&plan, &scene, &table, common.force)?;
    let missing = unfinished(&plan, &rows);
    let frames = plan.frames.len();
    eprintln!(
        "{}: {} cells, {frames} frames, gather {} ({reason}); {} cells to measure",
        scene.name,
        plan.cells.len(),
        gather.name,
        missing.len()
    );
    let references = match plan.error {
        Some(error) if !missing.is_empty() => {
            let references = References::new(&plan, &scene, error.reference_frames, &cache()?);
            if !keep(&plan, &references, &stopped)? {
                return Ok(ExitCode::from(130));
            }
            Some(references)
        }
        _ => None,
    };
    let names: Vec<String> = missing.iter().map(Cell::name).collect();
    rows.retain(|row| !names.contains(&row.cell));
    if !missing.is_empty() {
        let mut each = |new: Vec<Row>| {
            if let Some(row) = new.first() {
                eprintln!("frame {}: {} of {frames}", row.frame, row.frame - plan.frames.start + 1);
            }
            rows.extend(new);
            save(&table, &mut rows, &plan)
        };
        if !measure(&plan, &scene, &missing, references.as_ref(), &stopped, &mut each)? {
            eprintln!("interrupted; the same command measures the cells that are unfinished");
            return Ok(ExitCode::from(130));
        }
    }
    let shown: Vec<Row> = rows.into_iter().filter(|row| plan.frames.contains(&row.frame)).collect();
    report(&plan, &scene, &shown, folder, common.json)?;
    Ok(ExitCode::SUCCESS)
}

/// Checks what no type can, and makes settings of it.
fn check(options: &Bench) -> Result<Settings, Usage> {
    let common = &options.common;
    if !options.time && !options.error {
        return Err(Usage("bench --animation: give --time, --error or both".into()));
    }
    if common.png.is_some() || common.resume || common.no_ledger {
        return Err(Usage(
            "bench has no --png, --resume or --no-ledger; it always goes on from frames.csv".into(),
        ));
    }
    if !(options.fps.is_finite() && options.fps > 0.0) {
        return Err(Usage(format!("--fps {}: give a positive number", options.fps)));
    }
    if options.error && options.warm_up > 0 {
        let count = options.warm_up;
        return Err(Usage(format!(
            "--warm-up {count}: with --error a history must not know frames before the first"
        )));
    }
    if options.error && !(2..=1024).contains(&options.seeds) {
        return Err(Usage(format!("--seeds {}: give 2 to 1024, a variance takes two", options.seeds)));
    }
    if options.reference_frames == 0 {
        return Err(Usage("--reference-frames 0: give at least 1".into()));
    }
    let light_paths = match options.paths_per_pixel {
        Some(paths) if paths > 0.0 && paths <= 4096.0 => {
            let pixels = f64::from(common.width) * f64::from(common.height);
            (paths * pixels).round().max(1.0) as u32
        }
        Some(paths) => {
            return Err(Usage(format!("--paths-per-pixel {paths}: give more than 0, at most 4096")));
        }
        None => options.light_paths.unwrap_or(LIGHT_PATHS),
    };
    let settings = settings(common, light_paths, 1, options.radius_px)?;
    if options.error {
        let last = settings.seed.checked_add(options.seeds - 1);
        if last.is_none_or(|last| (settings.seed..=last).contains(&SEED)) {
            return Err(Usage(format!(
                "--seed {}: references have the seed {SEED}; give another",
                settings.seed
            )));
        }
    }
    Ok(settings)
}

fn cells(options: &Bench) -> Result<Vec<Cell>, Usage> {
    let unknown = |name: &str| Usage(format!("nothing is called {name}"));
    let methods: Vec<_> = options
        .method
        .iter()
        .map(|name| method::find(name).ok_or_else(|| unknown(name)))
        .collect::<Result<_, _>>()?;
    let histories: Vec<_> = options
        .history
        .iter()
        .map(|name| history::find(name).ok_or_else(|| unknown(name)))
        .collect::<Result<_, _>>()?;
    let filters: Vec<_> = options
        .filter
        .iter()
        .map(|name| filter::find(name).ok_or_else(|| unknown(name)))
        .collect::<Result<_, _>>()?;
    let histories = if histories.is_empty() { history::ALL } else { &histories };
    let mut cells = Cell::all(&methods, histories, &filters);
    let mut seen = Vec::new();
    cells.retain(|cell| {
        let new = !seen.contains(&cell.name());
        seen.push(cell.name());
        new
    });
    Ok(cells)
}

/// Rows that the folder holds already; those of another run are refused, or forgotten by force.
fn known(plan: &Plan, scene: &Scene, table: &Path, force: bool) -> anyhow::Result<Vec<Row>> {
    if force || !table.exists() {
        return Ok(Vec::new());
    }
    let bytes = std::fs::read(table).with_context(|| format!("cannot read {}", table.display()))?;
    let rows = row::decode(&bytes)
        .map_err(|error| Usage(format!("{}: {error:#}; give --force or another -o", table.display())))?;
    let first = identity::posed(scene, plan.time_of(plan.frames.start))?;
    let identities: BTreeMap<String, String> =
        plan.cells.iter().map(|cell| (cell.name(), identity::of_cell(plan, cell, &first))).collect();
    let other = |row: &&Row| identities.get(&row.cell).is_some_and(|identity| *identity != row.identity);
    if let Some(row) = rows.iter().find(other) {
        return Err(Usage(format!(
            "{} holds measures of {} with other settings, scene or kernels; give --force or another -o",
            table.display(),
            row.cell
        ))
        .into());
    }
    Ok(rows)
}

/// Cells of which a frame is missing. Times are compared in pairs: if one cell is to be timed, all are.
fn unfinished(plan: &Plan, rows: &[Row]) -> Vec<Cell> {
    let is_there = |name: &str, frame| rows.iter().any(|row| row.cell == name && row.frame == frame);
    let is_unfinished = |cell: &&Cell| plan.frames.clone().any(|frame| !is_there(&cell.name(), frame));
    let missing: Vec<Cell> = plan.cells.iter().filter(is_unfinished).copied().collect();
    if plan.time && !missing.is_empty() { plan.cells.clone() } else { missing }
}

/// Where references are kept.
fn cache() -> Result<PathBuf, Usage> {
    let set = |name| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    set("CAUSTICS_CACHE")
        .or_else(|| Some(set("HOME")?.join(".cache/caustics")))
        .ok_or_else(|| Usage("references need a folder: set the environment variable CAUSTICS_CACHE".into()))
}

/// Renders the references that are missing. False where it was stopped.
fn keep(plan: &Plan, references: &References, stopped: &dyn Fn() -> bool) -> anyhow::Result<bool> {
    let (mut rendered, mut replaced) = (0, 0);
    for frame in plan.frames.clone() {
        match references.keep(frame, stopped)? {
            Kept::Reused => {}
            Kept::Rendered => rendered += 1,
            Kept::Replaced => replaced += 1,
            Kept::Stopped => return Ok(false),
        }
        if rendered + replaced > 0 {
            eprintln!("reference {}: {} of {}", frame, frame - plan.frames.start + 1, plan.frames.len());
        }
    }
    let folder = references.folder().display();
    eprintln!("references: {rendered} rendered, {replaced} replaced, in {folder}");
    Ok(true)
}

/// Writes all rows, in order, with their gains.
fn save(table: &Path, rows: &mut [Row], plan: &Plan) -> anyhow::Result<()> {
    let rank: BTreeMap<String, usize> = plan.cells.iter().map(Cell::name).zip(0..).collect();
    rows.sort_by_key(|row| (row.frame, rank.get(&row.cell).copied().unwrap_or(usize::MAX), row.cell.clone()));
    set_gains(rows, &plan.cells);
    Ok(Target::claim(table, true)?.finish(&row::encode(rows)?)?)
}
