//! Growth of a frame's time with its work: run configurations that differ in only one quantity, and fitted exponents.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use maud::{Markup, html};

use super::axis::{Axis, Scale};
use super::figure::{Drawing, Figure, LegendEntry, Size};
use super::load::Measured;
use super::name::{COLORS, SHAPES, Series};
use super::number::{at, number, short};
use super::plot::Area;
use super::table::{Column, Table, TableValue};
use crate::parameter::{MAX_BOUNCES, PARAMETERS, PATHS_PER_PIXEL, Parameter, VisualEncoding};
use crate::result::{ConfigValues, Provenance, Quartiles, TimeResult};

/// Minimum number of values of a quantity for a fit.
const FEWEST: usize = 4;
/// Maximum number of charts of a quantity.
const CHARTS: usize = 2;
/// Share of the frame's time that a pass must exceed at one value to be shown.
const SMALLEST: f64 = 0.01;
/// Name of the whole frame among its passes.
const FRAME: &str = "frame";

/// Quantity that work grows with.
struct Quantity {
    slug: &'static str,
    name: &'static str,
    value: fn(&ConfigValues, &TimeResult) -> f64,
}

const QUANTITIES: [Quantity; 4] = [
    Quantity { slug: "light-paths", name: "light paths", value: |_, time| f64::from(time.light_paths) },
    Quantity {
        slug: "pixels",
        name: "pixels",
        value: |_, time| f64::from(time.width) * f64::from(time.height),
    },
    Quantity { slug: "triangles", name: "triangles", value: |_, time| time.triangles as f64 },
    Quantity { slug: "bounces", name: "bounces", value: |config, _| config.number(&MAX_BOUNCES) },
];

/// A slope in logarithmic axes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Slope {
    exponent: f64,
    standard_error: f64,
}

impl Slope {
    /// Whether the slope exceeds a limit by more than twice its standard error.
    fn is_above(self, limit: f64) -> bool {
        self.exponent - 2.0 * self.standard_error > limit
    }
}

/// Times of a part of a frame (ms) at each value of the quantity.
struct Part {
    name: String,
    ms: Vec<f64>,
    /// Slope over all values.
    whole: Slope,
    /// Slope between the last two values, where a fixed cost hides growth least.
    last: Slope,
}

/// Parameters that the configurations of a series share.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Name {
    /// Scene, method and gather.
    head: String,
    /// Other settings.
    rest: String,
}

impl Name {
    fn whole(&self) -> String {
        format!("{} · {}", self.head, self.rest)
    }
}

/// Run configurations that differ in only one quantity.
struct Growth {
    quantity: &'static Quantity,
    name: Name,
    slug: String,
    values: Vec<f64>,
    parts: Vec<Part>,
    /// The exponent of n log n over the same values.
    limit: f64,
    /// The exponent of n log n over the last two values.
    last_limit: f64,
}

impl Growth {
    /// Whether a part grows faster than n log n, over all values or in the last step.
    fn is_faster(&self, part: &Part) -> bool {
        part.whole.is_above(self.limit) || part.last.is_above(self.last_limit)
    }
}

/// Table of the exponents of all series, and charts of the series with the most values of each quantity. None without a
/// series.
pub fn growth(runs: &[Measured]) -> Option<(Vec<Figure>, Table)> {
    let (mut all, mut figures) = (Vec::new(), Vec::new());
    for quantity in &QUANTITIES {
        let mut series = series(runs, quantity);
        series.sort_by_key(|growth| std::cmp::Reverse(growth.values.len()));
        figures.extend(series.iter().take(CHARTS).filter_map(figure));
        all.append(&mut series);
    }
    (!all.is_empty()).then(|| (figures, table(&all)))
}

/// Key of a series: its name, its folder of results, and its origin (commit, kernels, device, machine).
type SeriesKey<'a> = (Name, &'a Path, [&'a str; 4]);

fn series(runs: &[Measured], quantity: &'static Quantity) -> Vec<Growth> {
    let mut series: BTreeMap<SeriesKey, Vec<(f64, &TimeResult)>> = BTreeMap::new();
    for run in runs {
        let Some(time) = &run.result.time else { continue };
        let Some(name) = name(&run.result.config, time, quantity) else { continue };
        let Provenance { commit, kernels, device, machine, .. } = &run.result.provenance;
        let origin = [commit, kernels, device, machine].map(String::as_str);
        let key = (name, run.folder.as_path(), origin);
        series.entry(key).or_default().push(((quantity.value)(&run.result.config, time), time));
    }
    let mut all = Vec::new();
    for ((name, ..), mut points) in series {
        points.retain(|(value, _)| *value > 1.0);
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|a, b| a.0 == b.0);
        if points.len() < FEWEST {
            continue;
        }
        let values: Vec<f64> = points.iter().map(|(value, _)| *value).collect();
        let steps: Vec<f64> = values.iter().map(|value| value * value.ln()).collect();
        let whole = name.whole();
        let words =
            whole.split(|letter: char| !letter.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
        let slug = ["growth", quantity.slug].into_iter().chain(words).collect::<Vec<_>>().join("-");
        let limit = fit(&values, &steps).exponent;
        let last_limit = last_step(&values, &steps, &[0.0; 2]).exponent;
        all.push(Growth { quantity, name, slug, parts: parts(&values, &points), values, limit, last_limit });
    }
    all
}

/// Name of a series: every setting that decides a frame except the quantity. None where the quantity does not vary.
fn name(config: &ConfigValues, time: &TimeResult, quantity: &Quantity) -> Option<Name> {
    let is = |slug| quantity.slug == slug;
    let scene = if is("triangles") { family(&config.scene)? } else { &config.scene };
    let mut words = Vec::new();
    words.extend((!is("pixels")).then(|| format!("{}×{}", time.width, time.height)));
    words.extend((!is("light-paths")).then(|| format!("{} light paths", time.light_paths)));
    words.push(format!("camera {}", config.camera));
    let own =
        |parameter: &Parameter| *parameter == PATHS_PER_PIXEL || (*parameter == MAX_BOUNCES && is("bounces"));
    words.extend(PARAMETERS.into_iter().filter(|parameter| !own(parameter)).filter_map(|parameter| {
        match parameter.shown {
            VisualEncoding::Words(_, words) if config.text(parameter) != parameter.neutral => {
                Some(words(&config.text(parameter)))
            }
            _ => None,
        }
    }));
    Some(Name { head: format!("{scene} · {}", Series::new(config).name()), rest: words.join(" · ") })
}

/// Name of a scene that exists with several numbers of triangles: `cornell` for `cornell-10k`.
fn family(scene: &str) -> Option<&str> {
    let (family, number) = scene.rsplit_once('-')?;
    let digits = number.strip_suffix(['k', 'm'])?;
    (!digits.is_empty() && digits.chars().all(|letter| letter.is_ascii_digit())).then_some(family)
}

/// The frame, and the passes whose share of a frame is large enough to be shown.
fn parts(values: &[f64], points: &[(f64, &TimeResult)]) -> Vec<Part> {
    let times = |quartiles: &dyn Fn(&TimeResult) -> Option<Quartiles>| -> Vec<Quartiles> {
        points.iter().map(|(_, time)| quartiles(time).unwrap_or_default()).collect()
    };
    let part = |name: &str, times: &[Quartiles]| {
        let ms: Vec<f64> = times.iter().map(|quartiles| quartiles.median).collect();
        let errors: Vec<f64> = times
            .iter()
            .zip(points)
            .map(|(quartiles, (_, time))| relative_error(quartiles, time.frames))
            .collect();
        Part { name: name.into(), whole: fit(values, &ms), last: last_step(values, &ms, &errors), ms }
    };
    let totals = times(&|time| Some(time.total_ms));
    let mut parts = vec![part(FRAME, &totals)];
    let names: BTreeSet<&String> = points.iter().flat_map(|(_, time)| time.pass_ms.keys()).collect();
    for name in names {
        let own = times(&|time| time.pass_ms.get(name).copied());
        let shows = own.iter().zip(&totals).any(|(own, total)| own.median > SMALLEST * total.median);
        if shows && own.iter().all(|own| own.median > 0.0) {
            parts.push(part(name, &own));
        }
    }
    parts
}

/// Standard error of a median relative to the median, from its quartiles, assuming normal noise.
fn relative_error(quartiles: &Quartiles, frames: u32) -> f64 {
    let deviation = (quartiles.upper - quartiles.lower) / 1.349;
    1.2533 * deviation / f64::from(frames.max(1)).sqrt() / quartiles.median
}

/// Slope between the last two values; `errors` are the relative errors of the times.
fn last_step(values: &[f64], times: &[f64], errors: &[f64]) -> Slope {
    let step = |numbers: &[f64]| (numbers[numbers.len() - 1] / numbers[numbers.len() - 2]).ln();
    let error = errors[errors.len() - 1].hypot(errors[errors.len() - 2]);
    Slope { exponent: step(times) / step(values), standard_error: error / step(values) }
}

/// Least-squares line through the logarithms.
fn fit(values: &[f64], times: &[f64]) -> Slope {
    let logs = |numbers: &[f64]| -> Vec<f64> { numbers.iter().map(|value| value.ln()).collect() };
    let mean = |numbers: &[f64]| numbers.iter().sum::<f64>() / numbers.len() as f64;
    let (x, y) = (logs(values), logs(times));
    let (mean_x, mean_y) = (mean(&x), mean(&y));
    let spread: f64 = x.iter().map(|x| (x - mean_x).powi(2)).sum();
    let both: f64 = x.iter().zip(&y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let exponent = both / spread;
    let left = x.iter().zip(&y).map(|(x, y)| (y - mean_y - exponent * (x - mean_x)).powi(2)).sum::<f64>();
    let freedom = x.len().saturating_sub(2).max(1) as f64;
    Slope { exponent, standard_error: (left / freedom / spread).sqrt() }
}

fn table(all: &[Growth]) -> Table {
    let rows: Vec<(&Growth, &Part)> =
        all.iter().flat_map(|growth| growth.parts.iter().map(move |part| (growth, part))).collect();
    let column = |head, key: &str, value: &dyn Fn(&Growth, &Part) -> TableValue| Column {
        head,
        key: key.into(),
        values: rows.iter().map(|(growth, part)| value(growth, part)).collect(),
    };
    let text = |text: &str| TableValue::Text(text.into());
    let two = |value: f64| TableValue::Number(value, format!("{value:.2}"));
    let end = |numbers: &[f64]| numbers.last().copied();
    let columns = vec![
        column("grows with", "quantity", &|growth, _| text(growth.quantity.name)),
        column("from", "from", &|growth, _| TableValue::number(growth.values.first().copied())),
        column("to", "to", &|growth, _| TableValue::number(end(&growth.values))),
        column("configuration", "cell", &|growth, _| text(&growth.name.whole())),
        column("part", "part", &|_, part| text(&part.name)),
        column("at the end [ms]", "last_ms", &|_, part| TableValue::number(end(&part.ms))),
        column("exponent", "exponent", &|_, part| two(part.whole.exponent)),
        column("standard error", "standard_error", &|_, part| two(part.whole.standard_error)),
        column("that of n log n", "n_log_n", &|growth, _| two(growth.limit)),
        column("of the last step", "last_exponent", &|_, part| two(part.last.exponent)),
        column("standard error", "last_standard_error", &|_, part| two(part.last.standard_error)),
        column("that of n log n", "last_n_log_n", &|growth, _| two(growth.last_limit)),
        column("at most n log n", "within", &|growth, part| {
            text(if growth.is_faster(part) { "no" } else { "yes" })
        }),
    ];
    Table { name: "growth".into(), title: "How time grows with the work".into(), columns }
}

fn figure(growth: &Growth) -> Option<Figure> {
    let Growth { quantity, name, parts, .. } = growth;
    let entry = |(rank, part): (usize, &Part)| LegendEntry {
        color: color(rank),
        shape: Some(SHAPES[rank % SHAPES.len()]),
        name: format!("{}: exponent {:.2}", part.name, part.whole.exponent),
        series: None,
    };
    let mut rows = vec![[quantity.slug, "part", "ms"].map(String::from).to_vec()];
    for part in parts {
        let row = |(value, ms): (&f64, &f64)| vec![value.to_string(), part.name.clone(), ms.to_string()];
        rows.extend(growth.values.iter().zip(&part.ms).map(row));
    }
    Some(Figure {
        name: growth.slug.clone(),
        title: format!("Time against {}: {}", quantity.name, name.head),
        wide: draw(growth, Size::Wide)?,
        narrow: draw(growth, Size::Narrow)?,
        legend: parts.iter().enumerate().map(entry).collect(),
        notes: vec![format!("{}.", name.rest)],
        rows,
    })
}

fn color(rank: usize) -> String {
    if rank == 0 { "c0".into() } else { format!("c{}", 1 + (rank - 1) % (COLORS - 1)) }
}

fn draw(growth: &Growth, size: Size) -> Option<Drawing> {
    let area = Area::new(size);
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
    let position = |(value, ms): (f64, f64)| (at(x.position(value)), at(y.position(ms)));
    let line: Vec<String> =
        points.iter().map(|point| position(*point)).map(|(x, y)| format!("{x},{y}")).collect();
    let class = color(rank);
    let Slope { exponent, standard_error } = part.whole;
    html! {
        polyline class={ "line " (class) } points=(line.join(" ")) {}
        @for point in &points {
            @let (left, top) = position(*point);
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
    use crate::parameter::{METHOD, RADIUS_PX};
    use crate::result::{Quartiles, RunResult};

    fn run(light_paths: u32, shoot: f64, gather: f64) -> Measured {
        let quartiles = |median| Quartiles { median, ..Quartiles::default() };
        let time = TimeResult {
            width: 8,
            height: 4,
            light_paths,
            total_ms: quartiles(shoot + gather + 1.0),
            pass_ms: [("shoot.store".into(), quartiles(shoot)), ("gather.x".into(), quartiles(gather))]
                .into(),
            ..TimeResult::default()
        };
        let config = ConfigValues::new("ring", "").with(&METHOD, "basic").with(&RADIUS_PX, "1");
        let result = RunResult { time: Some(time), config, ..RunResult::default() };
        Measured { result, folder: "".into() }
    }

    #[test]
    fn exponents_match_known_growth_and_quadratic_growth_is_reported() {
        let runs = [1e3, 1e4, 1e5, 1e6].map(|n: f64| run(n as u32, 2e-6 * n * n.ln(), 1e-9 * n * n));
        let (figures, table) = growth(&runs).unwrap();
        let rows = table.rows();
        let part_row = |part: &str| rows.iter().find(|row| row[4] == part).unwrap();
        let number = |part, column: usize| part_row(part)[column].parse::<f64>().unwrap();
        assert!((number("gather.x", 6) - 2.0).abs() < 1e-9 && part_row("gather.x")[12] == "no");
        for (exponent, limit) in [(6, 8), (9, 11)] {
            assert!((number("shoot.store", exponent) - number("shoot.store", limit)).abs() < 1e-9);
        }
        assert_eq!(part_row("shoot.store")[12], "yes");
        assert_eq!((figures.len(), rows.len()), (1, 4));
    }

    #[test]
    fn quadratic_growth_is_reported_despite_a_fixed_cost() {
        let of_gather = |spread: f64| {
            let mut runs = [1e3, 1e4, 1e5, 1e6].map(|n: f64| run(n as u32, 1e-6 * n, 1.0 + 1e-10 * n * n));
            for run in &mut runs {
                let time = run.result.time.as_mut().unwrap();
                let gather = time.pass_ms.get_mut("gather.x").unwrap();
                let median = gather.median;
                (gather.lower, gather.upper, time.frames) = (median / spread, median * spread, 8);
            }
            growth(&runs).unwrap().1.rows().into_iter().find(|row| row[4] == "gather.x").unwrap()
        };
        // The gather takes 1, 1.01, 2 and 101 ms: the slope over all values is small, the slope of the last step is not.
        let row = of_gather(1.05);
        assert!(row[6].parse::<f64>().unwrap() < 0.7 && row[9].parse::<f64>().unwrap() > 1.6, "{row:?}");
        assert_eq!(row[12], "no");
        // Times with large errors prove nothing.
        assert_eq!(of_gather(3.0)[12], "yes");
    }

    #[test]
    fn series_need_four_values_and_equal_settings() {
        let mut runs = [1e3, 1e4, 1e5, 1e6].map(|n: f64| run(n as u32, n, n));
        assert!(growth(&runs[1..]).is_none());
        runs[3].result.config.set(&RADIUS_PX, "2");
        assert!(growth(&runs).is_none());
        runs[3].result.config = runs[2].result.config.clone();
        assert!(growth(&runs).is_some());
        runs[3].folder = "another run".into();
        assert!(growth(&runs).is_none());
    }

    #[test]
    fn scene_families_are_recognised_by_their_number() {
        let families = ["cornell-10k", "cornell-1m", "cornell-box", "ring", "x-k"].map(family);
        assert_eq!(families, [Some("cornell"), Some("cornell"), None, None, None]);
    }
}
