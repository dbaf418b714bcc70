//! Chart of speed against accuracy: a mark for each run configuration, time of a frame against an error, both logarithmic,
//! and the Pareto front.

use maud::{Markup, html};

use super::axis::{Axis, Scale};
use super::figure::{Drawing, Figure, LegendEntry, Size};
use super::load::Measured;
use super::name::{Names, size};
use super::number::{at, number};
use super::pareto::pareto;
use super::plot::Area;
use super::scene::ReportScene;
use super::tip::tip;
use crate::error::Measure;
use crate::parameter::{FEATURES, METHOD, PATHS_PER_PIXEL, RUNNER};

/// Line styles of the fronts of several runners: name, and lengths of dashes and gaps.
const DASHES: [(&str, &str); 3] = [("solid", "none"), ("dashed", "7 4"), ("dotted", "2 3")];

/// A run configuration of the chart.
struct Mark<'a> {
    run: &'a Measured,
    series: usize,
    ms: f64,
    error: f64,
    /// Standard error of `error` between seeds; 0 for a single seed.
    error_off: f64,
    is_on_front: bool,
}

/// A chart, and the names of the run configurations on its front.
pub struct Chart {
    /// Measure of error of the chart.
    pub measure: &'static Measure,
    /// The chart.
    pub figure: Figure,
    /// Front by front, from the fastest: name, time (ms) and error.
    pub front: Vec<(String, f64, f64)>,
}

/// The chart of a scene; none where no configuration has both a time and this error.
pub fn chart(scene: &ReportScene, names: &Names, measure: &'static Measure) -> Option<Chart> {
    let mut marks: Vec<Mark> = Vec::new();
    let (mut untimed, mut zero) = (0, 0);
    for run in &scene.runs {
        let errors = run.result.error.as_ref();
        let error = errors.and_then(|error| error.get(measure));
        let error_off = errors.and_then(|error| error.standard_error(measure)).unwrap_or_default();
        let ms = run.result.time.as_ref().map(|time| time.total_ms.median);
        match (ms, error) {
            (Some(ms), Some(error)) if ms > 0.0 && error > 0.0 && (ms * error).is_finite() => {
                let series = names.series(&run.result.config);
                marks.push(Mark { run, series, ms, error, error_off, is_on_front: false });
            }
            (Some(_), Some(_)) => zero += 1,
            _ => untimed += 1,
        }
    }
    if marks.is_empty() {
        return None;
    }
    let fronts = fronts(&marks, names);
    for &index in fronts.iter().flatten() {
        marks[index].is_on_front = true;
    }
    let mut notes = Vec::new();
    if !marks.iter().any(|mark| mark.run.result.config.text(&METHOD) == "path") {
        notes.push(
            "Path tracing is missing here: no run configuration of method path has this error and a time."
                .into(),
        );
    }
    let are = |count: usize| {
        if count == 1 {
            "1 run configuration is".to_string()
        } else {
            format!("{count} run configurations are")
        }
    };
    if untimed > 0 {
        notes.push(format!("{} not shown: without a time or without this error.", are(untimed)));
    }
    if zero > 0 {
        notes.push(format!("{} not shown: 0 has no place on a logarithmic axis.", are(zero)));
    }
    if fronts.len() > 1 {
        let description = |(index, front): (usize, &Vec<usize>)| {
            let comparable_group =
                front.first().map_or(String::new(), |&first| comparable_group(&marks[first], names));
            format!("{comparable_group} {}", DASHES[index % DASHES.len()].0)
        };
        let all: Vec<String> = fronts.iter().enumerate().map(description).collect();
        notes.push(format!("What was not measured alike has a front of its own: {}.", all.join(", ")));
    }
    if marks.iter().any(|mark| mark.run.result.config.text(&FEATURES) == "all") {
        notes.push("Hollow marks have all code compiled in, what the scene does not need too.".into());
    }
    if marks.iter().any(|mark| mark.error_off > 0.0) {
        notes.push("Bars: standard error between seeds, and quartiles of the frame's time.".into());
    }
    let mut series: Vec<usize> = marks.iter().map(|mark| mark.series).collect();
    series.sort_unstable();
    series.dedup();
    let figure = Figure {
        name: format!("{}-{}", scene.slug, measure.slug()),
        title: format!("{}: time of a frame against {}", scene.title, measure.head),
        wide: draw(&marks, &fronts, names, measure, Size::Wide),
        narrow: draw(&marks, &fronts, names, measure, Size::Narrow),
        legend: series.into_iter().map(|series| LegendEntry::new(names, series)).collect(),
        notes,
        rows: rows(&marks, names, measure),
    };
    let front = fronts.iter().flatten().map(|&index| {
        let mark = &marks[index];
        (names.label(mark.run), mark.ms, mark.error)
    });
    Some(Chart { measure, figure, front: front.collect() })
}

/// Key of marks that compete with each other. Other programs, machines and image sizes have other keys.
fn comparable_group(mark: &Mark, names: &Names) -> String {
    let parts = [mark.run.result.config.text(&RUNNER), size(mark.run), names.origin(mark.run)];
    parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Indices of the marks on the front of each comparable group.
fn fronts(marks: &[Mark], names: &Names) -> Vec<Vec<usize>> {
    let comparable_group = |mark: &Mark| comparable_group(mark, names);
    let mut groups: Vec<String> = marks.iter().map(comparable_group).collect();
    groups.sort_unstable();
    groups.dedup();
    let front = |group: String| {
        let own: Vec<usize> =
            (0..marks.len()).filter(|&index| comparable_group(&marks[index]) == group).collect();
        let points: Vec<(f64, f64)> =
            own.iter().map(|&index| (marks[index].ms, marks[index].error)).collect();
        pareto(&points).into_iter().map(|index| own[index]).collect()
    };
    groups.into_iter().map(front).collect()
}

fn draw(
    marks: &[Mark],
    fronts: &[Vec<usize>],
    names: &Names,
    measure: &'static Measure,
    size: Size,
) -> Drawing {
    let area = Area::new(size);
    let x = area.rightwards(Scale::Log, marks.iter().map(|mark| mark.ms));
    let y = area.upwards(Scale::Log, marks.iter().map(|mark| mark.error));
    let content = match (x, y) {
        (Some(x), Some(y)) => html! {
            (area.draw(&x, "median time of a frame [ms] →", &y, &format!("↑ {}", measure.head)))
            @for family in families(marks, names) { (line(&family, marks, names, &x, &y)) }
            @for (index, front) in fronts.iter().enumerate() { (stairs(front, index, marks, &area, &x, &y)) }
            @for mark in marks { (bars(mark, &area, &x, &y)) }
            g class="marks" { @for mark in marks { (draw_mark(mark, names, &x, &y)) } }
        },
        _ => Markup::default(),
    };
    Drawing { width: size.width(), height: size.height(), content }
}

/// Error bars of a mark.
fn bars(mark: &Mark, area: &Area, x: &Axis, y: &Axis) -> Markup {
    let (left, top) = (at(x.position(mark.ms)), at(y.position(mark.error)));
    let within_x = |ms: f64| at(x.position(ms).clamp(area.left, area.right));
    let within_y = |error: f64| at(y.position(error).clamp(area.top, area.bottom));
    let mut path = String::new();
    if let Some(time) = &mark.run.result.time {
        // A time of 0 has no logarithm.
        let ms = time.total_ms;
        path += &format!("M{} {top} H{}", within_x(ms.lower.max(1e-9)), within_x(ms.upper));
    }
    if mark.error_off > 0.0 {
        let min_error = (mark.error - mark.error_off).max(1e-9 * mark.error);
        path += &format!(" M{left} {} V{}", within_y(min_error), within_y(mark.error + mark.error_off));
    }
    html! { path .bars d=(path) {} }
}

fn draw_mark(mark: &Mark, names: &Names, x: &Axis, y: &Axis) -> Markup {
    let config = &mark.run.result.config;
    let (left, top) = (at(x.position(mark.ms)), at(y.position(mark.error)));
    let hollow = if config.text(&FEATURES) == "all" { " hollow" } else { "" };
    let mut tip = tip(mark.run, names);
    if mark.is_on_front {
        tip.push_str("\non the Pareto front");
    }
    html! {
        g class="point" tabindex="0" role="img" transform={ "translate(" (left) " " (top) ")" }
            data-series=(mark.series) data-cell=(mark.run.result.identity) data-x=(left) data-y=(top) data-tip=(tip) {
            title { (tip) }
            path class={ "mark " (names.color(mark.series)) (hollow) } d=(names.shape(mark.series)) {}
        }
    }
}

/// Configurations that differ only in their number of paths, in ascending order.
fn families(marks: &[Mark], names: &Names) -> Vec<Vec<usize>> {
    let key = |index: usize| {
        let mut config = marks[index].run.result.config.clone();
        config.set(&PATHS_PER_PIXEL, "0");
        (config, comparable_group(&marks[index], names))
    };
    let mut families: Vec<Vec<usize>> = Vec::new();
    let paths = |index: usize| marks[index].run.result.config.number(&PATHS_PER_PIXEL);
    for index in (0..marks.len()).filter(|&index| paths(index) > 0.0) {
        match families.iter_mut().find(|family| key(family[0]) == key(index)) {
            Some(family) => family.push(index),
            None => families.push(vec![index]),
        }
    }
    for family in &mut families {
        family.sort_by(|&a, &b| paths(a).total_cmp(&paths(b)));
    }
    families.retain(|family| family.len() > 1);
    families
}

fn line(family: &[usize], marks: &[Mark], names: &Names, x: &Axis, y: &Axis) -> Markup {
    let position = |&index: &usize| {
        format!("{},{}", at(x.position(marks[index].ms)), at(y.position(marks[index].error)))
    };
    let points: Vec<String> = family.iter().map(position).collect();
    let series = marks[family[0]].series;
    html! {
        polyline class={ "family " (names.color(series)) } data-series=(series) points=(points.join(" ")) {}
    }
}

/// Staircase of a front: everything above and to the right of it is dominated.
fn stairs(front: &[usize], index: usize, marks: &[Mark], area: &Area, x: &Axis, y: &Axis) -> Markup {
    let mut path = String::new();
    for &index in front {
        let (left, top) = (at(x.position(marks[index].ms)), at(y.position(marks[index].error)));
        path += &if path.is_empty() {
            format!("M{left} {} V{top}", area.top)
        } else {
            format!(" H{left} V{top}")
        };
    }
    path += &format!(" H{}", area.right);
    let dash = DASHES[index % DASHES.len()].1;
    html! { path class="front" stroke-dasharray=(dash) d=(path) {} }
}

fn rows(marks: &[Mark], names: &Names, measure: &'static Measure) -> Vec<Vec<String>> {
    let slug = measure.slug();
    let heads = ["cell", "identity", "runner", "median_ms", &slug, "on_front"];
    let mut rows = vec![heads.map(String::from).to_vec()];
    for mark in marks {
        let config = &mark.run.result.config;
        let identity = mark.run.result.identity.clone();
        let (ms, error) = (mark.ms.to_string(), mark.error.to_string());
        let on_front = mark.is_on_front.to_string();
        rows.push(vec![names.label(mark.run), identity, config.text(&RUNNER), ms, error, on_front]);
    }
    rows
}

/// Text of the front, one line per configuration.
pub fn list(chart: &Chart) -> Markup {
    html! {
        details .front-list {
            summary { "Pareto front: " (chart.front.len()) @if chart.front.len() == 1 { " configuration" } @else { " configurations" } }
            ol {
                @for (name, ms, error) in &chart.front {
                    li { span { (name) } " " span .dim { (number(*ms)) " ms, " (chart.measure.head) " " (number(*error)) } }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::FLIP;
    use crate::report::scene::scenes;
    use crate::result::{ConfigValues, ErrorResult, Quartiles, RunResult, TimeResult};

    fn run(method: &str, runner: &str, ms: f64, flip: Option<f64>) -> Measured {
        let config = ConfigValues::new("a<\"&", "").with(&METHOD, method).with(&RUNNER, runner);
        let total_ms = Quartiles { lower: ms, median: ms, upper: ms };
        let time = Some(TimeResult { total_ms, width: 8, height: 4, ..TimeResult::default() });
        let error = Some(ErrorResult::default().with(&FLIP, flip));
        let identity = format!("{method}-{ms}");
        Measured {
            result: RunResult { identity, config, time, error, ..RunResult::default() },
            folder: "".into(),
        }
    }

    fn flip(runs: &[Measured]) -> Option<Chart> {
        chart(&scenes(runs)[0], &Names::new(runs), &FLIP)
    }

    #[test]
    fn every_configuration_is_a_mark_and_the_front_is_named() {
        let mut runs = [
            run("basic", "cpu", 10.0, Some(0.2)),
            run("basic", "cpu", 20.0, Some(0.1)),
            run("kim2019", "cpu", 30.0, Some(0.15)),
            run("path", "gpu-hardware", 1.0, Some(0.01)),
            run("basic", "cpu", 2.0, Some(0.01)),
        ];
        runs[4].result.time.as_mut().unwrap().width = 2;
        let chart = flip(&runs).unwrap();
        let text = chart.figure.file();
        let document = roxmltree::Document::parse(&text).unwrap();
        let marks: Vec<_> = document.descendants().filter(|node| node.has_attribute("data-cell")).collect();
        assert_eq!(marks.len(), 5);
        assert!(marks[2].attribute("data-tip").unwrap().starts_with("kim2019"));
        let mut front: Vec<f64> = chart.front.iter().map(|(_, ms, _)| *ms).collect();
        front.sort_by(f64::total_cmp);
        // The GPU's configuration and the small image's configuration would dominate all others, so they have fronts of
        // their own.
        assert_eq!(front, [1.0, 2.0, 10.0, 20.0]);
        assert_eq!(
            chart.figure.notes,
            [
                "What was not measured alike has a front of its own: cpu 2×4 solid, cpu 8×4 dashed, gpu-hardware 8×4 dotted."
            ]
        );
        assert_eq!(chart.figure.rows.len(), 6);
    }

    #[test]
    fn configurations_without_a_mark_are_noted() {
        let runs = [
            run("basic", "cpu", 10.0, Some(0.2)),
            run("basic", "cpu", 9.0, None),
            run("basic", "cpu", 8.0, Some(0.0)),
        ];
        let notes = flip(&runs).unwrap().figure.notes.join(" ");
        for words in [
            "method path",
            "1 run configuration is not shown: without",
            "1 run configuration is not shown: 0 has",
        ] {
            assert!(notes.contains(words), "{words}: {notes}");
        }
        assert!(flip(&runs[1..2]).is_none());
    }
}
