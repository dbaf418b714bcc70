//! How the time of a frame grows with its work: cells that differ in one quantity only, and the exponents that fit them.

use std::collections::BTreeMap;
use std::path::Path;

use maud::{Markup, html};

use super::axis::{Axis, Scale};
use super::figure::{Drawing, Entry, Figure, Size};
use super::load::Measured;
use super::name::{COLORS, SHAPES, Series};
use super::number::{at, number, short};
use super::passes::groups;
use super::plot::Area;
use super::table::{Column, Table, Value};
use crate::experiment::result::{CellConfig, CellTime};

/// Fewest values of a quantity that an exponent is fitted to.
const FEWEST: usize = 4;
/// Charts of a quantity, at most.
const CHARTS: usize = 2;
/// Part of the frame's time that a pass has somewhere, if it is shown.
const SMALLEST: f64 = 0.02;
/// What the whole frame is called among its passes.
const FRAME: &str = "frame";

/// What work grows with.
struct Quantity {
    slug: &'static str,
    name: &'static str,
    of: fn(&CellConfig, &CellTime) -> f64,
}

const QUANTITIES: [Quantity; 4] = [
    Quantity { slug: "light-paths", name: "light paths", of: |_, time| f64::from(time.light_paths) },
    Quantity { slug: "pixels", name: "pixels", of: |_, time| f64::from(time.width) * f64::from(time.height) },
    Quantity { slug: "triangles", name: "triangles", of: |_, time| time.triangles as f64 },
    Quantity { slug: "bounces", name: "bounces", of: |cell, _| f64::from(cell.max_bounces) },
];

/// A slope in logarithmic axes, and that between the last two values, where fixed costs weigh least.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Fit {
    exponent: f64,
    standard_error: f64,
    last: f64,
}

/// Times of a part of a frame [ms] at each value of the quantity.
struct Part {
    name: String,
    ms: Vec<f64>,
    fit: Fit,
}

/// What cells of a series share.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Name {
    /// Scene, method and gather.
    head: String,
    /// Settings.
    rest: String,
}

impl Name {
    fn whole(&self) -> String {
        format!("{} · {}", self.head, self.rest)
    }
}

/// Cells that differ in one quantity only.
struct Growth {
    quantity: &'static Quantity,
    cell: Name,
    slug: String,
    values: Vec<f64>,
    parts: Vec<Part>,
    /// What n log n has over the same values.
    limit: f64,
}

impl Growth {
    /// Whether a part grows faster than n log n, beyond twice the standard error.
    fn is_faster(&self, part: &Part) -> bool {
        part.fit.exponent - 2.0 * part.fit.standard_error > self.limit
    }
}

/// The table of the exponents of all series, and charts of those of each quantity with the most values; none without a
/// series.
pub fn growth(cells: &[Measured]) -> Option<(Vec<Figure>, Table)> {
    let (mut all, mut figures) = (Vec::new(), Vec::new());
    for quantity in &QUANTITIES {
        let mut series = series(cells, quantity);
        series.sort_by_key(|growth| std::cmp::Reverse(growth.values.len()));
        figures.extend(series.iter().take(CHARTS).filter_map(figure));
        all.append(&mut series);
    }
    (!all.is_empty()).then(|| (figures, table(&all)))
}

/// What a series is of: its name, and one run on one device.
type Place<'a> = (Name, &'a Path, &'a str);

fn series(cells: &[Measured], quantity: &'static Quantity) -> Vec<Growth> {
    let mut series: BTreeMap<Place, Vec<(f64, &CellTime)>> = BTreeMap::new();
    for cell in cells {
        let Some(time) = &cell.result.time else { continue };
        let Some(name) = name(&cell.result.cell, time, quantity) else { continue };
        let place = (name, cell.folder.as_path(), cell.result.provenance.device.as_str());
        series.entry(place).or_default().push(((quantity.of)(&cell.result.cell, time), time));
    }
    let mut all = Vec::new();
    for ((cell, ..), mut points) in series {
        points.retain(|(value, _)| *value > 1.0);
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|a, b| a.0 == b.0);
        if points.len() < FEWEST {
            continue;
        }
        let values: Vec<f64> = points.iter().map(|(value, _)| *value).collect();
        let steps: Vec<f64> = values.iter().map(|value| value * value.ln()).collect();
        let whole = cell.whole();
        let words =
            whole.split(|letter: char| !letter.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
        let slug = ["growth", quantity.slug].into_iter().chain(words).collect::<Vec<_>>().join("-");
        let limit = fit(&values, &steps).exponent;
        all.push(Growth { quantity, cell, slug, parts: parts(&values, &points), values, limit });
    }
    all
}

/// All that cells of a series share: in words, what decides a frame but the quantity. None where it does not vary.
fn name(cell: &CellConfig, time: &CellTime, quantity: &Quantity) -> Option<Name> {
    let is = |slug| quantity.slug == slug;
    let scene = if is("triangles") { family(&cell.scene)? } else { &cell.scene };
    let mut words = Vec::new();
    words.extend((!is("pixels")).then(|| format!("{}×{}", time.width, time.height)));
    words.extend((!is("light-paths")).then(|| format!("{} light paths", time.light_paths)));
    words.extend((!is("bounces")).then(|| format!("{} bounces", cell.max_bounces)));
    words.extend((cell.radius_px != 1.0).then(|| format!("radius {} px", short(f64::from(cell.radius_px)))));
    words.extend([cell.runner.clone()]);
    words.extend((cell.needs == "all").then(|| "needs all".into()));
    Some(Name { head: format!("{scene} · {}", Series::of(cell).name()), rest: words.join(" · ") })
}

/// The name of a scene that is made in several numbers of triangles: `cornell` of `cornell-10k`.
fn family(scene: &str) -> Option<&str> {
    let (family, number) = scene.rsplit_once('-')?;
    let digits = number.strip_suffix(['k', 'm'])?;
    (!digits.is_empty() && digits.chars().all(|letter| letter.is_ascii_digit())).then_some(family)
}

/// The frame, and the passes that take a part of it that shows somewhere.
fn parts(values: &[f64], points: &[(f64, &CellTime)]) -> Vec<Part> {
    let groups: Vec<BTreeMap<String, f64>> = points.iter().map(|(_, time)| groups(&time.pass_ms)).collect();
    let totals: Vec<f64> = points.iter().map(|(_, time)| time.total_ms.median).collect();
    let part = |name: &str, ms: Vec<f64>| Part { name: name.into(), fit: fit(values, &ms), ms };
    let mut parts = vec![part(FRAME, totals.clone())];
    let names: std::collections::BTreeSet<&String> = groups.iter().flat_map(BTreeMap::keys).collect();
    for name in names {
        let ms: Vec<f64> = groups.iter().map(|group| group.get(name).copied().unwrap_or(0.0)).collect();
        let shows = ms.iter().zip(&totals).any(|(ms, total)| *ms > SMALLEST * total);
        if shows && ms.iter().all(|ms| *ms > 0.0) {
            parts.push(part(name, ms));
        }
    }
    parts
}

/// Least squares of logarithms.
fn fit(values: &[f64], times: &[f64]) -> Fit {
    let logs = |of: &[f64]| -> Vec<f64> { of.iter().map(|value| value.ln()).collect() };
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let (x, y) = (logs(values), logs(times));
    let (mean_x, mean_y) = (mean(&x), mean(&y));
    let spread: f64 = x.iter().map(|x| (x - mean_x).powi(2)).sum();
    let both: f64 = x.iter().zip(&y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let exponent = both / spread;
    let left = x.iter().zip(&y).map(|(x, y)| (y - mean_y - exponent * (x - mean_x)).powi(2)).sum::<f64>();
    let freedom = x.len().saturating_sub(2).max(1) as f64;
    let step = |of: &[f64]| of[of.len() - 1] - of[of.len() - 2];
    Fit { exponent, standard_error: (left / freedom / spread).sqrt(), last: step(&y) / step(&x) }
}

fn table(all: &[Growth]) -> Table {
    let rows: Vec<(&Growth, &Part)> =
        all.iter().flat_map(|growth| growth.parts.iter().map(move |part| (growth, part))).collect();
    let column = |head, key: &str, of: &dyn Fn(&Growth, &Part) -> Value| Column {
        head,
        key: key.into(),
        values: rows.iter().map(|(growth, part)| of(growth, part)).collect(),
    };
    let text = |text: &str| Value::Text(text.into());
    let two = |value: f64| Value::Number(value, format!("{value:.2}"));
    let end = |of: &[f64]| of.last().copied();
    let columns = vec![
        column("grows with", "quantity", &|growth, _| text(growth.quantity.name)),
        column("from", "from", &|growth, _| Value::number(growth.values.first().copied())),
        column("to", "to", &|growth, _| Value::number(end(&growth.values))),
        column("cell", "cell", &|growth, _| text(&growth.cell.whole())),
        column("part", "part", &|_, part| text(&part.name)),
        column("at the end [ms]", "last_ms", &|_, part| Value::number(end(&part.ms))),
        column("exponent", "exponent", &|_, part| two(part.fit.exponent)),
        column("standard error", "standard_error", &|_, part| two(part.fit.standard_error)),
        column("of the last step", "last_exponent", &|_, part| two(part.fit.last)),
        column("that of n log n", "n_log_n", &|growth, _| two(growth.limit)),
        column("at most n log n", "within", &|growth, part| {
            text(if growth.is_faster(part) { "no" } else { "yes" })
        }),
    ];
    Table { name: "growth".into(), title: "How time grows with the work".into(), columns }
}

fn figure(growth: &Growth) -> Option<Figure> {
    let Growth { quantity, cell, parts, .. } = growth;
    let entry = |(rank, part): (usize, &Part)| Entry {
        color: color(rank),
        shape: Some(SHAPES[rank % SHAPES.len()]),
        name: format!("{}: exponent {:.2}", part.name, part.fit.exponent),
        series: None,
    };
    let mut rows = vec![[quantity.slug, "part", "ms"].map(String::from).to_vec()];
    for part in parts {
        let row = |(value, ms): (&f64, &f64)| vec![value.to_string(), part.name.clone(), ms.to_string()];
        rows.extend(growth.values.iter().zip(&part.ms).map(row));
    }
    Some(Figure {
        name: growth.slug.clone(),
        title: format!("Time against {}: {}", quantity.name, cell.head),
        wide: draw(growth, Size::Wide)?,
        narrow: draw(growth, Size::Narrow)?,
        legend: parts.iter().enumerate().map(entry).collect(),
        notes: vec![format!("{}.", cell.rest)],
        rows,
    })
}

fn color(rank: usize) -> String {
    if rank == 0 { "c0".into() } else { format!("c{}", 1 + (rank - 1) % (COLORS - 1)) }
}

fn draw(growth: &Growth, size: Size) -> Option<Drawing> {
    let area = Area::of(size);
    let x = area.rightwards(Scale::Log, growth.values.iter().copied())?;
    let y = area.upwards(Scale::Log, growth.parts.iter().flat_map(|part| part.ms.iter().copied()))?;
    let content = html! {
        (area.draw(&x, &format!("{} →", growth.quantity.name), &y, "↑ time in a frame [ms]"))
        @for (rank, part) in growth.parts.iter().enumerate() { (draw_part(growth, part, rank, &x, &y)) }
    };
    Some(Drawing { width: size.width(), height: size.height(), content })
}

fn draw_part(growth: &Growth, part: &Part, rank: usize, x: &Axis, y: &Axis) -> Markup {
    let points: Vec<(f64, f64)> = growth.values.iter().copied().zip(part.ms.iter().copied()).collect();
    let place = |(value, ms): (f64, f64)| (at(x.place(value)), at(y.place(ms)));
    let line: Vec<String> =
        points.iter().map(|point| place(*point)).map(|(x, y)| format!("{x},{y}")).collect();
    let class = color(rank);
    let Fit { exponent, standard_error, .. } = part.fit;
    html! {
        polyline class={ "line " (class) } points=(line.join(" ")) {}
        @for point in &points {
            @let (left, top) = place(*point);
            @let tip = format!(
                "{}\n{} {}: {} ms\nexponent {exponent:.2} ± {standard_error:.2}",
                part.name, short(point.0), growth.quantity.name, number(point.1)
            );
            g tabindex="0" role="img" data-tip=(tip) transform={ "translate(" (left) " " (top) ")" } {
                title { (tip) }
                path class={ "mark " (class) } d=(SHAPES[rank % SHAPES.len()]) transform="scale(0.75)" {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::result::{CellResult, Quartiles};

    fn cell(light_paths: u32, shoot: f64, gather: f64) -> Measured {
        let quartiles = |median| Quartiles { median, ..Quartiles::default() };
        let time = CellTime {
            width: 8,
            height: 4,
            light_paths,
            total_ms: quartiles(shoot + gather + 1.0),
            pass_ms: [("shoot.store".into(), quartiles(shoot)), ("gather.x".into(), quartiles(gather))]
                .into(),
            ..CellTime::default()
        };
        let cell = CellConfig { scene: "ring".into(), method: "basic".into(), ..CellConfig::default() };
        let result = CellResult { time: Some(time), cell, ..CellResult::default() };
        Measured { result, folder: "".into() }
    }

    #[test]
    fn exponents_of_known_growth_are_found_and_a_square_is_too_much() {
        let cells = [1e3, 1e4, 1e5, 1e6].map(|n: f64| cell(n as u32, 2e-6 * n * n.ln(), 1e-9 * n * n));
        let (figures, table) = growth(&cells).unwrap();
        let rows = table.rows();
        let of = |part: &str| rows.iter().find(|row| row[4] == part).unwrap();
        let exponent = |part| of(part)[6].parse::<f64>().unwrap();
        assert!((exponent("gather") - 2.0).abs() < 1e-9 && of("gather")[10] == "no");
        assert!((exponent("shoot") - of("shoot")[9].parse::<f64>().unwrap()).abs() < 1e-9);
        assert_eq!(of("shoot")[10], "yes");
        assert_eq!((figures.len(), rows.len()), (1, 4));
    }

    #[test]
    fn few_values_and_other_settings_make_no_series() {
        let mut cells = [1e3, 1e4, 1e5, 1e6].map(|n: f64| cell(n as u32, n, n));
        assert!(growth(&cells[1..]).is_none());
        cells[3].result.cell.radius_px = 2.0;
        assert!(growth(&cells).is_none());
        cells[3].result.cell.radius_px = cells[2].result.cell.radius_px;
        assert!(growth(&cells).is_some());
        cells[3].folder = "another run".into();
        assert!(growth(&cells).is_none());
    }

    #[test]
    fn scenes_of_a_family_are_told_by_their_number() {
        let families = ["cornell-10k", "cornell-1m", "cornell-box", "ring", "x-k"].map(family);
        assert_eq!(families, [Some("cornell"), Some("cornell"), None, None, None]);
    }
}
