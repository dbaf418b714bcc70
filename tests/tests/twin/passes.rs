//! Every pass on the CPU's inputs: before each step both runners hold the same, after it every buffer is compared.

use caustics::method::{Step, basic, gather};
use caustics::scene::Scene;
use caustics_kernels::gather::accumulator::{Sum, WORDS};
use caustics_kernels::gather::contribution::{DISC_THICKNESS, MIN_NORMAL_COS};
use caustics_kernels::gather::variant::{self, BRUTE, PHOTONS_GRID, Variant};
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::point::{DepositGeometry, PointGeometry};
use caustics_tests::compare::{Difference, Tolerance, floats, words};
use caustics_tests::table::Table;
use caustics_tests::tremble::Paths;
use caustics_tests::twin::{self, Twin};
use glam::Vec3;

use crate::paths;

/// Contract 8: floats of a pass over equal inputs.
pub const NEAR: Tolerance =
    Tolerance::relative(1.0e-4, 1.0, "the rule for twins: a pass amplifies ulps, but not beyond 1e-4");

/// A frame of `photons-grid` step by step, then the other gathers over the same points and deposits.
pub fn all(twin: &mut Twin, scene: &Scene, hardware: bool, table: &mut Table) {
    for step in basic::steps(&PHOTONS_GRID, twin.params) {
        if matches!(step, Step::Index { .. } | Step::Structure { .. }) {
            twin.run(&[step]);
        } else {
            one(twin, scene, step, table);
        }
    }
    let params = twin.params;
    for variant in variant::ALL.iter().filter(|variant| !variant.hardware) {
        gathers(twin, variant, table);
    }
    if hardware {
        by_ray_queries(twin, params, table);
    }
}

/// The steps of a gather over the points and deposits at hand.
fn over_deposits(variant: &'static Variant, params: FrameParams) -> Vec<Step> {
    let mut steps: Vec<Step> =
        ["accumulator", "counters"].map(|buffer| Step::Clear { buffer }).into_iter().collect();
    steps.extend(gather::prepare(variant, params));
    steps.extend(gather::batch(variant, params));
    let shoots =
        |step: &Step| matches!(step, Step::Dispatch { .. } | Step::Clear { buffer: "deposit_state" });
    steps.retain(|step| !shoots(step));
    steps
}

/// Builds and gathers on both, each in its own order, and compares the sums.
fn gathers(twin: &mut Twin, variant: &'static Variant, table: &mut Table) {
    twin.copy_to_gpu();
    twin.run(&over_deposits(variant, twin.params));
    let params = twin.params;
    table.add(variant.gather_pass, sums(twin, &params));
}

/// The buffers that a pass writes.
fn outputs(pass: &str) -> &'static [&'static str] {
    match pass {
        "collect" => &["path_radiance", "seen_radiance", "point_geometry", "point_shading", "counters"],
        "shoot.store" => &["deposit_geometry", "deposit_light", "deposit_state", "counters"],
        "gather.photons_grid" => &["accumulator", "counters"],
        "resolve" => &["caustic_radiance"],
        "display" => &["display_color"],
        other => panic!("what does {other} write?"),
    }
}

/// Runs one step on equal inputs and compares all that it wrote, and that it wrote nothing else.
fn one(twin: &mut Twin, scene: &Scene, step: Step, table: &mut Table) {
    twin.copy_to_gpu();
    twin.run(&[step]);
    let (pass, params) = match step {
        Step::Dispatch { pass, params, .. } => (pass, params),
        Step::Gather { gather, params, .. } => (gather.gather_pass, params),
        _ => ("", twin.params),
    };
    let written = if pass.is_empty() { &[] } else { outputs(pass) };
    for buffer in twin.frame_buffers().to_vec() {
        if !written.contains(&buffer) {
            let (cpu, gpu) = twin.rows::<u32>(buffer);
            assert!(cpu == gpu, "{step:?} wrote to {buffer}");
        }
    }
    let needs = twin.needs;
    let whole = Paths { scene, params: &params, needs };
    match pass {
        "" => return,
        "collect" => paths::collect(twin, whole, table),
        "shoot.store" => paths::shoot(twin, whole, table),
        "gather.photons_grid" => table.add(pass, sums(twin, &params)),
        _ => {}
    }
    for &buffer in written {
        let difference = match buffer {
            "caustic_radiance" | "display_color" => {
                let (cpu, gpu) = twin.rows::<f32>(buffer);
                let scale = cpu.iter().sum::<f32>() / cpu.len() as f32;
                floats(buffer, 3, &cpu, &gpu, Tolerance { absolute: 1.0e-4 * scale, ..NEAR })
            }
            "counters" if !pass.starts_with("gather") => {
                let (cpu, gpu) = twin.rows::<u32>(buffer);
                let numbers = |words: &[u32]| words.iter().map(|&word| word as f32).collect::<Vec<_>>();
                floats(buffer, 1, &numbers(&cpu), &numbers(&gpu), paths::COUNTS)
            }
            _ => continue,
        };
        table.add(pass, [difference]);
    }
}

/// The sums of a gather. Counts may differ only at points with a deposit on the very bound of what they take.
fn sums(twin: &mut Twin, params: &FrameParams) -> Vec<Difference> {
    let (cpu, gpu) = twin.rows::<u32>("accumulator");
    let read = |words: &[u32]| {
        let sums = (0..params.pixel_count()).map(|pixel| Sum::read(words, pixel, params.quantum));
        sums.unzip::<Vec3, u32, Vec<_>, Vec<_>>()
    };
    let ((cpu_sums, cpu_counts), (gpu_sums, gpu_counts)) = (read(&cpu), read(&gpu));
    let bound = Tolerance::EXACT.except(1.0e-3, "pairs within 1e-5 of the disc's bound");
    let counts = words("deposits", 1, &cpu_counts, &gpu_counts, bound);
    let unexplained = on_the_bound(twin, &counts.indices);
    let total = |counts: &[u32]| counts.iter().sum::<u32>();
    assert!(total(&cpu_counts) > 5000, "the frame has a caustic: {}", total(&cpu_counts));
    let scale = cpu_sums.iter().map(|sum| sum.max_element()).fold(0.0, f32::max);
    let near = Tolerance::relative(1.0e-4, 1.0e-3 * scale, "the rule for twins, of sums of f times flux");
    let (cpu_sums, gpu_sums) = (bytemuck::cast_slice(&cpu_sums), bytemuck::cast_slice(&gpu_sums));
    vec![
        floats("sum", 3, cpu_sums, gpu_sums, near.except(1.0e-3, "pairs within 1e-5 of the disc's bound")),
        counts,
        words("counts unexplained", 1, &vec![0; unexplained], &[], Tolerance::EXACT),
    ]
}

/// Of these pixels those without a deposit within 1e-5 of what decides whether it is taken.
fn on_the_bound(twin: &mut Twin, pixels: &[usize]) -> usize {
    let (points, _) = twin.rows::<PointGeometry>("point_geometry");
    let (deposits, _) = twin.rows::<DepositGeometry>("deposit_geometry");
    let near = |a: f32, b: f32| (a - b).abs() <= 1.0e-5 * b;
    let decides = |point: &PointGeometry, deposit: &DepositGeometry| {
        let along = deposit.position - point.position;
        let normals = point.normal + deposit.normal;
        let limit = DISC_THICKNESS * point.radius * normals.length();
        near(along.length(), point.radius)
            || near(point.normal.dot(deposit.normal), MIN_NORMAL_COS)
            || (near(along.dot(normals).abs(), limit) && along.length() < 1.01 * point.radius)
    };
    let has = |&&pixel: &&usize| !deposits.iter().any(|deposit| decides(&points[pixel], deposit));
    pixels.iter().filter(has).count()
}

/// Gathers by ray queries against brute force over the same deposits on the same device, and against the CPU's.
fn by_ray_queries(twin: &mut Twin, params: FrameParams, table: &mut Table) {
    let (cpu, _) = twin.rows::<u32>("accumulator");
    twin.copy_to_gpu();
    let mut run = |variant| {
        let steps = over_deposits(variant, params);
        twin.gpu.run(&steps).expect("the GPU runs the steps and the validation layer is silent");
        twin::rows::<u32>(&mut *twin.gpu, "accumulator")
    };
    let brute = run(&BRUTE);
    let total = |words: &[u32]| {
        let sums = (0..params.pixel_count()).map(|pixel| Sum::read(words, pixel, params.quantum));
        sums.fold([0.0f32; 4], |t, (sum, n)| [t[0] + sum.x, t[1] + sum.y, t[2] + sum.z, t[3] + n as f32])
    };
    for variant in variant::ALL.iter().filter(|variant| variant.hardware) {
        let found = run(variant);
        let title = format!("{} = brute", variant.gather_pass);
        table.add(&title, [words("accumulator", WORDS as usize, &brute, &found, Tolerance::EXACT)]);
        table.add(variant.gather_pass, [floats("totals", 1, &total(&cpu), &total(&found), paths::COUNTS)]);
    }
}
