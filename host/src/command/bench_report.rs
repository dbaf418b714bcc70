//! What `bench` leaves beside its rows: summary, table and figures.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use caustics::experiment::cell::Cell;
use caustics::experiment::cost::{Cost, costs};
use caustics::experiment::figure::{self, Series};
use caustics::experiment::identity::posed;
use caustics::experiment::memory::memory;
use caustics::experiment::plan::Plan;
use caustics::experiment::reference::camera;
use caustics::experiment::row::Row;
use caustics::experiment::summary::{CellSummary, summarise};
use caustics::kernels;
use caustics::output::target::Target;
use caustics::scene::Scene;
use caustics::trace_rate::closest_hits_per_second;
use caustics_kernels::declare::TextureFilter;
use caustics_kernels::history;
use serde_json::json;

use super::say::say;

/// Writes `summary.json` and the figures into the folder, and prints the table.
pub fn report(plan: &Plan, scene: &Scene, rows: &[Row], folder: &Path, as_json: bool) -> anyhow::Result<()> {
    let summary = summarise(rows, &plan.cells);
    let faults: f64 = rows.iter().filter_map(|row| row.get("faults")).sum();
    if faults > 0.0 {
        tell!(
            "warning: {faults} deposits, addends or media were dropped, clamped or not finite: see frames.csv"
        );
    }
    let posed = posed(scene, plan.time_of(plan.frames.start))?;
    let mut hits_per_s = None;
    if let Some(first) = plan.cells.first().filter(|_| plan.time) {
        let features = first.features(&posed, plan.settings.specular_roughness);
        hits_per_s =
            Some(closest_hits_per_second(&first.runner, &posed, camera(&posed, &plan.camera)?, features)?);
    }
    let of_cell = |cell: &Cell| -> Option<BTreeMap<String, Cost>> {
        let own: Vec<&Row> = rows.iter().filter(|row| row.cell == cell.name).collect();
        let without = Cell { history: &history::NONE, ..cell.clone() };
        let without = memory(plan, &without, &posed)?;
        Some(costs(plan, &own, &memory(plan, cell, &posed)?, &without, hits_per_s?))
    };
    let costs: Vec<_> = plan.cells.iter().map(|cell| of_cell(cell).unwrap_or_default()).collect();
    let settings = &plan.settings;
    let cells: BTreeMap<_, _> = (0..plan.cells.len())
        .map(|index| {
            let (name, own) = &summary[index];
            let memory = memory(plan, &plan.cells[index], &posed);
            (name, json!({ "measures": own, "memory": memory, "cost": costs[index], "what": plan.cells[index].key() }))
        })
        .collect();
    let error =
        plan.error.map(|error| json!({ "seeds": error.seeds, "reference_frames": error.reference_frames }));
    let out = json!({
        "scene": scene.name, "camera": plan.camera, "width": settings.width, "height": settings.height,
        "texture_filter": settings.texture_filter.map(TextureFilter::name),
        "light_paths": plan.cells.first().map(|cell| cell.settings(settings).light_paths),
        "max_bounces": plan.cells.first().map(|cell| cell.max_bounces),
        "first_frame": plan.frames.start, "end_frame": plan.frames.end, "fps": plan.fps,
        "seed": settings.seed, "error": error, "warm_up": plan.warm_up, "gather": plan.cells.first().map(Cell::gather_name),
        "runner": plan.cells.first().map(|cell| format!("{:?}", cell.runner)), "commit": env!("CAUSTICS_COMMIT"),
        "kernels": kernels::SOURCES, "closest_hits_per_s": hits_per_s, "cells": cells,
    });
    let text = serde_json::to_string_pretty(&out)?;
    write(folder, "summary.json", &text)?;
    figures(plan, rows, &summary, folder)?;
    if as_json {
        say(text)?;
    } else {
        say(table(&summary, &costs).trim_end())?;
    }
    Ok(())
}

fn write(folder: &Path, name: &str, text: &str) -> anyhow::Result<()> {
    Ok(Target::claim(&folder.join(name), true)?.finish(text.as_bytes())?)
}

fn figures(
    plan: &Plan,
    rows: &[Row],
    summary: &[(String, CellSummary)],
    folder: &Path,
) -> anyhow::Result<()> {
    let of_cell = |cell: &Cell, measure: &str| {
        let name = cell.name.clone();
        let own = rows.iter().filter(|row| row.cell == name);
        let points = own.filter_map(|row| Some((f64::from(row.frame), row.get(measure)?))).collect();
        Series { name, points }
    };
    let draw = |file: &str, title: &str, axis: &str, measure: &str| -> anyhow::Result<()> {
        let series: Vec<Series> = plan.cells.iter().map(|cell| of_cell(cell, measure)).collect();
        let series: Vec<Series> = series.into_iter().filter(|line| !line.points.is_empty()).collect();
        if series.is_empty() {
            tell!("warning: {file}: no frame has this measure, and no figure is drawn");
            return Ok(());
        }
        write(folder, file, &figure::lines(title, axis, &series)?)
    };
    if plan.time {
        draw("frame-time.svg", "Time of a frame", "time of a frame [ms]", "total_ms")?;
        let bars: Vec<_> = summary.iter().map(|(name, own)| (name.clone(), own.pass_ms.clone())).collect();
        write(folder, "passes.svg", &figure::passes("Time of a frame by pass", &bars)?)?;
    }
    if plan.error.is_some() {
        draw("flip.svg", "Error of a frame, as seen", "mean FLIP [0 to 1]", "flip")?;
        let title = "Error of the caustics of a frame, as seen";
        draw("flip-caustics.svg", title, "mean FLIP [0 to 1]", "flip_caustics")?;
        let axis = "variance without history / variance [1]";
        draw("gain.svg", "Effective sample gain of the caustics", axis, "gain")?;
    }
    Ok(())
}

/// A line a cell and column a measure, then expected and measured work of the passes.
fn table(summary: &[(String, CellSummary)], costs: &[BTreeMap<String, Cost>]) -> String {
    let mut text = String::new();
    let wide = summary.iter().map(|(name, _)| name.len()).max().unwrap_or(0).max(4);
    let number = |value: Option<f64>, digits: usize| value.map_or("-".into(), |v| format!("{v:.digits$}"));
    let mean = |own: &CellSummary, name: &str, digits| number(own.mean.get(name).copied(), digits);
    let whole = |value: Option<usize>| value.map_or("-".into(), |value| value.to_string());
    let heads = [
        "p5 ms",
        "median ms",
        "p95 ms",
        "paired",
        "FLIP",
        "above none",
        "caustics",
        "relMSE",
        "flicker",
        "gain",
    ];
    let line = |name: &str, cells: Vec<String>| {
        cells.iter().fold(format!("{name:wide$}"), |line, cell| format!("{line} {cell:>10}")) + "\n"
    };
    text += &line("cell", heads.map(String::from).into());
    for (name, own) in summary {
        text += &line(
            name,
            vec![
                number(own.total_ms.map(|of| of.p5), 2),
                number(own.total_ms.map(|of| of.median), 2),
                number(own.total_ms.map(|of| of.p95), 2),
                number(own.paired_ratio, 3),
                mean(own, "flip", 4),
                whole(own.frames_flip_above_none),
                mean(own, "flip_caustics", 4),
                mean(own, "relmse", 4),
                mean(own, "flicker", 4),
                number(own.median_gain, 2),
            ],
        );
    }
    for ((name, _), costs) in summary.iter().zip(costs) {
        for (pass, cost) in costs {
            let unit = if cost.rays.is_some() { "M rays/s" } else { "MB/s" };
            let expected =
                cost.expected_ms.map_or(String::new(), |ms| format!(", {ms:.2} ms by the tracer alone"));
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "{name:wide$} {pass}: {:.2} ms, {:.1} {unit}{expected}",
                cost.ms,
                cost.rate_per_s / 1e6
            );
        }
    }
    text
}
