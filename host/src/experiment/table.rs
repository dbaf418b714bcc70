//! Results as tables: for a person, and as CSV a row a pass or a cell.

use std::fmt::Write;

use super::result::{CellConfig, CellResult, Quartiles};

/// Buffers below this are not listed for a person (bytes).
const SMALL: u64 = 50_000;

/// A line a cell, then a line a cell and pass, then the largest buffers; cells by name.
pub fn table(results: &[(String, CellResult)]) -> String {
    let mut text = String::new();
    let wide = results.iter().map(|(name, _)| name.len()).max().unwrap_or(0).max(4);
    let number = |value: Option<f64>, digits: usize| value.map_or("-".into(), |v| format!("{v:.digits$}"));
    let mega = |value: Option<f64>| number(value.map(|value| value / 1e6), 2);
    let mut line = |name: &str, cells: &[String]| {
        let line = cells.iter().fold(format!("{name:wide$}"), |line, cell| format!("{line} {cell:>11}"));
        text += line.trim_end();
        text += "\n";
    };
    let heads = ["median ms", "25 %", "75 %", "ratio", "M rays/s", "M points/s", "M paths/s", "MB"];
    line("cell", &heads.map(String::from));
    for (name, result) in results {
        let Some(time) = &result.time else { continue };
        let Quartiles { lower, median, upper } = time.total_ms;
        let cells = [
            number(Some(median), 2),
            number(Some(lower), 2),
            number(Some(upper), 2),
            number(time.ratio_to_first, 3),
            mega(Some(time.rays_per_s)),
            mega(time.points_per_s),
            mega(time.light_paths_per_s),
            number(Some(time.memory_bytes.values().sum::<u64>() as f64 / 1e6), 1),
        ];
        line(name, &cells);
    }
    line("", &[]);
    line("pass", &["median ms", "25 %", "75 %"].map(String::from));
    for (name, result) in results {
        let Some(time) = &result.time else { continue };
        for (pass, Quartiles { lower, median, upper }) in &time.pass_ms {
            let cells = [*median, *lower, *upper].map(|ms| number(Some(ms), 3));
            line(name, &[&cells[..], &[format!(" {pass}")]].concat());
        }
    }
    for (name, result) in results {
        let Some(time) = &result.time else { continue };
        let mut buffers: Vec<_> = time.memory_bytes.iter().filter(|(_, bytes)| **bytes >= SMALL).collect();
        buffers.sort_by_key(|(_, bytes)| std::cmp::Reverse(**bytes));
        let list: Vec<String> =
            buffers.iter().map(|(buffer, bytes)| format!("{buffer} {:.1}", **bytes as f64 / 1e6)).collect();
        // Writing to a String cannot fail.
        let _ = write!(text, "\n{name} buffers [MB]: {}\n", list.join(", "));
    }
    text
}

/// A row a cell and pass.
pub fn passes_csv(results: &[(String, CellResult)]) -> anyhow::Result<Vec<u8>> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(["cell", "identity", "pass", "median_ms", "lower_ms", "upper_ms"])?;
    for (name, result) in results {
        for (pass, of) in result.time.iter().flat_map(|time| &time.pass_ms) {
            let times = [of.median, of.lower, of.upper].map(|ms| ms.to_string());
            let head = [name.clone(), result.identity.clone(), pass.clone()];
            table.write_record(head.iter().chain(&times))?;
        }
    }
    Ok(table.into_inner()?)
}

/// A row a cell; what was not measured is empty.
pub fn cells_csv(results: &[CellResult]) -> anyhow::Result<Vec<u8>> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record([
        "identity",
        "scene",
        "camera",
        "method",
        "gather",
        "history",
        "denoiser",
        "runner",
        "features",
        "paths_per_pixel",
        "radius_px",
        "max_bounces",
        "width",
        "height",
        "light_paths",
        "total_ms",
        "total_lower_ms",
        "total_upper_ms",
        "ratio_to_first",
        "rays_per_s",
        "points_per_s",
        "light_paths_per_s",
        "memory_bytes",
        "error_width",
        "error_height",
        "seeds",
        "flip",
        "flip_caustics",
        "relmse",
        "relmse_caustics",
        "device",
        "commit",
        "wall_s",
        "unix_s",
        "note",
    ])?;
    for result in results {
        let CellConfig { scene, camera, method, gather, history, denoiser, runner, features, .. } =
            &result.cell;
        let mut row: Vec<String> = [scene, camera, method, gather, history, denoiser, runner, features]
            .into_iter()
            .cloned()
            .collect();
        row.insert(0, result.identity.clone());
        row.push(result.cell.paths_per_pixel.to_string());
        row.push(result.cell.radius_px.to_string());
        row.push(result.cell.max_bounces.to_string());
        let (time, error) = (result.time.as_ref(), result.error.as_ref());
        let text = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
        let timed = |get: &dyn Fn(&super::result::CellTime) -> Option<f64>| text(time.and_then(get));
        row.push(timed(&|time| Some(f64::from(time.width))));
        row.push(timed(&|time| Some(f64::from(time.height))));
        row.push(timed(&|time| Some(f64::from(time.light_paths))));
        row.push(timed(&|time| Some(time.total_ms.median)));
        row.push(timed(&|time| Some(time.total_ms.lower)));
        row.push(timed(&|time| Some(time.total_ms.upper)));
        row.push(timed(&|time| time.ratio_to_first));
        row.push(timed(&|time| Some(time.rays_per_s)));
        row.push(timed(&|time| time.points_per_s));
        row.push(timed(&|time| time.light_paths_per_s));
        row.push(timed(&|time| Some(time.memory_bytes.values().sum::<u64>() as f64)));
        let off = |get: &dyn Fn(&super::result::CellError) -> Option<f64>| text(error.and_then(get));
        row.push(off(&|error| Some(f64::from(error.width))));
        row.push(off(&|error| Some(f64::from(error.height))));
        row.push(off(&|error| Some(f64::from(error.seeds))));
        row.push(off(&|error| error.flip));
        row.push(off(&|error| error.flip_caustics));
        row.push(off(&|error| error.relmse));
        row.push(off(&|error| error.relmse_caustics));
        let from = &result.provenance;
        row.extend([
            from.device.clone(),
            from.commit.clone(),
            from.wall_s.to_string(),
            from.unix_s.to_string(),
        ]);
        row.push(result.note.clone().unwrap_or_default());
        table.write_record(&row)?;
    }
    Ok(table.into_inner()?)
}
