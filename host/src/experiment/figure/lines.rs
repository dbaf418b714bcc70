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
            .x_label_formatter(&|frame| format!("{frame:.0}"))
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
