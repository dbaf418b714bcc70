//! Every pass on the CPU's inputs: both runners hold equal inputs before each step, and every buffer is compared after
//! it.

use caustics::scene::Scene;
use caustics_kernels::declare::{Emission, Step, Work};
use caustics_kernels::emission::{self, POWER};
use caustics_kernels::gather::accumulator::{GatheredSum, WORDS};
use caustics_kernels::gather::contribution::{DISC_THICKNESS, MIN_NORMAL_COS};
use caustics_kernels::gather::variant::{self, BRUTE, PHOTONS_GRID, Variant};
use caustics_kernels::interface::balance::Balance;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::point::{PhotonGeometry, PointGeometry};
use caustics_kernels::method::basic;
use caustics_kernels::method::frame as gather;
use caustics_kernels::method::{Parts, Stages};
use caustics_kernels::pass::balance::BALANCE;
use caustics_kernels::pass::bound::BOUND;
use caustics_kernels::pass::widen::WIDEN;
use caustics_tests::compare::{Difference, Tolerance, floats, words};
use caustics_tests::parity::{self, RunnerPair};
use caustics_tests::table::Table;
use caustics_tests::tremble::LightPathContext;
use glam::Vec3;

use super::paths;

/// Tolerance of the floats of a pass over equal inputs.
pub const NEAR: Tolerance =
    Tolerance::relative(1.0e-4, 1.0, "the parity rule: a pass amplifies ulps, but not beyond 1e-4");

/// Compares a frame of `photons-grid` step by step, then the other gathers over the same points and photons.
pub fn all(runners: &mut RunnerPair, scene: &Scene, hardware: bool, table: &mut Table) {
    // Run two frames, the second of which knows the first.
    let first = runners.params;
    for index in 0..2 {
        runners.params = FrameParams { frame: first.frame + index, moved: 1 - index, ..first };
        let stages = Stages::NONE.with(&BALANCE, true).with(&BOUND, true).with(&WIDEN, true);
        let parts = Parts { stages, ..Parts::from(&PHOTONS_GRID) };
        for step in basic::steps(parts, &runners.params) {
            one(runners, scene, &POWER, step, table);
        }
    }
    let (balance, _) = runners.records::<Balance>("balance");
    assert!(balance[0].path_variance > 0.0 && balance[0].caustic_variance > 0.0, "{balance:?}");
    // Skip brute force: `frames` compares it with the others on each device, over fewer pairs.
    for variant in variant::ALL.iter().filter(|variant| !variant.hardware && **variant != BRUTE) {
        gathers(runners, variant, table);
    }
    if hardware {
        by_ray_queries(runners, table);
    }
    emissions(runners, scene, table);
}

/// Compares a frame of `photons-grid` step by step, for passes that decide where paths go. `all` runs the other passes
/// in another scene, because a software driver compiles them for minutes.
pub fn frame(runners: &mut RunnerPair, scene: &Scene, emission: &'static Emission, table: &mut Table) {
    let parts = Parts { emission, ..Parts::from(&PHOTONS_GRID) };
    for step in basic::steps(parts, &runners.params) {
        one(runners, scene, emission, step, table);
    }
}

/// Compares the light paths of the other emissions over the same points. Runs after the gathers, because these
/// emissions leave a hundred times as many pairs.
fn emissions(runners: &mut RunnerPair, scene: &Scene, table: &mut Table) {
    assert!(runners.params.casters.count > 0);
    for &emission in emission::ALL.iter().filter(|emission| **emission != &POWER) {
        let parts = Parts { emission, ..Parts::from(&PHOTONS_GRID) };
        let work = |step: &Step| match step {
            Step::Dispatch { pass, .. } => Some(pass.work),
            _ => None,
        };
        let steps = basic::steps(parts, &runners.params).into_iter();
        let steps = steps.filter(|step| work(step) != Some(Work::Camera));
        // Its pilot is gathered, and the emission learns from it.
        let mut gathers = u32::from(emission.stage.after_pilot.is_some());
        for step in steps {
            if work(&step) == Some(Work::Gather) {
                if gathers == 0 {
                    break;
                }
                gathers -= 1;
            }
            one(runners, scene, emission, step, table);
        }
    }
}

/// Steps of a gather over the current points and photons.
fn over_photons(variant: &'static Variant, params: &FrameParams) -> Vec<Step> {
    let mut steps = vec![Step::Clear { buffer: "accumulator" }, Step::Clear { buffer: "counters" }];
    steps.extend(gather::prepare(variant, params));
    steps.extend(gather::exchange(variant, params));
    steps
}

/// Builds and gathers on both runners, each in its own order, and compares the sums.
fn gathers(runners: &mut RunnerPair, variant: &'static Variant, table: &mut Table) {
    let params = runners.params;
    let steps = over_photons(variant, &params);
    runners.copy_to_gpu(&steps);
    runners.run(&params, &steps);
    table.add(variant.gather.name, sums(runners, &params));
}

/// Runs one step on equal inputs, compares all that it wrote, and asserts that it wrote nothing else. An index is
/// written in an order of its own.
fn one(runners: &mut RunnerPair, scene: &Scene, emission: &'static Emission, step: Step, table: &mut Table) {
    let params = runners.params;
    let Step::Dispatch { pass, .. } = step else { return runners.run(&params, &[step]) };
    runners.copy_to_gpu(&[step]);
    runners.run(&params, &[step]);
    let written: Vec<&str> = pass.written().map(|bound| bound.name).collect();
    for buffer in runners.bound(&[step]) {
        if !written.contains(&buffer) {
            let (cpu, gpu) = runners.records::<u32>(buffer);
            assert!(cpu == gpu, "{step:?} wrote to {buffer}");
        }
    }
    let features = runners.features;
    let whole = LightPathContext { scene, params: &params, features, emission };
    match pass.work {
        Work::Camera => paths::collect(runners, whole, table),
        Work::Light => paths::shoot(runners, whole, pass.name, table),
        Work::Gather => table.add(pass.name, sums(runners, &params)),
        _ => {}
    }
    for buffer in written {
        let difference = match buffer {
            "caustic_radiance" | "display_color" => {
                let (cpu, gpu) = runners.records::<f32>(buffer);
                let scale = cpu.iter().sum::<f32>() / cpu.len() as f32;
                floats(buffer, 3, &cpu, &gpu, Tolerance { absolute: 1.0e-4 * scale, ..NEAR })
            }
            // Guided emission computes these from scores: `sqrt` may be off by ulps.
            "guide_sums" | "guide_pyramid" | "pixel_means" | "pixel_weights" | "image_rows"
            | "balance_rows" | "radius_now" | "radius_next" => {
                let (cpu, gpu) = runners.records::<f32>(buffer);
                floats(buffer, 1, &cpu, &gpu, NEAR)
            }
            "balance" => {
                let (cpu, gpu) = runners.records::<u32>(buffer);
                let paths = words("light paths", 1, &cpu[4..], &gpu[4..], Tolerance::EXACT);
                table.add(pass.name, [paths]);
                let numbers =
                    |words: &[u32]| words[..4].iter().map(|&word| f32::from_bits(word)).collect::<Vec<_>>();
                floats(buffer, 4, &numbers(&cpu), &numbers(&gpu), NEAR)
            }
            "point_geometry" if pass.work != Work::Camera => {
                let (cpu, gpu) = runners.records::<PointGeometry>(buffer);
                let radii =
                    |points: &[PointGeometry]| points.iter().map(|point| point.radius).collect::<Vec<_>>();
                floats(buffer, 1, &radii(&cpu), &radii(&gpu), NEAR)
            }
            "counters" if pass.work != Work::Gather => {
                let (cpu, gpu) = runners.records::<u32>(buffer);
                let numbers = |words: &[u32]| words.iter().map(|&word| word as f32).collect::<Vec<_>>();
                floats(buffer, 1, &numbers(&cpu), &numbers(&gpu), paths::COUNTS)
            }
            _ => continue,
        };
        table.add(pass.name, [difference]);
    }
}

/// Compares the sums of a gather. Counts may differ only at points with a photon at the bound of acceptance.
fn sums(runners: &mut RunnerPair, params: &FrameParams) -> Vec<Difference> {
    let (cpu, gpu) = runners.records::<u32>("accumulator");
    let read = |words: &[u32]| {
        let sums = (0..params.pixel_count()).map(|pixel| GatheredSum::read(words, pixel, params.quantum));
        sums.unzip::<Vec3, u32, Vec<_>, Vec<_>>()
    };
    let ((cpu_sums, cpu_counts), (gpu_sums, gpu_counts)) = (read(&cpu), read(&gpu));
    let bound = Tolerance::EXACT.except(1.0e-3, "pairs within 1e-5 of the disc's bound");
    let counts = words("photons", 1, &cpu_counts, &gpu_counts, bound);
    let unexplained = on_the_bound(runners, &counts.indices);
    let total = |counts: &[u32]| counts.iter().sum::<u32>();
    assert!(total(&cpu_counts) > 5000, "the frame has a caustic: {}", total(&cpu_counts));
    let scale = cpu_sums.iter().map(|sum| sum.max_element()).fold(0.0, f32::max);
    let near = Tolerance::relative(1.0e-4, 1.0e-3 * scale, "the parity rule, of sums of f times flux");
    let (cpu_sums, gpu_sums) = (bytemuck::cast_slice(&cpu_sums), bytemuck::cast_slice(&gpu_sums));
    vec![
        floats("sum", 3, cpu_sums, gpu_sums, near.except(1.0e-3, "pairs within 1e-5 of the disc's bound")),
        counts,
        words("counts unexplained", 1, &vec![0; unexplained], &[], Tolerance::EXACT),
    ]
}

/// Number of these pixels without a photon within 1e-5 of the bound of acceptance.
fn on_the_bound(runners: &mut RunnerPair, pixels: &[usize]) -> usize {
    let (points, _) = runners.records::<PointGeometry>("point_geometry");
    let (photons, _) = runners.records::<PhotonGeometry>("photon_geometry");
    let near = |a: f32, b: f32| (a - b).abs() <= 1.0e-5 * b;
    let decides = |point: &PointGeometry, photon: &PhotonGeometry| {
        let along = photon.position - point.position;
        let normals = point.normal + photon.normal;
        let limit = DISC_THICKNESS * point.radius * normals.length();
        near(along.length(), point.radius)
            || near(point.normal.dot(photon.normal), MIN_NORMAL_COS)
            || (near(along.dot(normals).abs(), limit) && along.length() < 1.01 * point.radius)
    };
    let has = |&&pixel: &&usize| !photons.iter().any(|photon| decides(&points[pixel], photon));
    pixels.iter().filter(has).count()
}

/// Compares gathers by ray queries with one in software over the same photons on the same device, and with the CPU's.
fn by_ray_queries(runners: &mut RunnerPair, table: &mut Table) {
    let params = runners.params;
    let (cpu, _) = runners.records::<u32>("accumulator");
    let mut run = |variant| {
        let steps = over_photons(variant, &params);
        runners.copy_to_gpu(&steps);
        runners.gpu.run(&params, &steps).expect("the GPU runs the steps and the validation layer is silent");
        parity::records::<u32>(&mut *runners.gpu, "accumulator")
    };
    let software = run(&PHOTONS_GRID);
    let total = |words: &[u32]| {
        let sums = (0..params.pixel_count()).map(|pixel| GatheredSum::read(words, pixel, params.quantum));
        sums.fold([0.0f32; 4], |t, (sum, n)| [t[0] + sum.x, t[1] + sum.y, t[2] + sum.z, t[3] + n as f32])
    };
    for variant in variant::ALL.iter().filter(|variant| variant.hardware) {
        let found = run(variant);
        let title = format!("{} = {}", variant.gather.name, PHOTONS_GRID.name);
        table.add(&title, [words("accumulator", WORDS as usize, &software, &found, Tolerance::EXACT)]);
        table.add(variant.gather.name, [floats("totals", 1, &total(&cpu), &total(&found), paths::COUNTS)]);
    }
}
