//! `caustics bench` without `--animation`: cells at one moment take turns, and their times are a table.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;
use caustics::experiment::identity::posed;
use caustics::experiment::measure::measure;
use caustics::experiment::plan::Plan;
use caustics::experiment::result::CellResult;
use caustics::experiment::row::{self, Row};
use caustics::experiment::store::{self, provenance};
use caustics::experiment::table::{passes_csv, table};
use caustics::experiment::timing::cell_time;
use caustics::experiment::{identity, reference};
use caustics::output::target::{Target, TargetError, remove};
use caustics::scene::Scene;

use super::interrupt;
use super::say::say;
use crate::cli::Bench;

/// Measures, writes and prints. 130 after Ctrl-C, with the whole turns that were done.
pub fn run(options: &Bench, plan: &Plan, scene: &Scene, reason: &str) -> anyhow::Result<ExitCode> {
    let folder = options.output.as_deref();
    if let Some(folder) = folder {
        let table = folder.join("frames.csv");
        if table.exists() && !options.force {
            return Err(TargetError::Exists(table).into());
        }
        forget(folder, &table)?;
        store::create(folder)?;
    }
    let stopped = interrupt::watch()?;
    let frames = plan.frames.len();
    tell!("{}: {} cells, {frames} frames ({reason})", scene.name, plan.cells.len());
    let mut rows: Vec<Row> = Vec::new();
    let mut each = |new| {
        rows.extend(new);
        Ok(())
    };
    let devices = measure(plan, scene, &plan.cells, None, &stopped, &mut each)?;
    let done = devices.is_some();
    if !done {
        tell!("interrupted");
    }
    if rows.is_empty() {
        return Ok(ExitCode::from(130));
    }
    let faults: f64 = rows.iter().filter_map(|row| row.get("faults")).sum();
    if faults > 0.0 {
        tell!("warning: {faults} deposits, addends or media were dropped, clamped or not finite");
    }
    let results = results(plan, scene, &rows, devices.as_deref().unwrap_or_default())?;
    if let Some(folder) = folder {
        write(folder, &rows, &results)?;
    }
    if options.json {
        say(serde_json::to_string_pretty(&results.iter().map(|(_, result)| result).collect::<Vec<_>>())?)?;
    } else {
        say(table(&results).trim_end())?;
    }
    Ok(if done { ExitCode::SUCCESS } else { ExitCode::from(130) })
}

/// Removes the results of the run that left this table; those of others stay.
fn forget(folder: &Path, table: &Path) -> anyhow::Result<()> {
    let rows = std::fs::read(table).ok().and_then(|bytes| row::decode(&bytes).ok()).unwrap_or_default();
    let identities: BTreeSet<&str> = rows.iter().map(|row| row.identity.as_str()).collect();
    identities.into_iter().try_for_each(|identity| remove(&store::file(folder, identity)))
}

/// A result a cell, by the cell's name.
fn results(
    plan: &Plan,
    scene: &Scene,
    rows: &[Row],
    devices: &[String],
) -> anyhow::Result<Vec<(String, CellResult)>> {
    let scene = posed(scene, plan.time_of(plan.frames.start))?;
    reference::camera(&scene, &plan.camera)?;
    let first = plan.cells.first().context("there is no cell")?;
    let of_cell = |(index, cell): (usize, &caustics::experiment::cell::Cell)| {
        let time = cell_time(plan, &scene, cell, first, rows);
        let wall_s = rows
            .iter()
            .filter(|row| row.cell == cell.name)
            .filter_map(|row| row.get("total_ms"))
            .sum::<f64>()
            / 1e3;
        let device = devices.get(index).cloned().unwrap_or_default();
        let result = CellResult {
            identity: identity::of_cell(plan, cell, &scene),
            cell: cell.config(&scene, &plan.camera, &plan.settings),
            time,
            provenance: provenance(device, plan.settings.seed, wall_s),
            ..CellResult::default()
        };
        (cell.name.clone(), result)
    };
    Ok(plan.cells.iter().enumerate().map(of_cell).collect())
}

fn write(folder: &Path, rows: &[Row], results: &[(String, CellResult)]) -> anyhow::Result<()> {
    for (_, result) in results {
        store::write(folder, result)?;
    }
    let put = |name: &str, bytes: Vec<u8>| Target::claim(&folder.join(name), true)?.finish(&bytes);
    put("frames.csv", row::encode(rows)?)?;
    put("passes.csv", passes_csv(results)?)?;
    Ok(())
}
