//! Ratios of cells to the first cell of their run, measured in turn with it, so that a noisy machine disturbs both.

use super::load::Measured;
use super::name::Names;
use super::scene::ReportScene;
use super::table::{Column, Table, TableValue};
use crate::error::{MEASURES, Measure};

/// The table; none where no cell but the first of a run has a ratio.
pub fn ratios(scene: &ReportScene, names: &Names) -> Option<Table> {
    let ratio = |cell: &Measured| cell.result.time.as_ref().and_then(|time| time.ratio_to_first);
    let cells: Vec<&Measured> = scene.cells.iter().copied().filter(|cell| ratio(cell).is_some()).collect();
    if cells.len() < 2 {
        return None;
    }
    let first_name =
        |cell: &Measured| cell.result.time.as_ref().map(|time| time.first.clone()).unwrap_or_default();
    let run = |cell: &Measured| (first_name(cell), names.origin(cell));
    // The first cell of a run is held against itself: its ratio is 1 to the bit.
    let first = |cell: &Measured| {
        let mut firsts = cells.iter().filter(|other| run(other) == run(cell) && ratio(other) == Some(1.0));
        match (firsts.next(), firsts.next()) {
            (Some(first), None) => Some(*first),
            _ => None,
        }
    };
    let error = |measure: &Measure| {
        let value = |cell: &Measured| cell.result.error.as_ref()?.get(measure);
        let part =
            |cell: &Measured| Some(value(cell)? / value(first(cell)?)?).filter(|ratio| ratio.is_finite());
        cells.iter().map(|cell| TableValue::number(part(cell))).collect()
    };
    let text = |value: &dyn Fn(&Measured) -> String| {
        cells.iter().map(|cell| TableValue::Text(value(cell))).collect()
    };
    let of_first = |cell: &Measured| first(cell).map_or_else(|| first_name(cell), |first| names.label(first));
    let column = |head, key: &str, values| Column { head, key: key.into(), values };
    let mut columns = vec![
        column("cell", "cell", text(&|cell| names.label(cell))),
        column("held against", "first", text(&of_first)),
        column("time", "time_ratio", cells.iter().map(|cell| TableValue::number(ratio(cell))).collect()),
    ];
    columns.extend(
        MEASURES.map(|measure| column(measure.head, &format!("{}_ratio", measure.key), error(measure))),
    );
    let title = format!("{}: ratios to the first cell of the run", scene.title);
    Some(Table { name: format!("{}-ratios", scene.slug), title, columns }.without_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::FLIP;
    use crate::parameter::METHOD;
    use crate::report::scene::scenes;
    use crate::result::{CellConfig, CellError, CellResult, CellTime};

    #[test]
    fn errors_are_divided_by_those_of_the_first_cell() {
        let cell = |method: &str, ratio: Option<f64>, flip: Option<f64>| Measured {
            result: CellResult {
                cell: CellConfig::default().with(&METHOD, method),
                time: Some(CellTime { ratio_to_first: ratio, first: "kim".into(), ..CellTime::default() }),
                error: Some(CellError::default().with(&FLIP, flip)),
                ..CellResult::default()
            },
            folder: "".into(),
        };
        let cells = [
            cell("kim2019", Some(1.0), Some(0.4)),
            cell("basic", Some(0.9), Some(0.1)),
            cell("path", Some(2.0), None),
            cell("yang2021", None, Some(0.2)),
        ];
        let rows = ratios(&scenes(&cells)[0], &Names::new(&cells)).unwrap().rows();
        assert_eq!(rows[0], ["cell", "first", "time_ratio", "flip_ratio"]);
        assert_eq!(
            rows[1..],
            [
                ["kim2019", "kim2019", "1", "1"],
                ["basic", "kim2019", "0.9", "0.25"],
                ["path", "kim2019", "2", ""]
            ]
        );
        assert!(ratios(&scenes(&cells[3..])[0], &Names::new(&cells)).is_none());
    }
}
