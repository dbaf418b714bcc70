//! Mean time of a frame by pass, a bar a cell. Passes of one group (`grid.size`, `grid.fill`) are one piece.

use std::collections::BTreeMap;

use plotters::prelude::*;

use super::lines::short;
use super::{LETTERS, SIZE, TITLE, failed, palette};

/// Part of the longest bar below which a piece is not worth a colour.
const SMALLEST: f64 = 0.005;

/// The figure; cells by name with the mean time of each pass in a frame (ms).
pub fn passes(title: &str, cells: &[(String, BTreeMap<String, f64>)]) -> anyhow::Result<String> {
    let bars: Vec<BTreeMap<String, f64>> = cells.iter().map(|(_, passes)| groups(passes)).collect();
    let longest = bars.iter().map(|bar| bar.values().sum::<f64>()).fold(0.0, f64::max);
    anyhow::ensure!(longest > 0.0, "drawing a figure: no pass has a time");
    let pieces = pieces(&bars, longest);
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        let (figure, legend) = root.split_horizontally(SIZE.0 as i32 - 150);
        let names = |x: &f64| {
            // Bar k stands around k; ticks between bars have no name.
            let near = (x - x.round()).abs() < 1e-6 && *x >= -0.5;
            let name = near.then(|| cells.get(x.round() as usize)).flatten();
            name.map(|(name, _)| name.clone()).unwrap_or_default()
        };
        let mut chart = ChartBuilder::on(&figure)
            .margin(14)
            .x_label_area_size(44)
            .y_label_area_size(70)
            .caption(title, TITLE)
            .build_cartesian_2d(-0.6..cells.len() as f64 - 0.4, 0.0..1.05 * longest)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(WHITE)
            .x_labels(5 * cells.len())
            .x_desc("method, history, filter")
            .y_desc("mean time of a frame [ms]")
            .x_label_formatter(&names)
            .y_label_formatter(&|value| short(*value))
            .axis_desc_style(LETTERS)
            .label_style(LETTERS)
            .draw()
            .map_err(failed)?;
        for (index, bar) in bars.iter().enumerate() {
            let (x, mut y) = (index as f64, 0.0);
            for (rank, piece) in pieces.iter().enumerate() {
                let time = match piece.as_str() {
                    REST => bar.iter().filter(|(name, _)| !pieces.contains(name)).map(|(_, time)| time).sum(),
                    name => bar.get(name).copied().unwrap_or(0.0),
                };
                let corners = [(x - 0.3, y), (x + 0.3, y + time)];
                let rectangle = Rectangle::new(corners, palette::piece(rank).filled());
                chart.draw_series([rectangle]).map_err(failed)?;
                y += time;
            }
        }
        // In the order of the stack, from its top.
        for (rank, piece) in pieces.iter().enumerate() {
            let y = 60 + 24 * (pieces.len() - 1 - rank) as i32;
            let style = palette::piece(rank).filled();
            legend.draw(&Rectangle::new([(0, y - 8), (18, y + 8)], style)).map_err(failed)?;
            legend.draw(&Text::new(piece.clone(), (26, y - 8), LETTERS)).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(text)
}

/// The piece of all that is small.
const REST: &str = "rest";

/// Times by the first part of the passes' names (ms).
fn groups(passes: &BTreeMap<String, f64>) -> BTreeMap<String, f64> {
    let mut groups = BTreeMap::new();
    for (pass, time) in passes {
        let group = pass.split('.').next().unwrap_or(pass);
        *groups.entry(group.to_string()).or_insert(0.0) += time;
    }
    groups
}

/// Names of the pieces from the bottom: the longest first, then the rest.
fn pieces(bars: &[BTreeMap<String, f64>], longest: f64) -> Vec<String> {
    let mut most: BTreeMap<&String, f64> = BTreeMap::new();
    for (name, time) in bars.iter().flatten() {
        let known = most.entry(name).or_insert(0.0);
        *known = time.max(*known);
    }
    let mut large: Vec<_> = most.into_iter().filter(|(_, time)| *time >= SMALLEST * longest).collect();
    large.sort_by(|a, b| b.1.total_cmp(&a.1));
    // One colour is left for the rest.
    large.truncate(colorous::TABLEAU10.len() - 1);
    large.into_iter().map(|(name, _)| name.clone()).chain([REST.to_string()]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_of_a_group_are_one_piece_and_small_ones_are_the_rest() {
        let passes = [("grid.size", 1.0), ("grid.fill", 2.0), ("collect", 5.0), ("clear.counters", 0.001)];
        let bar = groups(&passes.map(|(name, time)| (name.to_string(), time)).into());
        assert_eq!(bar["grid"], 3.0);
        assert_eq!(pieces(&[bar], 8.0), ["collect", "grid", "rest"]);
    }
}
