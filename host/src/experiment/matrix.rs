//! All combinations of what can vary, without those that no runner has and those that are another's frames again.

use std::collections::BTreeSet;

use caustics_kernels::gather::variant::Variant;

use super::cell::{Cell, Code, Paths, has_ray_queries, name_all, runner_name, usual_gather};
use crate::session::RunnerChoice;
use caustics_kernels::denoiser::Denoiser;
use caustics_kernels::history::History;
use caustics_kernels::method::Method;

/// Names of runners where several can be given.
pub const RUNNERS: [&str; 5] = ["auto", "cpu", "gpu", "gpu-hardware", "gpu-software"];

/// Lists of what can vary.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// Methods.
    pub methods: Vec<&'static Method>,
    /// Gathers; none: the runner's usual one.
    pub gathers: Vec<&'static Variant>,
    /// Histories.
    pub histories: Vec<&'static History>,
    /// Filters.
    pub denoisers: Vec<&'static Denoiser>,
    /// Light paths.
    pub paths: Vec<Paths>,
    /// Radii of collection points relative to the disc of a pixel's footprint.
    pub radii: Vec<f32>,
    /// Largest numbers of scattering vertices.
    pub bounces: Vec<u32>,
    /// Runners.
    pub runners: Vec<RunnerChoice>,
    /// Kernel code.
    pub codes: Vec<Code>,
}

/// Cells of a matrix.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    /// Each once, named.
    pub cells: Vec<Cell>,
    /// What cannot be, a line each.
    pub skipped: Vec<String>,
}

impl Matrix {
    /// The cells, in the order of the lists; the last list to vary fastest is that of the histories.
    pub fn cells(&self) -> Cells {
        let mut all = Cells::default();
        for runner in &self.runners {
            let usual = [usual_gather(runner)];
            let asked = if self.gathers.is_empty() { &usual[..] } else { &self.gathers };
            let (can, cannot): (Vec<&Variant>, Vec<&Variant>) =
                asked.iter().partition(|gather| !gather.hardware || has_ray_queries(runner));
            // A method that chooses no gather is rendered whichever are there.
            let gathers: Vec<Option<&Variant>> = can.into_iter().map(Some).chain([None]).collect();
            let mut is_missed = false;
            for &code in &self.codes {
                for &max_bounces in &self.bounces {
                    for &radius_px in &self.radii {
                        for &paths in &self.paths {
                            for &method in &self.methods {
                                let chooses = Cell::of(method).gather.is_some();
                                is_missed |= chooses;
                                for gather in gathers.iter().filter(|gather| gather.is_some() == chooses) {
                                    for &denoiser in &self.denoisers {
                                        for &history in &self.histories {
                                            let cell = Cell {
                                                name: String::new(),
                                                method,
                                                gather: *gather,
                                                history,
                                                denoiser,
                                                paths,
                                                radius_px,
                                                max_bounces,
                                                runner: runner.clone(),
                                                code,
                                            };
                                            all.cells.push(cell.effective());
                                        }
                                    }
                                }
                            }
                        }
                    }
                }
            }
            for gather in cannot.iter().filter(|_| is_missed) {
                let (gather, runner) = (gather.name, runner_name(runner));
                all.skipped
                    .push(format!("gather {gather} needs ray queries, and {runner} has none: skipped"));
            }
        }
        keep_one_of_each(&mut all.cells);
        name_all(&mut all.cells);
        all
    }
}

/// Leaves the first of cells that render the same.
pub fn keep_one_of_each(cells: &mut Vec<Cell>) {
    let mut seen = BTreeSet::new();
    cells.retain(|cell| seen.insert(cell.key()));
}

#[cfg(test)]
mod tests {
    use caustics_kernels::gather::variant;

    use super::*;
    use caustics_kernels::method::basic::BASIC;
    use caustics_kernels::method::path::PATH;
    use caustics_kernels::{denoiser, history};

    fn matrix() -> Matrix {
        Matrix {
            methods: vec![&BASIC, &PATH],
            gathers: variant::ALL.iter().collect(),
            histories: history::ALL.to_vec(),
            denoisers: denoiser::ALL.to_vec(),
            paths: vec![Paths::PerPixel(0.5), Paths::PerPixel(1.0)],
            radii: vec![1.0, 2.0],
            bounces: vec![5],
            runners: vec![RunnerChoice::Cpu { threads: 0 }],
            codes: vec![Code::Scene, Code::All],
        }
    }

    #[test]
    fn every_combination_is_there_once() {
        let Cells { cells, skipped } = matrix().cells();
        let software = variant::ALL.iter().filter(|gather| !gather.hardware).count();
        let basic = software * history::ALL.len() * denoiser::ALL.len() * 2 * 2 * 2;
        // The path tracer knows but the code.
        assert_eq!(cells.len(), basic + 2);
        assert_eq!(skipped.len(), variant::ALL.len() - software);
        let mut names: Vec<&str> = cells.iter().map(|cell| cell.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), cells.len(), "names are told apart");
    }

    #[test]
    fn a_gather_that_no_runner_has_leaves_the_methods_without_one() {
        let hardware = variant::ALL.iter().filter(|gather| gather.hardware).collect();
        let Cells { cells, skipped } = Matrix { gathers: hardware, ..matrix() }.cells();
        assert!(cells.iter().all(|cell| cell.method.name == "path"), "{cells:?}");
        assert!(!skipped.is_empty());
        let alone =
            Matrix { methods: vec![&PATH], gathers: vec![variant::find("points-rt").unwrap()], ..matrix() };
        assert!(alone.cells().skipped.is_empty(), "nothing was asked for that is not there");
    }
}
