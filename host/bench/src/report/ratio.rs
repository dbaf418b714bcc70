//! Ratios of run configurations to the first one that took turns with them. A disturbance of the machine affects both.

use super::load::Measured;
use super::name::Names;
use super::scene::ReportScene;
use super::table::{Column, Table, TableValue};
use crate::error::{MEASURES, Measure};

/// Table of ratios; none where only first configurations have one.
pub fn ratios(scene: &ReportScene, names: &Names) -> Option<Table> {
    let ratio = |run: &Measured| run.result.time.as_ref().and_then(|time| time.ratio_to_first);
    let runs: Vec<&Measured> = scene.runs.iter().copied().filter(|run| ratio(run).is_some()).collect();
    if runs.len() < 2 {
        return None;
    }
    let first_name =
        |run: &Measured| run.result.time.as_ref().map(|time| time.first.clone()).unwrap_or_default();
    let turns = |run: &Measured| (first_name(run), names.origin(run));
    // The first configuration is compared with itself: its ratio is exactly 1.
    let first = |run: &Measured| {
        let mut firsts = runs.iter().filter(|other| turns(other) == turns(run) && ratio(other) == Some(1.0));
        match (firsts.next(), firsts.next()) {
            (Some(first), None) => Some(*first),
            _ => None,
        }
    };
    let error = |measure: &Measure| {
        let value = |run: &Measured| run.result.error.as_ref()?.get(measure);
        let part = |run: &Measured| Some(value(run)? / value(first(run)?)?).filter(|ratio| ratio.is_finite());
        runs.iter().map(|run| TableValue::number(part(run))).collect()
    };
    let text =
        |value: &dyn Fn(&Measured) -> String| runs.iter().map(|run| TableValue::Text(value(run))).collect();
    let of_first = |run: &Measured| first(run).map_or_else(|| first_name(run), |first| names.label(first));
    let column = |head, key: &str, values| Column { head, key: key.into(), values };
    let mut columns = vec![
        column("configuration", "cell", text(&|run| names.label(run))),
        column("held against", "first", text(&of_first)),
        column("time", "time_ratio", runs.iter().map(|run| TableValue::number(ratio(run))).collect()),
    ];
    columns.extend(
        MEASURES.map(|measure| column(measure.head, &format!("{}_ratio", measure.key), error(measure))),
    );
    let title = format!("{}: ratios to the first configuration", scene.title);
    Some(Table { name: format!("{}-ratios", scene.slug), title, columns }.without_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::FLIP;
    use crate::parameter::METHOD;
    use crate::report::scene::scenes;
    use crate::result::{ConfigValues, ErrorResult, RunResult, TimeResult};

    #[test]
    fn errors_are_divided_by_those_of_the_first_configuration() {
        let run = |method: &str, ratio: Option<f64>, flip: Option<f64>| Measured {
            result: RunResult {
                config: ConfigValues::default().with(&METHOD, method),
                time: Some(TimeResult {
                    ratio_to_first: ratio,
                    first: "kim".into(),
                    ..TimeResult::default()
                }),
                error: Some(ErrorResult::default().with(&FLIP, flip)),
                ..RunResult::default()
            },
            folder: "".into(),
        };
        let runs = [
            run("kim2019", Some(1.0), Some(0.4)),
            run("basic", Some(0.9), Some(0.1)),
            run("path", Some(2.0), None),
            run("yang2021", None, Some(0.2)),
        ];
        let rows = ratios(&scenes(&runs)[0], &Names::new(&runs)).unwrap().rows();
        assert_eq!(rows[0], ["cell", "first", "time_ratio", "flip_ratio"]);
        assert_eq!(
            rows[1..],
            [
                ["kim2019", "kim2019", "1", "1"],
                ["basic", "kim2019", "0.9", "0.25"],
                ["path", "kim2019", "2", ""]
            ]
        );
        assert!(ratios(&scenes(&runs[3..])[0], &Names::new(&runs)).is_none());
    }
}
