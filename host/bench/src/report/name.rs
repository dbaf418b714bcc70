//! Names of run configurations, and the colours and shapes that tell them apart in every figure of a report.

use super::load::Measured;
use super::number::short;
use crate::parameter::{METHOD, PARAMETERS, Parameter, Values, VisualEncoding};
use crate::result::{ConfigValues, Provenance};

/// Number of colours in `report.css`.
pub const COLORS: usize = 10;
/// Outlines of marks, within 6 px of their centre; the first is for methods without a gather.
pub const SHAPES: [&str; 8] = [
    "M0-7 7 0 0 7-7 0Z",
    "M-5.5 0a5.5 5.5 0 1 0 11 0a5.5 5.5 0 1 0-11 0Z",
    "M-5-5H5V5H-5Z",
    "M0-6.5 6.3 4.8H-6.3Z",
    "M0 6.5 6.3-4.8H-6.3Z",
    "M-2.2-6.4H2.2V-2.2H6.4V2.2H2.2V6.4H-2.2V2.2H-6.4V-2.2H-2.2Z",
    "M0-6.6 5.7-3.3V3.3L0 6.6-5.7 3.3V-3.3Z",
    "M-6.4-3.3-3.3-6.4 0-3.1 3.3-6.4 6.4-3.3 3.1 0 6.4 3.3 3.3 6.4 0 3.1-3.3 6.4-6.4 3.3-3.1 0Z",
];

/// Size (px) of the timed image, else of the image whose error is known.
pub fn size(run: &Measured) -> String {
    let time = run.result.time.as_ref().map(|time| (time.width, time.height));
    let error = || run.result.error.as_ref().map(|error| (error.width, error.height));
    time.or_else(error).map_or(String::new(), |(width, height)| format!("{width}×{height}"))
}

/// Configurations of one colour and shape in a chart.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Series {
    /// Method, history and filter, shown by colour.
    pub kind: String,
    /// Gather, shown by shape; empty where there is none.
    pub gather: String,
}

impl Series {
    /// The series of a run configuration.
    pub fn new(config: &ConfigValues) -> Series {
        let shown_as = |wanted: fn(&VisualEncoding) -> bool| {
            let parameters = PARAMETERS.into_iter().filter(move |parameter| wanted(&parameter.shown));
            // Always name the method; name another parameter where it is not neutral.
            let named = parameters
                .filter(|parameter| **parameter == METHOD || config.text(parameter) != parameter.neutral);
            let texts = named.map(|parameter| config.text(parameter)).filter(|name| is_informative(name));
            texts.collect::<Vec<_>>().join(" + ")
        };
        Series {
            kind: shown_as(|shown| matches!(shown, VisualEncoding::Color)),
            gather: shown_as(|shown| matches!(shown, VisualEncoding::Shape)),
        }
    }

    /// Name in a legend.
    pub fn name(&self) -> String {
        [&self.kind, &self.gather]
            .map(String::as_str)
            .into_iter()
            .filter(|name| is_informative(name))
            .collect::<Vec<_>>()
            .join(" · ")
    }
}

/// Whether a name is neither empty nor `none`.
fn is_informative(name: &str) -> bool {
    !name.is_empty() && name != "none"
}

/// Names, colours and shapes of all run configurations of a report.
#[derive(Clone, Debug, Default)]
pub struct Names {
    kinds: Vec<String>,
    gathers: Vec<String>,
    series: Vec<Series>,
    varies: Vec<&'static Parameter>,
    sizes_vary: bool,
    origins_vary: Vec<&'static Origin>,
}

/// Part of a provenance that may differ between two series of one configuration.
type Origin = fn(&Provenance) -> String;

const ORIGINS: [Origin; 4] = [
    |provenance| short_hash("commit", &provenance.commit),
    |provenance| short_hash("kernels", &provenance.kernels),
    |provenance| provenance.device.clone(),
    |provenance| provenance.machine.clone(),
];

/// First digits of a hash, with a label.
fn short_hash(label: &str, hash: &str) -> String {
    let is_hash = hash.len() > 12 && hash.chars().take(12).all(|letter| letter.is_ascii_hexdigit());
    if hash.is_empty() {
        String::new()
    } else if is_hash {
        let dirty = if hash.ends_with("-dirty") { "-dirty" } else { "" };
        format!("{label} {}{dirty}", &hash[..8])
    } else {
        format!("{label} {hash}")
    }
}

impl Names {
    /// Finds the parameters, sizes and origins that differ between the run configurations.
    pub fn new(runs: &[Measured]) -> Names {
        let mut series: Vec<Series> = runs.iter().map(|run| Series::new(&run.result.config)).collect();
        series.sort();
        series.dedup();
        let mut kinds: Vec<String> = series.iter().map(|series| series.kind.clone()).collect();
        kinds.sort_by_key(|kind| (kind != "path", kind.clone()));
        kinds.dedup();
        let mut gathers: Vec<String> = series.iter().map(|series| series.gather.clone()).collect();
        gathers.push(String::new());
        gathers.sort();
        gathers.dedup();
        let names = Names { kinds, gathers, series, ..Names::default() };
        names.among(&runs.iter().collect::<Vec<_>>())
    }

    /// Returns names with these colours and shapes whose words tell only the given configurations apart.
    pub fn among(&self, runs: &[&Measured]) -> Names {
        let differ =
            |value: &dyn Fn(&Measured) -> String| runs.iter().any(|run| value(run) != value(runs[0]));
        let origins = ORIGINS.iter();
        Names {
            varies: PARAMETERS
                .into_iter()
                .filter(|parameter| differ(&|run| run.result.config.text(parameter)))
                .collect(),
            sizes_vary: differ(&|run| size(run)),
            origins_vary: origins.filter(|origin| differ(&|run| origin(&run.result.provenance))).collect(),
            ..self.clone()
        }
    }

    /// Origin of a configuration, in the parts that differ between configurations: commit, kernels, device, machine.
    pub fn origin(&self, run: &Measured) -> String {
        let words = self.origins_vary.iter().map(|origin| origin(&run.result.provenance));
        words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" · ")
    }

    /// Index of the series of a configuration.
    pub fn series(&self, config: &ConfigValues) -> usize {
        let own = Series::new(config);
        self.series.iter().position(|series| *series == own).unwrap_or(0)
    }

    /// Returns the series of an index.
    pub fn get(&self, series: usize) -> &Series {
        &self.series[series]
    }

    /// CSS class of a series' colour; `c0` is the colour of `path`.
    pub fn color(&self, series: usize) -> String {
        let kind = self.kinds.iter().position(|kind| *kind == self.series[series].kind).unwrap_or(0);
        let rank = if self.kinds.first().is_some_and(|kind| kind == "path") { kind } else { kind + 1 };
        let color = if rank == 0 { 0 } else { 1 + (rank - 1) % (COLORS - 1) };
        format!("c{color}")
    }

    /// Outline of its marks, around 0.
    pub fn shape(&self, series: usize) -> &'static str {
        let gather = self.gathers.iter().position(|gather| *gather == self.series[series].gather);
        SHAPES[gather.unwrap_or(0) % SHAPES.len()]
    }

    /// Name of a configuration among all of its scene.
    pub fn label(&self, run: &Measured) -> String {
        let (size, origin) = (size(run), self.origin(run));
        let config = &run.result.config;
        let mut parts = vec![Series::new(config).name()];
        for parameter in PARAMETERS {
            let VisualEncoding::Words(_, words) = parameter.shown else { continue };
            let text = match parameter.values {
                Values::Numbers(_) if config.number(parameter) > 0.0 => short(config.number(parameter)),
                Values::Numbers(_) => continue,
                Values::Names(_) if config.text(parameter) == parameter.neutral => continue,
                Values::Names(_) => config.text(parameter),
            };
            if !text.is_empty() && self.varies.contains(&parameter) {
                parts.push(words(&text));
            }
        }
        if self.sizes_vary && !size.is_empty() {
            parts.push(size);
        }
        if config.texture_filter == "finest" {
            parts.push("finest textures".into());
        }
        if !origin.is_empty() {
            parts.push(origin);
        }
        parts.join(" · ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::{DENOISER, FEATURES, GATHER, HISTORY, PATHS_PER_PIXEL, RUNNER};
    use crate::result::{ErrorResult, RunResult};
    use std::collections::BTreeSet;

    fn run(method: &str, gather: &str, history: &str) -> Measured {
        let config = ConfigValues::default()
            .with(&METHOD, method)
            .with(&GATHER, gather)
            .with(&HISTORY, history)
            .with(&DENOISER, "none");
        Measured { result: RunResult { config, ..RunResult::default() }, folder: "".into() }
    }

    #[test]
    fn series_differ_in_colour_or_shape_and_path_has_its_own() {
        let mut runs = vec![run("path", "", "none")];
        for gather in ["brute", "points-rt", "points-bvh", "points-grid", "photons-grid", "photons-rt"] {
            for (method, history) in
                [("basic", "none"), ("basic", "paper"), ("basic", "validated"), ("kim2019", "none")]
            {
                runs.push(run(method, gather, history));
            }
        }
        let names = Names::new(&runs);
        let looks = runs.iter().map(|run| names.series(&run.result.config));
        let looks: BTreeSet<_> = looks.map(|series| (names.color(series), names.shape(series))).collect();
        assert_eq!(looks.len(), runs.len());
        let of_path: Vec<_> = looks.iter().filter(|(color, _)| color == "c0").collect();
        assert_eq!(of_path.len(), 1);
        let without = Names::new(&runs[1..]);
        assert!((0..24).all(|series| without.color(series) != "c0"));
    }

    #[test]
    fn names_contain_the_differing_values() {
        let mut runs = [run("basic", "brute", "paper"), run("basic", "brute", "paper")];
        for (parameter, value) in [(&RUNNER, "gpu-software"), (&PATHS_PER_PIXEL, "0.5"), (&FEATURES, "all")] {
            runs[1].result.config.set(parameter, value);
        }
        runs[1].result.error = Some(ErrorResult { width: 64, height: 36, ..ErrorResult::default() });
        let names = Names::new(&runs);
        assert_eq!(names.label(&runs[0]), "basic + paper · brute");
        let label = "basic + paper · brute · gpu-software · all features · 0.5 paths/px · 64×36";
        assert_eq!(names.label(&runs[1]), label);
        assert_eq!(names.get(0).name(), "basic + paper · brute");
    }

    #[test]
    fn configurations_of_another_commit_or_device_are_told_apart() {
        let mut runs = [run("basic", "", ""), run("basic", "", ""), run("path", "", "")];
        let commit = |letter: &str| format!("{}-dirty", letter.repeat(40));
        for (run, letter) in runs.iter_mut().zip(["a", "b", "b"]) {
            run.result.provenance.commit = commit(letter);
            run.result.provenance.device = "CPU, 2 threads".into();
        }
        let names = Names::new(&runs);
        assert_eq!(names.label(&runs[0]), "basic · commit aaaaaaaa-dirty");
        assert_eq!(names.label(&runs[1]), "basic · commit bbbbbbbb-dirty");
        let alike = names.among(&[&runs[1], &runs[2]]);
        assert_eq!(alike.label(&runs[1]), "basic");
        assert_eq!(alike.origin(&runs[1]), "");
        runs[1].result.provenance.device = "a GPU".into();
        assert_eq!(Names::new(&runs[1..]).label(&runs[1]), "basic · a GPU");
    }
}
