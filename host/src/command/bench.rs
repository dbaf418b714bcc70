//! `caustics bench`: what frames cost, and with `--animation` how far off they are, cell by cell.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use caustics::experiment::cell::Cell;
use caustics::experiment::identity;
use caustics::experiment::measure::measure;
use caustics::experiment::plan::Plan;
use caustics::experiment::reference::{Kept, References};
use caustics::experiment::row::{self, Row};
use caustics::experiment::summary::set_gains;
use caustics::output::target::Target;
use caustics::scene::{self, Scene};

use super::bench_plan::{check, plan};
use super::bench_report::report;
use super::{bench_still, interrupt};
use crate::cli::{Bench, Usage};

/// Measures and writes. 130 after Ctrl-C, with the frames that were done written.
pub fn run(options: &Bench) -> anyhow::Result<ExitCode> {
    let settings = check(options)?;
    let scene = Scene::load(&scene::resolve(&options.scene)?)?;
    for warning in &scene.warnings {
        tell!("warning: {warning}");
    }
    let (plan, reason) = plan(options, settings, &scene)?;
    match options.output.as_deref().filter(|_| options.animation) {
        Some(folder) => animation(options, &plan, &scene, folder, &reason),
        None => bench_still::run(options, &plan, &scene, &reason),
    }
}

fn animation(
    options: &Bench,
    plan: &Plan,
    scene: &Scene,
    folder: &Path,
    reason: &str,
) -> anyhow::Result<ExitCode> {
    if plan.error.is_some() && !plan.cells.iter().any(|cell| cell.history.name == "none") {
        tell!("warning: --history without none: nothing to measure the gain against");
    }
    std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let stopped = interrupt::watch()?;

    let table = folder.join("frames.csv");
    let mut rows = known(plan, scene, &table, options.force)?;
    let missing = unfinished(plan, &rows);
    let frames = plan.frames.len();
    tell!(
        "{}: {} cells, {frames} frames ({reason}); {} cells to measure",
        scene.name,
        plan.cells.len(),
        missing.len()
    );
    let references = match plan.error {
        Some(error) if !missing.is_empty() => {
            let references = References::new(plan, &plan.cells[0], scene, error.reference_frames, &cache()?);
            if !keep(plan, &references, &stopped)? {
                return Ok(ExitCode::from(130));
            }
            Some(references)
        }
        _ => None,
    };
    let names: Vec<String> = missing.iter().map(|cell| cell.name.clone()).collect();
    rows.retain(|row| !names.contains(&row.cell));
    if !missing.is_empty() {
        let mut each = |new: Vec<Row>| {
            if let Some(row) = new.first() {
                tell!("frame {}: {} of {frames}", row.frame, row.frame - plan.frames.start + 1);
            }
            rows.extend(new);
            save(&table, &mut rows, plan)
        };
        if measure(plan, scene, &missing, references.as_ref(), &stopped, &mut each)?.is_none() {
            tell!("interrupted; the same command measures the cells that are unfinished");
            return Ok(ExitCode::from(130));
        }
    }
    let shown: Vec<Row> = rows.into_iter().filter(|row| plan.frames.contains(&row.frame)).collect();
    report(plan, scene, &shown, folder, options.json)?;
    Ok(ExitCode::SUCCESS)
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
        plan.cells.iter().map(|cell| (cell.name.clone(), identity::of_cell(plan, cell, &first))).collect();
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
    let is_unfinished = |cell: &&Cell| plan.frames.clone().any(|frame| !is_there(&cell.name, frame));
    let missing: Vec<Cell> = plan.cells.iter().filter(is_unfinished).cloned().collect();
    if plan.time && !missing.is_empty() { plan.cells.clone() } else { missing }
}

/// Where references are kept.
pub fn cache() -> Result<PathBuf, Usage> {
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
            tell!("reference {}: {} of {}", frame, frame - plan.frames.start + 1, plan.frames.len());
        }
    }
    let folder = references.folder().display();
    tell!("references: {rendered} rendered, {replaced} replaced, in {folder}");
    Ok(true)
}

/// Writes all rows, in order, with their gains.
fn save(table: &Path, rows: &mut [Row], plan: &Plan) -> anyhow::Result<()> {
    let rank: BTreeMap<String, usize> = plan.cells.iter().map(|cell| cell.name.clone()).zip(0..).collect();
    rows.sort_by_key(|row| (row.frame, rank.get(&row.cell).copied().unwrap_or(usize::MAX), row.cell.clone()));
    set_gains(rows, &plan.cells);
    Ok(Target::claim(table, true)?.finish(&row::encode(rows)?)?)
}
