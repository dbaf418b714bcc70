//! Results as tables: for the user, and as CSV with a row for each pass, run configuration or frame.

use std::fmt::Write;

use super::error::{CAUSTICS_VARIANCE, FLIP, MEASURES, Measure};
use super::gain::gain;
use super::parameter::{HISTORY, PARAMETERS};
use super::result::{ErrorResult, FrameResult, Quartiles, RunResult, TimeResult};
use caustics::metric::percentile::quantile;

/// Size below which a buffer is left out of the user's table (bytes).
const SMALL: u64 = 50_000;

/// Lines of columns: a name, then right-aligned cells.
struct Lines {
    text: String,
    wide: usize,
}

impl Lines {
    fn line(&mut self, name: &str, cells: &[String]) {
        let wide = self.wide;
        let line = cells.iter().fold(format!("{name:wide$}"), |line, cell| format!("{line} {cell:>11}"));
        self.text += line.trim_end();
        self.text += "\n";
    }
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".into(), |value| format!("{value:.digits$}"))
}

/// Table for the user. Each run configuration has a line with its times and one of its errors. Lines for each pass and for
/// the largest buffers follow.
pub fn table(results: &[(String, RunResult)]) -> String {
    let wide = results.iter().map(|(name, _)| name.len()).max().unwrap_or(0).max(13);
    let mut lines = Lines { text: String::new(), wide };
    if results.iter().any(|(_, result)| result.time.is_some()) {
        times(&mut lines, results);
    }
    if results.iter().any(|(_, result)| result.error.is_some()) {
        errors(&mut lines, results);
    }
    if results.iter().any(|(_, result)| result.time.is_some()) {
        passes(&mut lines, results);
    }
    lines.text
}

fn times(lines: &mut Lines, results: &[(String, RunResult)]) {
    let mega = |value: Option<f64>| number(value.map(|value| value / 1e6), 2);
    let heads = ["median ms", "25 %", "75 %", "95 %", "ratio", "M rays/s", "M points/s", "M paths/s", "MB"];
    lines.line("configuration", &heads.map(String::from));
    for (name, result) in results {
        let Some(time) = &result.time else { continue };
        let Quartiles { lower, median, upper } = time.total_ms;
        let frames: Vec<f64> = result.frames.iter().filter_map(|frame| frame.total_ms).collect();
        let tail = (!frames.is_empty()).then(|| quantile(&frames, 0.95));
        let cells = [
            number(Some(median), 2),
            number(Some(lower), 2),
            number(Some(upper), 2),
            number(tail, 2),
            number(time.ratio_to_first, 3),
            mega(Some(time.rays_per_s)),
            mega(time.points_per_s),
            mega(time.light_paths_per_s),
            number(Some(time.memory_bytes.values().sum::<u64>() as f64 / 1e6), 1),
        ];
        lines.line(name, &cells);
    }
    lines.line("", &[]);
}

fn errors(lines: &mut Lines, results: &[(String, RunResult)]) {
    let heads = MEASURES.iter().map(|measure| measure.head.to_string());
    lines.line("configuration", &heads.chain(["gain".into(), "above none".into()]).collect::<Vec<_>>());
    for (name, result) in results {
        let Some(error) = &result.error else { continue };
        let value = |measure: &&Measure| match error.get(measure) {
            Some(value) if value != 0.0 && value.abs() < 1e-3 => format!("{value:.2e}"),
            value => number(value, 4),
        };
        let baseline = baseline(result, results);
        let above = baseline.and_then(|none| frames_above(&FLIP, result, none));
        let mut cells: Vec<String> = MEASURES.iter().map(value).collect();
        cells.push(number(baseline.and_then(|none| median_gain(result, none)), 2));
        cells.push(above.map_or("-".into(), |count| count.to_string()));
        lines.line(name, &cells);
    }
    lines.line("", &[]);
}

/// Returns the result that differs only in its history, which is none.
fn baseline<'a>(result: &RunResult, results: &'a [(String, RunResult)]) -> Option<&'a RunResult> {
    let wanted = result.config.clone().with(&HISTORY, HISTORY.neutral);
    results.iter().map(|(_, other)| other).find(|other| other.config == wanted)
}

/// Variance of the caustics without a history over the variance with one: the median over frames, or the ratio of a still
/// image.
fn median_gain(result: &RunResult, none: &RunResult) -> Option<f64> {
    let variance = |frame: &FrameResult| Some((frame.frame, frame.get(&CAUSTICS_VARIANCE)?));
    let of_none: Vec<_> = none.frames.iter().filter_map(variance).collect();
    let of_frame = |frame: &FrameResult| {
        let own = frame.get(&CAUSTICS_VARIANCE)?;
        gain(of_none.iter().find(|(index, _)| *index == frame.frame)?.1, own)
    };
    let gains: Vec<f64> = result.frames.iter().filter_map(of_frame).collect();
    if gains.is_empty() {
        let whole = |run: &RunResult| run.error.as_ref()?.get(&CAUSTICS_VARIANCE);
        return gain(whole(none)?, whole(result)?);
    }
    Some(quantile(&gains, 0.5))
}

/// Number of frames in which a measure is above its value without history; none where no frame has the measure.
fn frames_above(measure: &Measure, result: &RunResult, none: &RunResult) -> Option<usize> {
    let value =
        |run: &RunResult, index: u32| run.frames.iter().find(|frame| frame.frame == index)?.get(measure);
    let pairs: Vec<(f64, f64)> = result
        .frames
        .iter()
        .filter_map(|frame| Some((frame.get(measure)?, value(none, frame.frame)?)))
        .collect();
    (!pairs.is_empty()).then(|| pairs.iter().filter(|(own, none)| own > none).count())
}

fn passes(lines: &mut Lines, results: &[(String, RunResult)]) {
    lines.line("pass", &["median ms", "25 %", "75 %"].map(String::from));
    for (name, result) in results {
        let Some(time) = &result.time else { continue };
        for (pass, Quartiles { lower, median, upper }) in &time.pass_ms {
            let cells = [*median, *lower, *upper].map(|ms| number(Some(ms), 3));
            lines.line(name, &[&cells[..], &[format!(" {pass}")]].concat());
        }
    }
    let text = &mut lines.text;
    for (name, result) in results {
        let Some(time) = &result.time else { continue };
        for (pass, cost) in &time.costs {
            let unit = if cost.rays.is_some() { "M rays/s" } else { "MB/s" };
            let expected =
                cost.expected_ms.map_or(String::new(), |ms| format!(", {ms:.2} ms by the tracer alone"));
            let (ms, rate) = (cost.ms, cost.rate_per_s / 1e6);
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{name} {pass}: {ms:.2} ms, {rate:.1} {unit}{expected}");
        }
        let mut buffers: Vec<_> = time.memory_bytes.iter().filter(|(_, bytes)| **bytes >= SMALL).collect();
        buffers.sort_by_key(|(_, bytes)| std::cmp::Reverse(**bytes));
        let list: Vec<String> =
            buffers.iter().map(|(buffer, bytes)| format!("{buffer} {:.1}", **bytes as f64 / 1e6)).collect();
        let _ = write!(text, "\n{name} buffers [MB]: {}\n", list.join(", "));
    }
}

/// CSV with a row for each run configuration and pass.
pub fn passes_csv(results: &[RunResult]) -> anyhow::Result<Vec<u8>> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let parameters = PARAMETERS.map(|parameter| parameter.key);
    table.write_record(["identity", "scene"].iter().chain(&parameters).chain(&[
        "pass",
        "median_ms",
        "lower_ms",
        "upper_ms",
    ]))?;
    for result in results {
        for (pass, pass_ms) in result.time.iter().flat_map(|time| &time.pass_ms) {
            let mut record = vec![result.identity.clone(), result.config.scene.clone()];
            record.extend(PARAMETERS.map(|parameter| result.config.text(parameter)));
            record.push(pass.clone());
            record.extend([pass_ms.median, pass_ms.lower, pass_ms.upper].map(|ms| ms.to_string()));
            table.write_record(&record)?;
        }
    }
    Ok(table.into_inner()?)
}

/// CSV with a row for each frame of each run configuration of scenes that move; none without frames.
pub fn frames_csv(results: &[RunResult]) -> anyhow::Result<Option<Vec<u8>>> {
    if results.iter().all(|result| result.frames.is_empty()) {
        return Ok(None);
    }
    let mut table = csv::Writer::from_writer(Vec::new());
    let (parameters, measures) =
        (PARAMETERS.map(|parameter| parameter.key), MEASURES.map(|measure| measure.key));
    table.write_record(
        ["identity", "scene"].iter().chain(&parameters).chain(&["frame", "total_ms"]).chain(&measures),
    )?;
    for result in results {
        for frame in &result.frames {
            let mut record = vec![result.identity.clone(), result.config.scene.clone()];
            record.extend(PARAMETERS.map(|parameter| result.config.text(parameter)));
            record.push(frame.frame.to_string());
            record.push(text(frame.total_ms));
            record.extend(MEASURES.map(|measure| text(frame.get(measure))));
            table.write_record(&record)?;
        }
    }
    Ok(Some(table.into_inner()?))
}

fn text(value: Option<f64>) -> String {
    value.map(|value| value.to_string()).unwrap_or_default()
}

/// A column of `cells.csv`: its head, and its value in a result.
type Column<T> = (&'static str, fn(&T) -> Option<f64>);

/// Columns of times.
const TIMES: [Column<TimeResult>; 11] = [
    ("width", |time| Some(f64::from(time.width))),
    ("height", |time| Some(f64::from(time.height))),
    ("light_paths", |time| Some(f64::from(time.light_paths))),
    ("total_ms", |time| Some(time.total_ms.median)),
    ("total_lower_ms", |time| Some(time.total_ms.lower)),
    ("total_upper_ms", |time| Some(time.total_ms.upper)),
    ("ratio_to_first", |time| time.ratio_to_first),
    ("rays_per_s", |time| Some(time.rays_per_s)),
    ("points_per_s", |time| time.points_per_s),
    ("light_paths_per_s", |time| time.light_paths_per_s),
    ("memory_bytes", |time| Some(time.memory_bytes.values().sum::<u64>() as f64)),
];
/// Columns of the measurement of errors.
const COMPARED: [Column<ErrorResult>; 3] = [
    ("error_width", |error| Some(f64::from(error.width))),
    ("error_height", |error| Some(f64::from(error.height))),
    ("seeds", |error| Some(f64::from(error.seeds))),
];

/// CSV with a row for each run configuration; values that were not measured are empty.
pub fn runs_csv(results: &[RunResult]) -> anyhow::Result<Vec<u8>> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let mut heads = vec!["identity", "scene", "camera"];
    heads.extend(PARAMETERS.map(|parameter| parameter.key));
    heads.extend(TIMES.map(|(head, _)| head));
    heads.extend(COMPARED.map(|(head, _)| head));
    heads.extend(MEASURES.map(|measure| measure.key));
    heads.extend(["device", "commit", "wall_s", "unix_s", "note"]);
    table.write_record(heads)?;
    for result in results {
        let RunResult { identity, config, time, error, provenance: from, note, .. } = result;
        let mut record = vec![identity.clone(), config.scene.clone(), config.camera.clone()];
        record.extend(PARAMETERS.map(|parameter| config.text(parameter)));
        record.extend(TIMES.map(|(_, value)| text(time.as_ref().and_then(value))));
        record.extend(COMPARED.map(|(_, value)| text(error.as_ref().and_then(value))));
        record.extend(MEASURES.map(|measure| text(error.as_ref().and_then(|error| error.get(measure)))));
        record.extend([from.device.clone(), from.commit.clone()]);
        record.extend([from.wall_s.to_string(), from.unix_s.to_string(), note.clone().unwrap_or_default()]);
        table.write_record(&record)?;
    }
    Ok(table.into_inner()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five frames of two run configurations that differ in their history. The second flickers less and is worse in one
    /// frame.
    fn results() -> Vec<(String, RunResult)> {
        let result = |history: &str, variance: f64, flip: &dyn Fn(u32) -> f64| {
            let frame = |frame: u32| FrameResult {
                frame,
                total_ms: Some(10.0),
                values: [(FLIP.key, flip(frame)), (CAUSTICS_VARIANCE.key, variance)]
                    .map(|(key, value)| (key.to_string(), Some(value)))
                    .into(),
            };
            let mut result = RunResult { frames: (0..5).map(frame).collect(), ..RunResult::default() };
            result.config.set(&HISTORY, history);
            result.error = Some(ErrorResult::default().with(&CAUSTICS_VARIANCE, Some(variance)));
            (history.to_string(), result)
        };
        vec![result("none", 0.9, &|_| 0.2), result("paper", 0.1, &|frame| if frame == 2 { 0.3 } else { 0.1 })]
    }

    #[test]
    fn gains_and_frames_above_none_are_relative_to_the_configuration_without_history() {
        let results = results();
        let none = baseline(&results[1].1, &results).unwrap();
        assert!((median_gain(&results[1].1, none).unwrap() - 9.0).abs() < 1e-12);
        assert_eq!(median_gain(none, none), Some(1.0));
        assert_eq!(frames_above(&FLIP, &results[1].1, none), Some(1));
        assert_eq!(frames_above(&FLIP, none, none), Some(0));
        assert!(baseline(&results[1].1, &results[1..]).is_none(), "nothing to gain over");
        let mut still = results.clone();
        still.iter_mut().for_each(|(_, result)| result.frames.clear());
        assert!((median_gain(&still[1].1, &still[0].1).unwrap() - 9.0).abs() < 1e-12);
        assert!(table(&results).contains("9.00"), "{}", table(&results));
    }

    #[test]
    fn tables_have_a_column_for_each_parameter_and_measure() {
        let results: Vec<RunResult> = results().into_iter().map(|(_, result)| result).collect();
        for csv in [runs_csv(&results).unwrap(), frames_csv(&results).unwrap().unwrap()] {
            let csv = String::from_utf8(csv).unwrap();
            let head = csv.lines().next().unwrap();
            for key in PARAMETERS
                .map(|parameter| parameter.key)
                .into_iter()
                .chain(MEASURES.map(|measure| measure.key))
            {
                assert!(head.split(',').any(|column| column == key), "{key}");
            }
        }
        assert!(frames_csv(&[]).unwrap().is_none());
    }
}
