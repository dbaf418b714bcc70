//! Names of cells, and the colours and shapes that tell them apart in every figure of a report.

use super::load::Measured;
use super::number::short;
use crate::parameter::{METHOD, PARAMETERS, Parameter, Values, VisualEncoding};
use crate::result::{CellConfig, Provenance};

/// Number of colours in `report.css`.
pub const COLORS: usize = 10;
/// Outlines of marks, within 6 px of their middle; the first is that of methods without a gather.
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

/// Size of the image that was timed, else of that whose error is known (px).
pub fn size(cell: &Measured) -> String {
    let time = cell.result.time.as_ref().map(|time| (time.width, time.height));
    let error = || cell.result.error.as_ref().map(|error| (error.width, error.height));
    time.or_else(error).map_or(String::new(), |(width, height)| format!("{width}×{height}"))
}

/// What is told apart by colour and shape: all that decides how a frame is rendered, but for numbers and positions.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Series {
    /// Method, history and filter: the colour.
    pub kind: String,
    /// How photons and points meet: the shape; empty where there is none.
    pub gather: String,
}

impl Series {
    /// The series of a cell.
    pub fn new(cell: &CellConfig) -> Series {
        let shown_as = |wanted: fn(&VisualEncoding) -> bool| {
            let parameters = PARAMETERS.into_iter().filter(move |parameter| wanted(&parameter.shown));
            // A method is said, and of the rest what adds something to it.
            let named = parameters
                .filter(|parameter| **parameter == METHOD || cell.text(parameter) != parameter.neutral);
            let texts = named.map(|parameter| cell.text(parameter)).filter(|name| is_informative(name));
            texts.collect::<Vec<_>>().join(" + ")
        };
        Series {
            kind: shown_as(|shown| matches!(shown, VisualEncoding::Color)),
            gather: shown_as(|shown| matches!(shown, VisualEncoding::Shape)),
        }
    }

    /// In a legend.
    pub fn name(&self) -> String {
        [&self.kind, &self.gather]
            .map(String::as_str)
            .into_iter()
            .filter(|name| is_informative(name))
            .collect::<Vec<_>>()
            .join(" · ")
    }
}

/// Whether a name stands for something.
fn is_informative(name: &str) -> bool {
    !name.is_empty() && name != "none"
}

/// Names, colours and shapes of all cells of a report.
#[derive(Clone, Debug, Default)]
pub struct Names {
    kinds: Vec<String>,
    gathers: Vec<String>,
    series: Vec<Series>,
    varies: Vec<&'static Parameter>,
    sizes_vary: bool,
    origins_vary: Vec<&'static Origin>,
}

/// What may tell apart where cells were measured.
type Origin = fn(&Provenance) -> String;

const ORIGINS: [Origin; 4] = [
    |provenance| short_hash("commit", &provenance.commit),
    |provenance| short_hash("kernels", &provenance.kernels),
    |provenance| provenance.device.clone(),
    |provenance| provenance.machine.clone(),
];

/// The start of a hash, and what it is of.
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
    /// Finds what there is to tell apart.
    pub fn new(cells: &[Measured]) -> Names {
        let mut series: Vec<Series> = cells.iter().map(|cell| Series::new(&cell.result.cell)).collect();
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
        names.among(&cells.iter().collect::<Vec<_>>())
    }

    /// The same colours and shapes, and words for what differs among some of the cells only.
    pub fn among(&self, cells: &[&Measured]) -> Names {
        let differ =
            |value: &dyn Fn(&Measured) -> String| cells.iter().any(|cell| value(cell) != value(cells[0]));
        let origins = ORIGINS.iter();
        Names {
            varies: PARAMETERS
                .into_iter()
                .filter(|parameter| differ(&|cell| cell.result.cell.text(parameter)))
                .collect(),
            sizes_vary: differ(&|cell| size(cell)),
            origins_vary: origins.filter(|origin| differ(&|cell| origin(&cell.result.provenance))).collect(),
            ..self.clone()
        }
    }

    /// Where a cell was measured, as far as the cells differ in it: commit, kernels, device, machine.
    pub fn origin(&self, cell: &Measured) -> String {
        let words = self.origins_vary.iter().map(|origin| origin(&cell.result.provenance));
        words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" · ")
    }

    /// Index of the cell's series.
    pub fn series(&self, cell: &CellConfig) -> usize {
        let own = Series::new(cell);
        self.series.iter().position(|series| *series == own).unwrap_or(0)
    }

    /// The series of this index.
    pub fn get(&self, series: usize) -> &Series {
        &self.series[series]
    }

    /// The class of the cell's colour: `c0` is that of `path`.
    pub fn color(&self, series: usize) -> String {
        let kind = self.kinds.iter().position(|kind| *kind == self.series[series].kind).unwrap_or(0);
        let rank = if self.kinds.first().is_some_and(|kind| kind == "path") { kind } else { kind + 1 };
        let color = if rank == 0 { 0 } else { 1 + (rank - 1) % (COLORS - 1) };
        format!("c{color}")
    }

    /// The outline of its marks, around 0.
    pub fn shape(&self, series: usize) -> &'static str {
        let gather = self.gathers.iter().position(|gather| *gather == self.series[series].gather);
        SHAPES[gather.unwrap_or(0) % SHAPES.len()]
    }

    /// The cell's name among all cells of its scene.
    pub fn label(&self, cell: &Measured) -> String {
        let (size, origin) = (size(cell), self.origin(cell));
        let cell = &cell.result.cell;
        let mut parts = vec![Series::new(cell).name()];
        for parameter in PARAMETERS {
            let VisualEncoding::Words(_, words) = parameter.shown else { continue };
            let text = match parameter.values {
                Values::Numbers(_) if cell.number(parameter) > 0.0 => short(cell.number(parameter)),
                Values::Numbers(_) => continue,
                Values::Names(_) if cell.text(parameter) == parameter.neutral => continue,
                Values::Names(_) => cell.text(parameter),
            };
            if !text.is_empty() && self.varies.contains(&parameter) {
                parts.push(words(&text));
            }
        }
        if self.sizes_vary && !size.is_empty() {
            parts.push(size);
        }
        if cell.texture_filter == "finest" {
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
    use crate::result::{CellError, CellResult};
    use std::collections::BTreeSet;

    fn cell(method: &str, gather: &str, history: &str) -> Measured {
        let cell = CellConfig::default()
            .with(&METHOD, method)
            .with(&GATHER, gather)
            .with(&HISTORY, history)
            .with(&DENOISER, "none");
        Measured { result: CellResult { cell, ..CellResult::default() }, folder: "".into() }
    }

    #[test]
    fn series_differ_in_colour_or_shape_and_path_has_its_own() {
        let mut cells = vec![cell("path", "", "none")];
        for gather in ["brute", "points-rt", "points-bvh", "points-grid", "photons-grid", "photons-rt"] {
            for (method, history) in
                [("basic", "none"), ("basic", "paper"), ("basic", "validated"), ("kim2019", "none")]
            {
                cells.push(cell(method, gather, history));
            }
        }
        let names = Names::new(&cells);
        let looks = cells.iter().map(|cell| names.series(&cell.result.cell));
        let looks: BTreeSet<_> = looks.map(|series| (names.color(series), names.shape(series))).collect();
        assert_eq!(looks.len(), cells.len());
        let of_path: Vec<_> = looks.iter().filter(|(color, _)| color == "c0").collect();
        assert_eq!(of_path.len(), 1);
        let without = Names::new(&cells[1..]);
        assert!((0..24).all(|series| without.color(series) != "c0"));
    }

    #[test]
    fn names_say_what_differs() {
        let mut cells = [cell("basic", "brute", "paper"), cell("basic", "brute", "paper")];
        for (parameter, value) in [(&RUNNER, "gpu-software"), (&PATHS_PER_PIXEL, "0.5"), (&FEATURES, "all")] {
            cells[1].result.cell.set(parameter, value);
        }
        cells[1].result.error = Some(CellError { width: 64, height: 36, ..CellError::default() });
        let names = Names::new(&cells);
        assert_eq!(names.label(&cells[0]), "basic + paper · brute");
        let label = "basic + paper · brute · gpu-software · all features · 0.5 paths/px · 64×36";
        assert_eq!(names.label(&cells[1]), label);
        assert_eq!(names.get(0).name(), "basic + paper · brute");
    }

    #[test]
    fn cells_of_another_commit_or_device_are_told_apart() {
        let mut cells = [cell("basic", "", ""), cell("basic", "", ""), cell("path", "", "")];
        let commit = |letter: &str| format!("{}-dirty", letter.repeat(40));
        for (cell, letter) in cells.iter_mut().zip(["a", "b", "b"]) {
            cell.result.provenance.commit = commit(letter);
            cell.result.provenance.device = "CPU, 2 threads".into();
        }
        let names = Names::new(&cells);
        assert_eq!(names.label(&cells[0]), "basic · commit aaaaaaaa-dirty");
        assert_eq!(names.label(&cells[1]), "basic · commit bbbbbbbb-dirty");
        let alike = names.among(&[&cells[1], &cells[2]]);
        assert_eq!(alike.label(&cells[1]), "basic");
        assert_eq!(alike.origin(&cells[1]), "");
        cells[1].result.provenance.device = "a GPU".into();
        assert_eq!(Names::new(&cells[1..]).label(&cells[1]), "basic · a GPU");
    }
}
