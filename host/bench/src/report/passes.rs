//! Time of a frame by pass: a bar for each run configuration. Passes of one group (`grid.size`, `grid.fill`) are one piece.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::axis::{Axis, Scale};
use super::figure::{Drawing, Figure, LegendEntry, Size};
use super::load::Measured;
use super::name::{COLORS, Names};
use super::number::{at, number, short};
use super::scene::ReportScene;

/// Maximum number of bars of a figure.
const BARS: usize = 14;
/// Share of the longest bar below which a piece has no colour of its own.
const SMALLEST: f64 = 0.005;
/// Name of the piece that sums all small ones.
const REST: &str = "rest";
/// Height of a bar with its name, and of the bar alone (px).
const ROW: (f64, f64) = (44.0, 18.0);

/// A bar: the name of a run configuration, its time (ms), and its pieces in the order of the legend (ms).
struct Bar {
    name: String,
    total: f64,
    pieces: Vec<f64>,
}

/// The figure of a scene; none where no configuration has times of passes.
pub fn passes(scene: &ReportScene, names: &Names) -> Option<Figure> {
    let groups_of =
        |run: &Measured| run.result.time.as_ref().map(|time| groups(&time.pass_ms)).unwrap_or_default();
    let runs = scene.chosen(names, BARS, |run| !groups_of(run).is_empty());
    let all: Vec<BTreeMap<String, f64>> = runs.iter().map(|run| groups_of(run)).collect();
    let longest = all.iter().map(|groups| groups.values().sum()).fold(0.0, f64::max);
    let large = large(&all, longest);
    let bars: Vec<Bar> = runs
        .iter()
        .zip(&all)
        .map(|(run, groups)| Bar {
            name: names.label(run),
            total: run.result.time.as_ref().map_or(0.0, |time| time.total_ms.median),
            pieces: pieces(groups, &large),
        })
        .collect();
    let has_rest = bars.iter().any(|bar| bar.pieces.last().is_some_and(|rest| *rest > 0.0));
    let kinds: Vec<String> = large.into_iter().chain(has_rest.then(|| REST.to_string())).collect();
    if longest <= 0.0 {
        return None;
    }
    let timed = scene.runs.iter().filter(|run| !groups_of(run).is_empty()).count();
    let notes = match timed - bars.len() {
        0 => vec![],
        left => vec![format!(
            "{left} more timed configurations are in the table below: here is one of each kind."
        )],
    };
    Some(Figure {
        name: format!("{}-passes", scene.slug),
        title: format!("{}: time of a frame by pass", scene.title),
        wide: draw(&bars, &kinds, Size::Wide)?,
        narrow: draw(&bars, &kinds, Size::Narrow)?,
        legend: kinds.iter().enumerate().map(|(rank, kind)| entry(rank, kind)).collect(),
        notes,
        rows: rows(&bars, &kinds),
    })
}

fn entry(rank: usize, kind: &str) -> LegendEntry {
    LegendEntry { color: color(rank, kind), shape: None, name: kind.into(), series: None }
}

fn color(rank: usize, kind: &str) -> String {
    if kind == REST { "c0".into() } else { format!("c{}", 1 + rank % (COLORS - 1)) }
}

/// Times (ms) summed by the first part of the passes' names.
fn groups(passes: &BTreeMap<String, crate::result::Quartiles>) -> BTreeMap<String, f64> {
    let mut groups = BTreeMap::new();
    for (pass, time) in passes {
        let group = pass.split('.').next().unwrap_or(pass);
        *groups.entry(group.to_string()).or_insert(0.0) += time.median;
    }
    groups
}

/// Groups that get a colour of their own, the longest first.
fn large(bars: &[BTreeMap<String, f64>], longest: f64) -> Vec<String> {
    let mut max_times: BTreeMap<&String, f64> = BTreeMap::new();
    for (name, time) in bars.iter().flatten() {
        let known = max_times.entry(name).or_insert(0.0);
        *known = time.max(*known);
    }
    let mut large: Vec<_> = max_times.into_iter().filter(|(_, time)| *time >= SMALLEST * longest).collect();
    large.sort_by(|a, b| b.1.total_cmp(&a.1));
    large.truncate(COLORS - 1);
    large.into_iter().map(|(name, _)| name.clone()).collect()
}

/// Times of the large groups, then the sum of all others (ms).
fn pieces(groups: &BTreeMap<String, f64>, large: &[String]) -> Vec<f64> {
    let own = large.iter().map(|name| groups.get(name).copied().unwrap_or(0.0));
    let rest = groups.iter().filter(|(name, _)| !large.contains(name)).map(|(_, time)| time).sum();
    own.chain([rest]).collect()
}

fn draw(bars: &[Bar], kinds: &[String], size: Size) -> Option<Drawing> {
    let width = size.width();
    let (top, bottom) = (6.0, 6.0 + ROW.0 * bars.len() as f64);
    let longest = bars.iter().map(|bar| bar.pieces.iter().sum::<f64>().max(bar.total));
    let x = Axis::around(Scale::Linear, longest, 2.0, width - 74.0)?;
    let content = html! {
        @for tick in x.ticks() {
            @let position = at(x.position(tick.value));
            line class="grid" x1=(position) x2=(position) y1=(top) y2=(bottom + 4.0) {}
            text x=(position) y=(bottom + 20.0) text-anchor=(if tick.value == 0.0 { "start" } else { "middle" }) {
                (short(tick.value))
            }
        }
        text class="name" x=(width - 4.0) y=(bottom + 38.0) text-anchor="end" { "median time in a frame [ms] →" }
        @for (index, bar) in bars.iter().enumerate() { (draw_bar(bar, kinds, &x, top + ROW.0 * index as f64)) }
    };
    Some(Drawing { width, height: bottom + 46.0, content })
}

fn draw_bar(bar: &Bar, kinds: &[String], x: &Axis, top: f64) -> Markup {
    let sum: f64 = bar.pieces.iter().sum();
    let mut start = 0.0;
    let spans: Vec<(f64, f64)> = bar
        .pieces
        .iter()
        .map(|time| {
            start += time;
            (start - time, start)
        })
        .collect();
    let parts = kinds.iter().zip(&bar.pieces).filter(|(_, time)| **time > 0.0);
    let parts =
        parts.map(|(kind, time)| format!("{kind} {} ms ({:.0} %)", number(*time), 100.0 * time / sum));
    let tip = [bar.name.clone(), format!("{} ms a frame", number(bar.total))].into_iter().chain(parts);
    let tip = tip.collect::<Vec<_>>().join("\n");
    html! {
        g class="bar" tabindex="0" role="img" data-tip=(tip) {
            title { (tip) }
            rect class="hit" fill="transparent" x="0" y=(at(top)) width=(at(x.position(sum))) height=(ROW.0) {}
            text x="2" y=(at(top + 14.0)) { (bar.name) }
            @for (rank, (kind, (from, to))) in kinds.iter().zip(&spans).enumerate() {
                @if to > from {
                    @let (left, right) = (x.position(*from), x.position(*to));
                    rect class=(color(rank, kind)) x=(at(left)) y=(at(top + 19.0)) height=(ROW.1)
                        width=(at((right - left - 1.0).max(0.5))) {}
                }
            }
            text x=(at(x.position(sum) + 6.0)) y=(at(top + 33.0)) { (number(bar.total)) " ms" }
        }
    }
}

fn rows(bars: &[Bar], kinds: &[String]) -> Vec<Vec<String>> {
    let heads = ["cell".to_string(), "median_ms".to_string()];
    let heads = heads.into_iter().chain(kinds.iter().map(|kind| format!("{kind}_ms"))).collect();
    let row = |bar: &Bar| {
        let pieces = bar.pieces.iter().take(kinds.len()).map(f64::to_string);
        [bar.name.clone(), bar.total.to_string()].into_iter().chain(pieces).collect()
    };
    [heads].into_iter().chain(bars.iter().map(row)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::Quartiles;

    #[test]
    fn passes_of_a_group_are_one_piece_and_small_ones_are_the_rest() {
        let passes = [("grid.size", 1.0), ("grid.fill", 2.0), ("collect", 5.0), ("clear.counters", 0.001)];
        let quartiles = |median| Quartiles { lower: 0.0, median, upper: 9.0 };
        let groups = groups(&passes.map(|(name, time)| (name.to_string(), quartiles(time))).into());
        let large = large(std::slice::from_ref(&groups), 8.0);
        assert_eq!(large, ["collect", "grid"]);
        assert_eq!(pieces(&groups, &large), [5.0, 3.0, 0.001]);
    }
}
