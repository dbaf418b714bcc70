//! A measure over frames, a line a cell.

use plotters::element::DashedPathElement;
use plotters::prelude::*;

use super::{LETTERS, SIZE, TITLE, failed, palette};

/// A line: its name, and its value at each frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// In the legend.
    pub name: String,
    /// Frame and value, in order of the frames.
    pub points: Vec<(f64, f64)>,
}

/// The figure; `measure` is the name of the axis with its unit. The axis starts at 0.
pub fn lines(title: &str, measure: &str, series: &[Series]) -> anyhow::Result<String> {
    let points = || series.iter().flat_map(|line| &line.points);
    let frames = points().map(|point| point.0);
    let first = frames.clone().fold(f64::INFINITY, f64::min);
    let last = frames.fold(f64::NEG_INFINITY, f64::max);
    anyhow::ensure!(first <= last, "drawing a figure: there is no frame to draw");
    let top = points().map(|point| point.1).fold(0.0, f64::max);
    let top = if top > 0.0 { 1.05 * top } else { 1.0 };
    let bottom = points().map(|point| point.1).fold(0.0, f64::min) * 1.05;

    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        // The legend has a column of its own: it hides no line.
        let names = series.iter().map(|line| line.name.chars().count()).max().unwrap_or(0);
        let (figure, legend) = root.split_horizontally(SIZE.0 as i32 - 60 - 8 * names as i32);
        let mut chart = ChartBuilder::on(&figure)
            .margin(14)
            .x_label_area_size(44)
            .y_label_area_size(70)
            .caption(title, TITLE)
            .build_cartesian_2d(first..last.max(first + 1.0), bottom..top)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .x_desc("frame")
            .y_desc(measure)
            .x_label_formatter(&|frame| if frame.fract() == 0.0 { frame.to_string() } else { String::new() })
            .y_label_formatter(&|value| short(*value))
            .axis_desc_style(LETTERS)
            .label_style(LETTERS)
            .draw()
            .map_err(failed)?;
        for (index, line) in series.iter().enumerate() {
            let style = palette::color(index).stroke_width(2);
            let (length, gap) = palette::dash(index);
            let points = line.points.iter().copied();
            if gap == 0 {
                chart.draw_series(LineSeries::new(points, style)).map_err(failed)?;
            } else {
                chart.draw_series(DashedLineSeries::new(points, length, gap, style)).map_err(failed)?;
            }
            // A line of one frame is a point, and all points are seen.
            let dots = line.points.iter().map(|&point| Circle::new(point, 2, style.filled()));
            chart.draw_series(dots).map_err(failed)?;
            let y = 60 + 24 * index as i32;
            let sample = vec![(0, y), (34, y)];
            if gap == 0 {
                legend.draw(&PathElement::new(sample, style)).map_err(failed)?;
            } else {
                legend.draw(&DashedPathElement::new(sample, length, gap, style)).map_err(failed)?;
            }
            legend.draw(&Text::new(line.name.clone(), (42, y - 8), LETTERS)).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(text)
}

/// A number of an axis.
pub fn short(value: f64) -> String {
    let digits = if value.abs() >= 100.0 || value == 0.0 { 0 } else { 4 };
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_has_a_line_and_a_name() {
        let series = |name: &str, height: f64| Series {
            name: name.into(),
            points: (0..9).map(|frame| (f64::from(frame), height + f64::from(frame % 3))).collect(),
        };
        let names = ["basic-none", "basic-paper", "basic-validated", "basic-none-atrous", "a < b & c"];
        let all: Vec<_> =
            names.iter().zip(1..).map(|(name, height)| series(name, f64::from(height))).collect();
        let text = lines("title", "time [ms]", &all).unwrap();
        let document = roxmltree::Document::parse(&text).unwrap();
        let texts: Vec<&str> = document.descendants().filter_map(|node| node.text()).map(str::trim).collect();
        for name in names.iter().chain(&["title", "time [ms]", "frame", "8"]) {
            assert!(texts.contains(name), "{name} is not in the figure");
        }
        for (index, name) in names.iter().enumerate() {
            let RGBColor(r, g, b) = palette::color(index);
            let color = format!("#{r:02X}{g:02X}{b:02X}");
            let of_color = |tag: &str, key: &str| {
                document
                    .descendants()
                    .filter(|node| node.has_tag_name(tag) && node.attribute(key) == Some(&color))
                    .count()
            };
            // A line and its sample in the legend; dashes are a line each. Other lines are black too.
            let drawn = of_color("polyline", "stroke") + of_color("line", "stroke");
            assert!(drawn >= 2 && of_color("circle", "fill") == 9, "{name}: {drawn}");
            assert!(palette::dash(index).1 == 0 || drawn > 20, "{name} has {drawn} dashes");
        }
    }

    #[test]
    fn frames_that_are_not_there_draw_nothing() {
        assert!(lines("title", "time [ms]", &[]).is_err());
    }

    #[test]
    fn numbers_of_axes_are_short() {
        for (value, text) in [(0.0, "0"), (0.5, "0.5"), (1e-4, "0.0001"), (25.0, "25"), (1234.0, "1234")] {
            assert_eq!(short(value), text);
        }
    }
}
