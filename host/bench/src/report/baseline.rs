//! Before and after: the same run configurations in other results, and whether differences exceed the noise.

use super::load::Measured;
use super::name::{Names, size};
use super::table::{Column, Table, TableValue};
use crate::error::{MEASURES, Measure};
use crate::result::Quartiles;

/// Number of standard errors from which a difference is significant.
const MIN_SIGNIFICANT: f64 = 3.0;

/// A value before and after.
struct Change {
    run: String,
    what: &'static str,
    before: f64,
    after: f64,
    /// Difference over its standard error; none where neither seeds nor frames give one.
    z: Option<f64>,
}

/// Times and errors of run configurations that both have; none where they share none.
pub fn changes(before: &[Measured], after: &[Measured], names: &Names) -> Option<Table> {
    let mut changes = Vec::new();
    for run in after {
        let same = |other: &&Measured| other.result.config == run.result.config && size(other) == size(run);
        let Some(other) = before.iter().find(same) else { continue };
        let name = format!("{} · {}", run.result.config.scene, names.label(run));
        if let (Some(old), Some(new)) = (&other.result.time, &run.result.time) {
            let (before, after) = (old.total_ms.median, new.total_ms.median);
            let off = deviation(&old.total_ms, old.frames).hypot(deviation(&new.total_ms, new.frames));
            changes.push(Change {
                run: name.clone(),
                what: "time [ms]",
                before,
                after,
                z: z(before, after, off),
            });
        }
        changes.extend(MEASURES.into_iter().filter_map(|measure| error_change(&name, other, run, measure)));
    }
    (!changes.is_empty()).then(|| table(&changes))
}

fn error_change(name: &str, old: &Measured, new: &Measured, measure: &'static Measure) -> Option<Change> {
    let (old, new) = (old.result.error.as_ref()?, new.result.error.as_ref()?);
    let (before, after) = (old.get(measure)?, new.get(measure)?);
    let off = old.standard_error(measure).zip(new.standard_error(measure));
    let z = off.and_then(|(old, new)| z(before, after, old.hypot(new)));
    Some(Change { run: name.into(), what: measure.head, before, after, z })
}

/// Standard error of a median from its quartiles, assuming normal noise.
fn deviation(quartiles: &Quartiles, frames: u32) -> f64 {
    1.2533 * (quartiles.upper - quartiles.lower) / 1.349 / f64::from(frames.max(1)).sqrt()
}

fn z(before: f64, after: f64, standard_error: f64) -> Option<f64> {
    let z = (after - before) / standard_error;
    z.is_finite().then_some(z)
}

/// Names a change; smaller is better for all values.
fn verdict(change: &Change) -> &'static str {
    match change.z {
        _ if change.before == change.after => "the same",
        None => "not known",
        Some(z) if z < -MIN_SIGNIFICANT => "better",
        Some(z) if z > MIN_SIGNIFICANT => "worse",
        Some(_) => "within noise",
    }
}

fn table(changes: &[Change]) -> Table {
    let column = |head, key: &str, value: &dyn Fn(&Change) -> TableValue| Column {
        head,
        key: key.into(),
        values: changes.iter().map(value).collect(),
    };
    let ratio = |change: &Change| Some(change.after / change.before).filter(|ratio| ratio.is_finite());
    let columns = vec![
        column("configuration", "cell", &|change| TableValue::Text(change.run.clone())),
        column("measure", "measure", &|change| TableValue::Text(change.what.into())),
        column("before", "before", &|change| TableValue::number(Some(change.before))),
        column("after", "after", &|change| TableValue::number(Some(change.after))),
        column("after/before", "ratio", &|change| TableValue::number(ratio(change))),
        column("standard errors", "z", &|change| TableValue::number(change.z)),
        column("", "verdict", &|change| TableValue::Text(verdict(change).into())),
    ];
    Table { name: "baseline".into(), title: "Before and after".into(), columns }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::FLIP;
    use crate::parameter::METHOD;
    use crate::result::{ConfigValues, ErrorResult, RunResult, TimeResult};

    fn run(method: &str, ms: f64, flip: f64, flip_off: f64) -> Measured {
        let mut error = ErrorResult::default().with(&FLIP, Some(flip));
        error.standard_errors.insert(FLIP.key.into(), flip_off);
        let total_ms = Quartiles { lower: ms - 1.0, median: ms, upper: ms + 1.0 };
        let result = RunResult {
            config: ConfigValues::new("a", "main").with(&METHOD, method),
            time: Some(TimeResult { total_ms, frames: 16, ..TimeResult::default() }),
            error: Some(error),
            ..RunResult::default()
        };
        Measured { result, folder: "".into() }
    }

    #[test]
    fn differences_beyond_noise_are_called_better_or_worse() {
        let before = [run("basic", 100.0, 0.1, 0.001), run("path", 50.0, 0.2, 0.01)];
        let after =
            [run("basic", 90.0, 0.11, 0.001), run("path", 50.5, 0.2, 0.01), run("new", 1.0, 0.1, 0.1)];
        let rows = changes(&before, &after, &Names::new(&after)).unwrap().rows();
        let verdicts: Vec<(&str, &str, &str)> =
            rows[1..].iter().map(|row| (row[0].as_str(), row[1].as_str(), row[6].as_str())).collect();
        assert_eq!(
            verdicts,
            [
                ("a · basic", "time [ms]", "better"),
                ("a · basic", "FLIP", "worse"),
                ("a · path", "time [ms]", "within noise"),
                ("a · path", "FLIP", "the same"),
            ]
        );
        // A difference of 0.01, with a standard error of 0.001 on both sides.
        assert!(
            (rows[2][5].parse::<f64>().unwrap() - 0.01 / 0.002_f64.hypot(0.0) * 2.0_f64.sqrt()).abs() < 1e-6
        );
        assert!(changes(&before, &after[2..], &Names::new(&after)).is_none());
    }
}
