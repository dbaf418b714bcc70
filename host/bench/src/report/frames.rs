//! Measures over the frames of an animation, with a line for each run configuration.

use maud::{Markup, html};

use super::axis::{Axis, Scale};
use super::figure::{Drawing, Figure, LegendEntry, Size};
use super::load::Measured;
use super::name::Names;
use super::number::{at, number};
use super::plot::Area;
use super::scene::ReportScene;
use crate::error::{MEASURES, Measure};
use crate::result::FrameResult;

/// Maximum number of lines of a figure.
const LINES: usize = 10;
/// Lengths of dashes and gaps, which tell lines apart without colour.
const DASHES: [&str; 4] = ["none", "9 4", "3 3", "12 3 3 3"];

/// A value of a frame.
type FrameValue = Box<dyn Fn(&FrameResult) -> Option<f64>>;

/// Quantity drawn over frames.
struct Drawn {
    slug: String,
    title: String,
    axis: String,
    value: FrameValue,
}

/// The time, and every measure of error.
fn drawn() -> impl Iterator<Item = Drawn> {
    let time = Drawn {
        slug: "frame-time".into(),
        title: "time over the animation".into(),
        axis: "time of a frame [ms]".into(),
        value: Box::new(|frame| frame.total_ms),
    };
    let error = |measure: &'static Measure| Drawn {
        slug: format!("frame-{}", measure.slug()),
        title: format!("{} over the animation", measure.head),
        axis: measure.head.into(),
        value: Box::new(move |frame| frame.get(measure)),
    };
    std::iter::once(time).chain(MEASURES.into_iter().map(error))
}

/// Line of a run configuration.
struct Line {
    name: String,
    color: String,
    dash: &'static str,
    series: usize,
    points: Vec<(f64, f64)>,
}

/// The figures of a scene that moves.
pub fn frames(scene: &ReportScene, names: &Names) -> Vec<Figure> {
    drawn().filter_map(|measure| figure(scene, names, &measure)).collect()
}

fn figure(scene: &ReportScene, names: &Names, measure: &Drawn) -> Option<Figure> {
    let points = |run: &Measured| -> Vec<(f64, f64)> {
        let frames = run.result.frames.iter();
        let mut points: Vec<(f64, f64)> =
            frames.filter_map(|frame| Some((f64::from(frame.frame), (measure.value)(frame)?))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let all: Vec<&Measured> = scene.runs.iter().copied().filter(|run| !points(run).is_empty()).collect();
    let runs = if all.len() <= LINES {
        all.clone()
    } else {
        scene.chosen(names, LINES, |run| !points(run).is_empty())
    };
    let mut lines: Vec<Line> = Vec::new();
    for run in &runs {
        let series = names.series(&run.result.config);
        let color = names.color(series);
        let dash = DASHES[lines.iter().filter(|line| line.color == color).count() % DASHES.len()];
        lines.push(Line { name: names.label(run), color, dash, series, points: points(run) });
    }
    let notes = match all.len() - lines.len() {
        0 => vec![],
        left => vec![format!("{left} more configurations have frames: here is one of each kind.")],
    };
    let legend = lines.iter().map(|line| LegendEntry {
        color: line.color.clone(),
        shape: Some(names.shape(line.series)),
        name: line.name.clone(),
        series: None,
    });
    Some(Figure {
        name: format!("{}-{}", scene.slug, measure.slug),
        title: format!("{}: {}", scene.title, measure.title),
        wide: draw(&lines, names, measure, Size::Wide)?,
        narrow: draw(&lines, names, measure, Size::Narrow)?,
        legend: legend.collect(),
        notes,
        rows: rows(&lines, measure),
    })
}

fn draw(lines: &[Line], names: &Names, measure: &Drawn, size: Size) -> Option<Drawing> {
    let area = Area::new(size);
    let points = || lines.iter().flat_map(|line| &line.points);
    let y = area.upwards(Scale::Linear, points().map(|point| point.1))?;
    let first = points().map(|point| point.0).fold(f64::INFINITY, f64::min);
    let last = points().map(|point| point.0).fold(f64::NEG_INFINITY, f64::max);
    let x = Axis::between(first, last, area.left, area.right);
    let content = html! {
        (area.draw(&x, "frame →", &y, &format!("↑ {}", measure.axis)))
        @for line in lines { (draw_line(line, names, measure, &x, &y)) }
    };
    Some(Drawing { width: size.width(), height: size.height(), content })
}

fn draw_line(line: &Line, names: &Names, measure: &Drawn, x: &Axis, y: &Axis) -> Markup {
    let position = |point: &(f64, f64)| (at(x.position(point.0)), at(y.position(point.1)));
    let path: Vec<String> = line.points.iter().map(position).map(|(x, y)| format!("{x},{y}")).collect();
    let values = || line.points.iter().map(|point| point.1);
    let mean = values().sum::<f64>() / line.points.len() as f64;
    let (low, high) =
        values().fold((f64::INFINITY, 0.0f64), |(low, high), value| (low.min(value), high.max(value)));
    let whole = format!(
        "{}\n{}: mean {}, {} to {}\n{} frames",
        line.name,
        measure.axis,
        number(mean),
        number(low),
        number(high),
        line.points.len()
    );
    // Draw at most eight marks a line: more would hide the lines.
    let every = line.points.len().div_ceil(8);
    html! {
        g class="run" tabindex="0" role="img" data-tip=(whole) {
            title { (whole) }
            polyline class={ "line " (line.color) } stroke-dasharray=(line.dash) points=(path.join(" ")) {}
            @for (index, point) in line.points.iter().enumerate() {
                @let (left, top) = position(point);
                @let tip = format!("{}\nframe {}: {} {}", line.name, point.0, measure.axis, number(point.1));
                g data-x=(left) data-y=(top) data-tip=(tip) transform={ "translate(" (left) " " (top) ")" } {
                    @if index % every == 0 {
                        path class={ "mark " (line.color) } d=(names.shape(line.series)) transform="scale(0.75)" {}
                    }
                }
            }
        }
    }
}

fn rows(lines: &[Line], measure: &Drawn) -> Vec<Vec<String>> {
    let mut rows = vec![["cell", "frame", &measure.slug].map(String::from).to_vec()];
    for line in lines {
        rows.extend(
            line.points
                .iter()
                .map(|(frame, value)| vec![line.name.clone(), frame.to_string(), value.to_string()]),
        );
    }
    rows
}
