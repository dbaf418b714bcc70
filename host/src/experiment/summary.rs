//! What all frames of a cell amount to, and how it stands to the first cell and to the one without history.

use std::collections::BTreeMap;

use serde::Serialize;

use super::cell::Cell;
use super::gain::gain;
use super::row::Row;
use crate::metric::percentile::quantile;

/// A cell over all frames; measures that were not taken are null.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CellSummary {
    /// Frames.
    pub frames: usize,
    /// Percentiles of the total time (ms).
    pub total_ms: Option<Percentiles>,
    /// Median total time over that of the first cell.
    pub ratio_of_medians: Option<f64>,
    /// Median over frames of the total time over that of the first cell in the same frame.
    pub paired_ratio: Option<f64>,
    /// Mean time of each pass in a frame (ms); `animate` and `pose` bring scene and session to its pose.
    pub pass_ms: BTreeMap<String, f64>,
    /// Means over frames of every measure of error.
    pub mean: BTreeMap<&'static str, f64>,
    /// Median gain.
    pub median_gain: Option<f64>,
    /// Frames whose FLIP is above that of the cell without history.
    pub frames_flip_above_none: Option<usize>,
    /// The same of the caustics alone.
    pub frames_flip_caustics_above_none: Option<usize>,
}

/// Between values, as [`quantile`] has them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Percentiles {
    /// One in twenty is below.
    pub p5: f64,
    /// The median.
    pub median: f64,
    /// One in twenty is above.
    pub p95: f64,
}

/// Measures of error that are averaged over frames.
const ERRORS: [&str; 7] = [
    "flip",
    "flip_caustics",
    "relmse",
    "relmse_caustics",
    "flicker",
    "flicker_caustics",
    "caustics_variance_radiance2",
];

/// Sets the gain of each row: the variance of its frame's row without history over its own.
pub fn set_gains(rows: &mut [Row], cells: &[Cell]) {
    const VARIANCE: &str = "caustics_variance_radiance2";
    let baseline: BTreeMap<String, String> = cells
        .iter()
        .filter_map(|cell| Some((cell.name.clone(), cell.baseline(cells)?.name.clone())))
        .collect();
    let variances: BTreeMap<(String, u32), f64> =
        rows.iter().filter_map(|row| Some(((row.cell.clone(), row.frame), row.get(VARIANCE)?))).collect();
    for row in rows {
        let none = baseline.get(&row.cell);
        let none = none.and_then(|none| variances.get(&(none.clone(), row.frame)).copied());
        let value = none.zip(row.get(VARIANCE)).and_then(|(none, own)| gain(none, own));
        row.values.remove("gain");
        row.set("gain", value);
    }
}

/// A summary of each cell, in their order.
pub fn summarise(rows: &[Row], cells: &[Cell]) -> Vec<(String, CellSummary)> {
    let series = |cell: &str, name: &str| -> BTreeMap<u32, f64> {
        let rows = rows.iter().filter(|row| row.cell == cell);
        rows.filter_map(|row| Some((row.frame, row.get(name)?))).collect()
    };
    let Some(first) = cells.first().map(|cell| series(&cell.name, "total_ms")) else { return Vec::new() };
    let of_cell = |cell: &Cell| {
        let name = cell.name.clone();
        let own: Vec<&Row> = rows.iter().filter(|row| row.cell == name).collect();
        let totals = series(&name, "total_ms");
        let ratios: Vec<f64> = totals.iter().filter_map(|(k, total)| Some(total / first.get(k)?)).collect();
        let above_none = |measure: &str| {
            let none = cell.baseline(cells).map(|none| series(&none.name, measure)).unwrap_or_default();
            let own = series(&name, measure);
            let above = own.iter().filter(|(frame, value)| none.get(frame).is_some_and(|none| *value > none));
            let count = above.count();
            (!own.is_empty() && !none.is_empty()).then_some(count)
        };
        let mut pass_ms = BTreeMap::new();
        // What brings the scene and the session to the frame's pose belongs to the frame.
        let posing = |row: &&Row| {
            ["animate", "pose"]
                .map(|name| Some((name, row.get(&format!("{name}_ms"))?)))
                .into_iter()
                .flatten()
        };
        for (pass, time) in own.iter().flat_map(|row| row.passes().chain(posing(row)).collect::<Vec<_>>()) {
            *pass_ms.entry(pass.to_string()).or_insert(0.0) += time / own.len() as f64;
        }
        let mean = |measure: &&'static str| Some((*measure, mean(&values(&series(&name, measure)))?));
        let summary = CellSummary {
            frames: own.len(),
            total_ms: percentiles(&values(&totals)),
            ratio_of_medians: median(&values(&totals))
                .zip(median(&values(&first)))
                .map(|(own, first)| own / first),
            paired_ratio: median(&ratios),
            pass_ms,
            mean: ERRORS.iter().filter_map(mean).collect(),
            median_gain: median(&values(&series(&name, "gain"))),
            frames_flip_above_none: above_none("flip"),
            frames_flip_caustics_above_none: above_none("flip_caustics"),
        };
        (name, summary)
    };
    cells.iter().map(of_cell).collect()
}

fn values(series: &BTreeMap<u32, f64>) -> Vec<f64> {
    series.values().copied().collect()
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn median(values: &[f64]) -> Option<f64> {
    percentiles(values).map(|of| of.median)
}

fn percentiles(values: &[f64]) -> Option<Percentiles> {
    let at = |part| quantile(values, part);
    (!values.is_empty()).then(|| Percentiles { p5: at(0.05), median: at(0.5), p95: at(0.95) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustics_kernels::history::{self, History};
    use caustics_kernels::method::basic::BASIC;

    const OTHER: History = History { name: "other", ..history::NONE };

    fn cells() -> [Cell; 2] {
        let named = |history: &'static History| format!("basic-{}", history.name);
        [&history::NONE, &OTHER].map(|history| Cell { name: named(history), history, ..Cell::of(&BASIC) })
    }

    fn rows() -> Vec<Row> {
        let row = |cell: &Cell, frame: u32, total: f64, flip: f64, variance: f64| Row {
            frame,
            cell: cell.name.clone(),
            values: [
                ("total_ms", total),
                ("pass.collect_ms", total / 2.0),
                ("flip", flip),
                ("caustics_variance_radiance2", variance),
            ]
            .map(|(name, value)| (name.to_string(), value))
            .into(),
            ..Row::default()
        };
        let [none, other] = cells();
        // The machine is twice as slow in the frames 3 and 4; the other cell costs 1.1 of the first in each frame.
        let slow = [1.0, 1.0, 1.0, 2.0, 2.0];
        let mut rows = Vec::new();
        for (frame, slow) in (0..).zip(slow) {
            rows.push(row(&none, frame, 10.0 * slow, 0.2, 0.9));
            rows.push(row(&other, frame, 11.0 * slow, if frame == 2 { 0.3 } else { 0.1 }, 0.1));
        }
        rows
    }

    #[test]
    fn ratios_are_paired_frame_by_frame() {
        let mut rows = rows();
        // Without its third row the second cell's median is of slow frames.
        rows.retain(|row| row.cell == "basic-none" || row.frame > 1);
        let summary = summarise(&rows, &cells());
        let (name, other) = &summary[1];
        assert_eq!(name, "basic-other");
        assert!((other.paired_ratio.unwrap() - 1.1).abs() < 1e-12, "{other:?}");
        assert!((other.ratio_of_medians.unwrap() - 2.2).abs() < 1e-12, "{other:?}");
        assert_eq!(other.frames, 3);
        assert_eq!(summary[0].1.total_ms.unwrap(), Percentiles { p5: 10.0, median: 10.0, p95: 20.0 });
        assert_eq!(summary[0].1.pass_ms["collect"], 7.0);
    }

    #[test]
    fn gains_and_frames_above_none_are_held_against_the_cell_without_history() {
        let mut rows = rows();
        set_gains(&mut rows, &cells());
        let gains: Vec<f64> = rows.iter().map(|row| row.get("gain").unwrap()).collect();
        for (index, gain) in gains.iter().enumerate() {
            assert!((gain - if index % 2 == 0 { 1.0 } else { 9.0 }).abs() < 1e-12, "{gains:?}");
        }
        let summary = summarise(&rows, &cells());
        assert_eq!(summary[0].1.frames_flip_above_none, Some(0));
        assert_eq!(summary[1].1.frames_flip_above_none, Some(1));
        assert!((summary[1].1.mean["flip"] - 0.14).abs() < 1e-12);
        // Without the cell that has no history there is nothing to gain over.
        rows.retain(|row| row.cell != "basic-none");
        set_gains(&mut rows, &cells()[1..]);
        assert!(rows.iter().all(|row| row.get("gain").is_none()));
        assert_eq!(summarise(&rows, &cells()[1..])[0].1.frames_flip_above_none, None);
    }
}
