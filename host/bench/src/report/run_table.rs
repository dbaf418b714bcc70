//! Table of all run configurations of a scene, and CSV of everything known about all configurations.

use std::collections::BTreeSet;

use super::load::Measured;
use super::name::Names;
use super::number::short;
use super::scene::ReportScene;
use super::table::{Column, Table, TableValue};
use crate::error::MEASURES;
use crate::parameter::{PARAMETERS, Parameter, Values};
use crate::result::{RunResult, TimeResult};

type TimeValue<T> = fn(&T) -> Option<f64>;
/// Columns of times: heading, key and value.
const TIMES: [(&str, &str, TimeValue<TimeResult>); 11] = [
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
fn mebibytes(time: &TimeResult) -> f64 {
    time.memory_bytes.values().map(|bytes| *bytes as f64).sum::<f64>() / (1024.0 * 1024.0)
}

fn setting(value: Option<f64>) -> TableValue {
    value.map_or(TableValue::None, |value| TableValue::Number(value, short(value)))
}

/// Returns the columns of run configurations.
fn columns(runs: &[&Measured]) -> Vec<Column> {
    let column = |head: &'static str, key: &str, value: &dyn Fn(&RunResult) -> TableValue| Column {
        head,
        key: key.into(),
        values: runs.iter().map(|run| value(&run.result)).collect(),
    };
    let mut columns = Vec::new();
    for parameter in PARAMETERS {
        let value = |result: &RunResult| match (parameter.values, result.config.text(parameter)) {
            (_, text) if text.is_empty() => TableValue::None,
            (Values::Names(_), text) => TableValue::Text(text),
            (Values::Numbers(_), _) => setting(Some(result.config.number(parameter))),
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
        let value = |result: &RunResult| {
            TableValue::number(result.error.as_ref().and_then(|error| error.get(measure)))
        };
        columns.push(column(measure.head, measure.key, &value));
    }
    let seeds = |result: &RunResult| setting(result.error.as_ref().map(|error| f64::from(error.seeds)));
    columns.push(column("seeds", "seeds", &seeds));
    columns
}

/// Table of a scene, and the values that all its run configurations share.
pub fn table(scene: &ReportScene) -> (Table, Vec<(&'static str, String)>) {
    let mut common = Vec::new();
    let columns = columns(&scene.runs).into_iter().filter(|column| {
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
    let table =
        Table { name, title: format!("{}: all run configurations", scene.title), columns }.without_empty();
    (table, common)
}

/// CSV rows of all run configurations, with every pass and every buffer.
pub fn all(runs: &[Measured], names: &Names) -> Vec<Vec<String>> {
    let all: Vec<&Measured> = runs.iter().collect();
    let text = |head, key: &str, value: &dyn Fn(&Measured) -> String| Column {
        head,
        key: key.into(),
        values: runs.iter().map(|run| TableValue::Text(value(run))).collect(),
    };
    let mut wide = vec![
        text("", "identity", &|run| run.result.identity.clone()),
        text("", "cell", &|run| names.label(run)),
        text("", "scene", &|run| run.result.config.scene.clone()),
        text("", "camera", &|run| run.result.config.camera.clone()),
    ];
    wide.extend(columns(&all));
    let times = || runs.iter().filter_map(|run| run.result.time.as_ref());
    let passes: BTreeSet<&String> = times().flat_map(|time| time.pass_ms.keys()).collect();
    for pass in passes {
        let median_ms = |run: &Measured| Some(run.result.time.as_ref()?.pass_ms.get(pass)?.median);
        let values = runs.iter().map(|run| TableValue::number(median_ms(run))).collect();
        wide.push(Column { head: "", key: format!("pass.{pass}_ms"), values });
    }
    let buffers: BTreeSet<&String> = times().flat_map(|time| time.memory_bytes.keys()).collect();
    for buffer in buffers {
        let bytes = |run: &Measured| Some(*run.result.time.as_ref()?.memory_bytes.get(buffer)? as f64);
        let values = runs.iter().map(|run| TableValue::number(bytes(run))).collect();
        wide.push(Column { head: "", key: format!("memory.{buffer}_bytes"), values });
    }
    wide.push(text("", "device", &|run| run.result.provenance.device.clone()));
    wide.push(text("", "commit", &|run| run.result.provenance.commit.clone()));
    Table { name: "cells".into(), title: String::new(), columns: wide }.rows()
}
