//! All cells of a scene as a table, and everything that is known of all cells as CSV.

use std::collections::BTreeSet;

use super::load::Measured;
use super::name::Names;
use super::number::short;
use super::scene::ReportScene;
use super::table::{Column, Table, TableValue};
use crate::error::MEASURES;
use crate::parameter::{PARAMETERS, Parameter, Values};
use crate::result::{CellResult, CellTime};

type TimeValue<T> = fn(&T) -> Option<f64>;
/// What was timed.
const TIMES: [(&str, &str, TimeValue<CellTime>); 11] = [
    ("time [ms]", "median_ms", |time| Some(time.total_ms.median)),
    ("first quartile [ms]", "lower_quartile_ms", |time| Some(time.total_ms.lower)),
    ("third quartile [ms]", "upper_quartile_ms", |time| Some(time.total_ms.upper)),
    ("frames", "frames", |time| Some(f64::from(time.frames))),
    ("light paths", "light_paths", |time| Some(f64::from(time.light_paths))),
    ("M rays", "rays_m", |time| Some(time.rays * 1e-6).filter(|rays| *rays > 0.0)),
    ("M rays/s", "rays_m_per_s", |time| Some(time.rays_per_s * 1e-6).filter(|rate| *rate > 0.0)),
    ("M light paths/s", "light_paths_m_per_s", |time| Some(time.light_paths_per_s? * 1e-6)),
    ("M points/s", "points_m_per_s", |time| Some(time.points_per_s? * 1e-6)),
    ("memory [MiB]", "memory_mib", |time| (!time.memory_bytes.is_empty()).then(|| mebibytes(time))),
    ("time/first", "ratio_to_first", |time| time.ratio_to_first),
];
fn mebibytes(time: &CellTime) -> f64 {
    time.memory_bytes.values().map(|bytes| *bytes as f64).sum::<f64>() / (1024.0 * 1024.0)
}

fn setting(value: Option<f64>) -> TableValue {
    value.map_or(TableValue::None, |value| TableValue::Number(value, short(value)))
}

/// Columns of cells.
fn columns(cells: &[&Measured]) -> Vec<Column> {
    let column = |head: &'static str, key: &str, value: &dyn Fn(&CellResult) -> TableValue| Column {
        head,
        key: key.into(),
        values: cells.iter().map(|cell| value(&cell.result)).collect(),
    };
    let mut columns = Vec::new();
    for parameter in PARAMETERS {
        let value = |result: &CellResult| match (parameter.values, result.cell.text(parameter)) {
            (_, text) if text.is_empty() => TableValue::None,
            (Values::Names(_), text) => TableValue::Text(text),
            (Values::Numbers(_), _) => setting(Some(result.cell.number(parameter))),
        };
        columns.push(column(parameter.head, parameter.key, &value));
    }
    for (head, key, time_value) in TIMES {
        let whole = ["frames", "light_paths"].contains(&key);
        columns.push(column(head, key, &|result| {
            let value = result.time.as_ref().and_then(time_value);
            if whole {
                value.map_or(TableValue::None, |value| TableValue::Number(value, value.to_string()))
            } else {
                TableValue::number(value)
            }
        }));
    }
    for measure in MEASURES {
        let value = |result: &CellResult| {
            TableValue::number(result.error.as_ref().and_then(|error| error.get(measure)))
        };
        columns.push(column(measure.head, measure.key, &value));
    }
    let seeds = |result: &CellResult| setting(result.error.as_ref().map(|error| f64::from(error.seeds)));
    columns.push(column("seeds", "seeds", &seeds));
    columns
}

/// The table of a scene, and what all its cells have in common.
pub fn table(scene: &ReportScene) -> (Table, Vec<(&'static str, String)>) {
    let mut common = Vec::new();
    let columns = columns(&scene.cells).into_iter().filter(|column| {
        let is_setting =
            Parameter::find(&column.key).is_some() || ["frames", "seeds"].contains(&column.key.as_str());
        let is_constant = column.values.len() > 1 && column.values.windows(2).all(|pair| pair[0] == pair[1]);
        if is_setting && is_constant {
            match &column.values[0] {
                TableValue::Text(text) | TableValue::Number(_, text) => {
                    common.push((column.head, text.clone()));
                }
                TableValue::None => {}
            }
        }
        !(is_setting && is_constant)
    });
    let columns = columns.collect();
    let name = format!("{}-cells", scene.slug);
    let table = Table { name, title: format!("{}: all cells", scene.title), columns }.without_empty();
    (table, common)
}

/// Everything of all cells: a row a cell, with every pass and every buffer.
pub fn all(cells: &[Measured], names: &Names) -> Vec<Vec<String>> {
    let all: Vec<&Measured> = cells.iter().collect();
    let text = |head, key: &str, value: &dyn Fn(&Measured) -> String| Column {
        head,
        key: key.into(),
        values: cells.iter().map(|cell| TableValue::Text(value(cell))).collect(),
    };
    let mut wide = vec![
        text("", "identity", &|cell| cell.result.identity.clone()),
        text("", "cell", &|cell| names.label(cell)),
        text("", "scene", &|cell| cell.result.cell.scene.clone()),
        text("", "camera", &|cell| cell.result.cell.camera.clone()),
    ];
    wide.extend(columns(&all));
    let times = || cells.iter().filter_map(|cell| cell.result.time.as_ref());
    let passes: BTreeSet<&String> = times().flat_map(|time| time.pass_ms.keys()).collect();
    for pass in passes {
        let median_ms = |cell: &Measured| Some(cell.result.time.as_ref()?.pass_ms.get(pass)?.median);
        let values = cells.iter().map(|cell| TableValue::number(median_ms(cell))).collect();
        wide.push(Column { head: "", key: format!("pass.{pass}_ms"), values });
    }
    let buffers: BTreeSet<&String> = times().flat_map(|time| time.memory_bytes.keys()).collect();
    for buffer in buffers {
        let bytes = |cell: &Measured| Some(*cell.result.time.as_ref()?.memory_bytes.get(buffer)? as f64);
        let values = cells.iter().map(|cell| TableValue::number(bytes(cell))).collect();
        wide.push(Column { head: "", key: format!("memory.{buffer}_bytes"), values });
    }
    wide.push(text("", "device", &|cell| cell.result.provenance.device.clone()));
    wide.push(text("", "commit", &|cell| cell.result.provenance.commit.clone()));
    Table { name: "cells".into(), title: String::new(), columns: wide }.rows()
}
