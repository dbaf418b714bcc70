//! Steps of a history: both runners hold equal inputs before each step, and its outputs are compared.

use std::collections::BTreeSet;

use caustics_kernels::declare::Step;
use caustics_kernels::declare::{Pass, Work};
use caustics_kernels::emission::POWER;
use caustics_kernels::history::cells::WORDS;
use caustics_kernels::history::resolve_history::RESOLVE_HISTORY;
use caustics_kernels::history::validated::validate::VALIDATE;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::history::{HistoryPoint, Reprojected, VALIDATION_PHOTONS, ValidationPhoton};
use caustics_kernels::interface::point::PointGeometry;
use caustics_kernels::math::octahedral;
use caustics_tests::compare::{Difference, Tolerance, floats, records, words};
use caustics_tests::fields::Field;
use caustics_tests::matching::Photon;
use caustics_tests::parity::RunnerPair;
use caustics_tests::table::Table;
use caustics_tests::tremble::LightPathContext;
use glam::Vec3;

use super::Animation;

const RULE: &str = "the parity rule: a pass amplifies ulps, but not beyond 1e-4";
const NEAR: Tolerance = Tolerance::relative(1.0e-4, 1.0, RULE);
const PATHS: &str = "the parity rule: 0.2 % of the paths may diverge";
/// Tolerance of the fluxes of whole paths, as in the parity test of light paths.
const FLUX: Tolerance = Tolerance::relative(1.0e-3, 0.0, "grazing cosines amplify ulps along a path");

/// Runs a step: on both runners if it belongs to the history, else on the CPU.
pub fn one(animation: &mut Animation, params: &FrameParams, step: Step, table: &mut Table) {
    let history = |pass: &Pass| pass.work == Work::Reuse || *pass == RESOLVE_HISTORY;
    let pass = match step {
        Step::Dispatch { pass, .. } if history(pass) => pass,
        _ => {
            animation.runners.cpu.run(params, &[step]).expect("the CPU runs the step");
            return;
        }
    };
    let written: Vec<&str> = pass.written().map(|bound| bound.name).collect();
    animation.runners.copy_to_gpu(&[step]);
    animation.runners.run(params, &[step]);
    let runners = &mut animation.runners;
    for buffer in runners.bound(&[step]) {
        if !written.contains(&buffer) {
            let (cpu, gpu) = runners.records::<u32>(buffer);
            assert!(cpu == gpu, "{step:?} wrote to {buffer}");
        }
    }
    let features = runners.features;
    if *pass == VALIDATE {
        validate(
            runners,
            LightPathContext { scene: &animation.scene, params, features, emission: &POWER },
            table,
        );
    } else if *pass == RESOLVE_HISTORY {
        table.add(pass.name, remembered(runners));
    } else {
        table.add(pass.name, reprojected(runners));
    }
}

/// Compares validation paths, photon by photon, and the marks that they make.
fn validate(runners: &mut RunnerPair, paths: LightPathContext<'_>, table: &mut Table) {
    let (cpu, gpu) = runners.records::<ValidationPhoton>("validation_photons");
    let stored = cpu.iter().filter(|photon| photon.flux > 0.0).count();
    assert!(stored > 200, "only {stored} photons");
    let fields = records(&cpu, &gpu, Tolerance::EXACT.except(2.0e-3, PATHS), |field| {
        let tolerance = if field.name == "flux" { FLUX } else { NEAR };
        tolerance.except(2.0e-3, PATHS)
    });
    let records = fields.iter().flat_map(|field| field.indices.iter());
    let parted: BTreeSet<u32> = records.map(|&record| record as u32 / VALIDATION_PHOTONS).collect();
    let unexplained: Vec<_> =
        parted.iter().filter(|&&path| paths.explain_validation(path, diverges).is_none()).collect();
    eprintln!("{stored} photons of validation; diverging paths {parted:?}, unexplained {unexplained:?}");
    table.add("validate", fields);
    let count = cpu.len() / VALIDATION_PHOTONS as usize;
    table.add("validate", [all("diverging paths", count, parted.len(), 2.0e-3, PATHS)]);
    table.add("validate", [all("unexplained", count, unexplained.len(), 0.0, PATHS)]);

    table.add("validate", cells(runners));
}

/// Compares the sums over the marks of all cells, relative to the sums of the compared quantities.
fn cells(runners: &mut RunnerPair) -> Vec<Difference> {
    let (cpu, gpu) = runners.records::<u32>("validation_cells");
    let cells = |words: &[u32]| words.chunks_exact(WORDS as usize).map(Cell::new).collect::<Vec<_>>();
    let (cpu, gpu) = (cells(&cpu), cells(&gpu));
    let total = |quantity: fn(&Cell) -> i64| cpu.iter().map(|cell| quantity(cell) as usize).sum::<usize>();
    let (marks, light) = (total(|cell| cell.marks), total(|cell| cell.before));
    assert!(marks > 0 && light > 0, "no marks");
    let paths = "0.2 % of the paths may diverge, or mark across a cell's face";
    // 1e-6 of a room of 4 m over a radius of a centimetre is a tenth of a unit: one mark in ten rounds otherwise.
    let moved = total(|cell| cell.moved);
    let rounded = 2.0e-3 + 0.1 * marks as f64 / moved.max(1) as f64;
    let rounds = "0.2 % of the paths may diverge, and a mark in ten may round to the next unit";
    // A path that diverges changes by all of its light: on average, the light of a mark.
    let squares = (light as f64 / marks as f64 * light as f64) as usize;
    type Quantity = fn(&Cell) -> i64;
    let sums: [(&str, Quantity, usize, f64, &'static str); 6] = [
        ("marks", |cell| cell.marks, marks, 2.0e-3, paths),
        ("moved", |cell| cell.moved, moved, rounded, rounds),
        ("changes", |cell| cell.changes, marks, 2.0e-3, paths),
        ("light before", |cell| cell.before, light, 2.0e-3, paths),
        ("change", |cell| cell.change, light, 2.0e-3, paths),
        ("squares", |cell| cell.squares, squares, 2.0e-3, paths),
    ];
    let compare = |(name, quantity, total, share, reason): (&str, Quantity, usize, f64, &'static str)| {
        let apart =
            cpu.iter().zip(&gpu).map(|(a, b)| quantity(a).abs_diff(quantity(b)) as usize).sum::<usize>();
        all(name, total, apart, share, reason)
    };
    sums.into_iter().map(compare).collect()
}

/// Sums of a cell, in quanta.
struct Cell {
    marks: i64,
    moved: i64,
    changes: i64,
    before: i64,
    change: i64,
    squares: i64,
}

impl Cell {
    fn new(words: &[u32]) -> Cell {
        let long = |low: usize| (u64::from(words[low + 1]) << 32 | u64::from(words[low])) as i64;
        let [marks, moved, changes] = [words[0], words[1], words[2]].map(i64::from);
        Cell { marks, moved, changes, before: long(3), change: long(5), squares: long(7) }
    }
}

/// Whether two versions of a path differ by more than the comparison allows.
fn diverges(a: &[Photon], b: &[Photon]) -> bool {
    let validation_photons = |photons: &[Photon]| -> Vec<ValidationPhoton> {
        let records = photons.iter().take(VALIDATION_PHOTONS as usize);
        records
            .map(|(geometry, light)| ValidationPhoton {
                position: geometry.position,
                flux: light.flux.element_sum(),
                instance: geometry.instance,
            })
            .collect()
    };
    let (a, b) = (validation_photons(a), validation_photons(b));
    let tolerance = |field: &Field| if field.name == "flux" { FLUX } else { NEAR };
    a.len() != b.len()
        || records(&a, &b, Tolerance::EXACT, tolerance).iter().any(|difference| difference.exceeding > 0)
}

/// Compares light of the previous frame that is reused.
fn reprojected(runners: &mut RunnerPair) -> Vec<Difference> {
    let (cpu, gpu) = runners.records::<Reprojected>("reprojected");
    let (points, _) = runners.records::<PointGeometry>("point_geometry");
    let reusing = cpu.iter().filter(|reprojected| reprojected.samples > 0.0).count();
    assert!(reusing > cpu.len() / 2, "only {reusing} points reuse light");
    let scale = cpu.iter().map(|reprojected| reprojected.mean.max_element()).sum::<f32>() / cpu.len() as f32;
    let flips = "the nearest history point may be another one of two that are as near, or one on the bound";
    let fields = records(&cpu, &gpu, Tolerance::EXACT, |field| {
        let absolute = match field.name {
            "mean" => 1.0e-4 * scale,
            "samples" => 0.0,
            _ => 1.0e-5,
        };
        Tolerance { absolute, ..NEAR }.except(2.0e-3, flips)
    });
    let pixels: BTreeSet<usize> = fields.iter().flat_map(|field| field.indices.iter().copied()).collect();
    for &pixel in pixels.iter().take(8) {
        eprintln!("pixel {pixel} {:?}:\n  {:?}\n  {:?}", points[pixel], cpu[pixel], gpu[pixel]);
    }
    let pixels = all("pixels", cpu.len(), pixels.len(), 2.0e-3, flips);
    fields.into_iter().chain([pixels]).collect()
}

/// Compares the image, and the history that it leaves to the next frame.
fn remembered(runners: &mut RunnerPair) -> Vec<Difference> {
    let mut found = vec![];
    for buffer in ["caustic_radiance", "history_mean"] {
        let (cpu, gpu) = runners.records::<f32>(buffer);
        let scale = cpu.iter().sum::<f32>() / cpu.len() as f32;
        assert!(scale > 0.0);
        found.push(floats(buffer, 3, &cpu, &gpu, Tolerance { absolute: 1.0e-4 * scale, ..NEAR }));
    }
    found.extend(points(runners, "history_points"));
    found
}

/// Compares history points as the next frame finds them.
pub fn points(runners: &mut RunnerPair, buffer: &str) -> Vec<Difference> {
    let (cpu, gpu) = runners.records::<HistoryPoint>(buffer);
    let mut found = vec![];
    let column = |points: &[HistoryPoint], vector: fn(&HistoryPoint) -> Vec3| -> Vec<f32> {
        points.iter().flat_map(|point| vector(point).to_array()).collect()
    };
    let step = Tolerance { absolute: 0.0, ..NEAR };
    type Vector = fn(&HistoryPoint) -> Vec3;
    let vectors: [(&str, Vector, Tolerance); 4] = [
        ("position", |point| point.position, NEAR),
        ("radius, samples", |point| Vec3::new(point.radius, point.samples, 0.0), step),
        ("normal", |point| octahedral::decode(point.normal), NEAR),
        ("to_viewer", |point| octahedral::decode(point.to_viewer), NEAR),
    ];
    for (name, vector, tolerance) in vectors {
        found.push(floats(name, 3, &column(&cpu, vector), &column(&gpu, vector), tolerance));
    }
    let ids = |points: &[HistoryPoint]| points.iter().map(|point| point.material).collect::<Vec<_>>();
    found.push(words("material", 1, &ids(&cpu), &ids(&gpu), Tolerance::EXACT));
    found
}

/// Returns a difference in which `exceeding` of `count` elements exceed.
fn all(name: &str, count: usize, exceeding: usize, share: f64, reason: &'static str) -> Difference {
    let tolerance = Tolerance::EXACT.except(share, reason);
    Difference {
        name: name.into(),
        count,
        max_abs: exceeding as f32,
        max_rel: exceeding as f32 / count as f32,
        exceeding,
        first: None,
        indices: vec![],
        tolerance,
    }
}
