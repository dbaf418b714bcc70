//! Overview at the top: comparison of kinds of run configurations over all scenes, in a sentence and a table.
//!
//! A kind is a name that run configurations of several scenes share. Each kind is compared, scene by scene, with one base
//! kind, which most scenes have. The table has the geometric means of the ratios, so that slow or noisy scenes count no
//! more than others.

use super::load::Measured;
use super::name::Names;
use super::number::number;
use super::scene::ReportScene;
use super::table::{Column, Table, TableValue};
use crate::error::{FLIP, MEASURES, Measure};

/// Sentence and table.
pub struct Overview {
    /// Main result of the table.
    pub sentence: String,
    /// One row per kind.
    pub table: Table,
}

/// Run configurations of one name, one per scene.
struct Kind<'a> {
    name: String,
    runs: Vec<(usize, &'a Measured)>,
}

/// Returns the overview; none where fewer than two kinds have all the scenes of the most common one.
pub fn overview(scenes: &[ReportScene], names: &Names) -> Option<Overview> {
    let mut kinds: Vec<Kind> = Vec::new();
    for (index, scene) in scenes.iter().enumerate() {
        for run in &scene.runs {
            let name = names.label(run);
            match kinds.iter_mut().find(|kind| kind.name == name) {
                // Keep the first of several configurations of a scene that have one name.
                Some(kind) if kind.runs.iter().any(|(known, _)| *known == index) => {}
                Some(kind) => kind.runs.push((index, run)),
                None => kinds.push(Kind { name, runs: vec![(index, run)] }),
            }
        }
    }
    // Choose as base the kind that most scenes have; prefer the first configuration of the turns.
    let base = kinds.iter().rev().max_by_key(|kind| (kind.runs.len(), is_first(kind)))?;
    let compared: Vec<&Kind> = kinds.iter().filter(|kind| shared(kind, base) > 0).collect();
    if compared.iter().filter(|kind| shared(kind, base) == base.runs.len()).count() < 2 {
        return None;
    }
    let column = |head, key: &str, value: &dyn Fn(&Kind) -> TableValue| Column {
        head,
        key: key.into(),
        values: compared.iter().map(|kind| value(kind)).collect(),
    };
    let mut columns = vec![
        column("configuration", "cell", &|kind| TableValue::Text(kind.name.clone())),
        column("scenes", "scenes", &|kind| {
            let count = shared(kind, base);
            TableValue::Number(count as f64, count.to_string())
        }),
        column("time", "time_ratio", &|kind| TableValue::number(ratio(kind, base, &time))),
    ];
    for measure in MEASURES.into_iter().filter(|measure| measure.charted) {
        let key = format!("{}_ratio", measure.key);
        columns.push(column(measure.head, &key, &|kind| {
            TableValue::number(ratio(kind, base, &|run| error(run, measure)))
        }));
    }
    let title = format!("Ratios to {}, geometric means over scenes", base.name);
    let table = Table { name: "overview".into(), title, columns }.without_empty();
    Some(Overview { sentence: sentence(&compared, base, scenes.len()), table })
}

/// Whether every configuration of a kind is the first one of its turns.
fn is_first(kind: &Kind) -> bool {
    let first =
        |run: &Measured| run.result.time.as_ref().is_some_and(|time| time.ratio_to_first == Some(1.0));
    kind.runs.iter().all(|(_, run)| first(run))
}

fn time(run: &Measured) -> Option<f64> {
    Some(run.result.time.as_ref()?.total_ms.median)
}

fn error(run: &Measured, measure: &Measure) -> Option<f64> {
    run.result.error.as_ref()?.get(measure)
}

/// Number of scenes that have both kinds.
fn shared(kind: &Kind, base: &Kind) -> usize {
    pairs(kind, base).count()
}

fn pairs<'a>(kind: &'a Kind, base: &'a Kind) -> impl Iterator<Item = (&'a Measured, &'a Measured)> {
    let of_base = |scene| base.runs.iter().find(|(known, _)| *known == scene).map(|(_, run)| *run);
    kind.runs.iter().filter_map(move |(scene, run)| Some((*run, of_base(*scene)?)))
}

/// Geometric mean of the ratios over the scenes in which both have a value.
fn ratio(kind: &Kind, base: &Kind, value: &dyn Fn(&Measured) -> Option<f64>) -> Option<f64> {
    let ratio = |(own, base): (&Measured, &Measured)| Some(value(own)? / value(base)?);
    let logs: Vec<f64> = pairs(kind, base)
        .filter_map(ratio)
        .filter(|ratio| ratio.is_finite() && *ratio > 0.0)
        .map(f64::ln)
        .collect();
    (!logs.is_empty()).then(|| (logs.iter().sum::<f64>() / logs.len() as f64).exp())
}

/// Sentence on the kinds that all scenes of the most common one have: the fastest, and the nearest to the reference.
fn sentence(kinds: &[&Kind], base: &Kind, scenes: usize) -> String {
    let best = |value: &dyn Fn(&Measured) -> Option<f64>| {
        let everywhere = kinds.iter().filter(|kind| shared(kind, base) == base.runs.len());
        let valued = everywhere.filter_map(|kind| Some((kind.name.as_str(), ratio(kind, base, value)?)));
        valued.min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let of_scenes =
        if scenes == 1 { "the scene".into() } else { format!("{} of {scenes} scenes", base.runs.len()) };
    let mut parts = Vec::new();
    for (words, found) in
        [("the least FLIP", best(&|run| error(run, &FLIP))), ("the shortest frame", best(&time))]
    {
        let Some((name, ratio)) = found else { continue };
        let by = if name == base.name { String::new() } else { format!(" ({} of its)", number(ratio)) };
        parts.push(format!("{words} has {name}{by}"));
    }
    format!("In {of_scenes}, held against {}: {}.", base.name, parts.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::METHOD;
    use crate::report::scene::scenes;
    use crate::result::{ConfigValues, ErrorResult, Quartiles, RunResult, TimeResult};

    fn run(scene: &str, method: &str, ms: f64, flip: f64, ratio: Option<f64>) -> Measured {
        let total_ms = Quartiles { median: ms, ..Quartiles::default() };
        let result = RunResult {
            config: ConfigValues::new(scene, "main").with(&METHOD, method),
            time: Some(TimeResult { total_ms, ratio_to_first: ratio, ..TimeResult::default() }),
            error: Some(ErrorResult::default().with(&FLIP, Some(flip))),
            ..RunResult::default()
        };
        Measured { result, folder: "".into() }
    }

    #[test]
    fn ratios_are_geometric_means_over_scenes() {
        let runs = [
            run("a", "basic", 10.0, 0.1, None),
            run("a", "path", 20.0, 0.2, Some(1.0)),
            run("b", "basic", 10.0, 0.1, None),
            run("b", "path", 80.0, 0.1, Some(1.0)),
            run("b", "kim2019", 8.0, 0.2, None),
        ];
        let found = overview(&scenes(&runs), &Names::new(&runs)).unwrap();
        let rows = found.table.rows();
        assert_eq!(rows[0], ["cell", "scenes", "time_ratio", "flip_ratio"]);
        let row_named = |name: &str| rows.iter().find(|row| row[0] == name).unwrap();
        let close = |text: &str, value: f64| (text.parse::<f64>().unwrap() - value).abs() < 1e-12;
        // The ratios of times are 1/2 and 1/8, the ratios of FLIP 1/2 and 1.
        assert!(
            row_named("basic")[1] == "2"
                && close(&row_named("basic")[2], 0.25)
                && close(&row_named("basic")[3], 0.5_f64.sqrt())
        );
        assert!(
            row_named("kim2019")[1] == "1"
                && close(&row_named("kim2019")[2], 0.1)
                && close(&row_named("kim2019")[3], 2.0)
        );
        assert_eq!(
            found.sentence,
            "In 2 of 2 scenes, held against path: the least FLIP has basic (0.707 of its); the shortest frame has basic \
             (0.250 of its)."
        );
        assert!(overview(&scenes(&runs[..1]), &Names::new(&runs)).is_none());
    }
}
