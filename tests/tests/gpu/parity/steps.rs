//! Single steps: random numbers and warps, hits, scattering, emission.

use caustics::scene::Scene;
use caustics_kernels::interface::ray::{Hit, Ray};
use caustics_kernels::interface::step::{EmitStep, SampleStep, ScatterIn, ScatterOut};
use caustics_kernels::pass::step::{STEP_EMIT, STEP_HIT, STEP_SAMPLE, STEP_SCATTER};
use caustics_tests::compare::{Tolerance, floats, records, words};
use caustics_tests::parity::RunnerPair;
use caustics_tests::rays;
use caustics_tests::table::Table;

const WARP: Tolerance = Tolerance::relative(
    2.0e-6,
    1.0,
    "unit vectors from a dozen roundings; GPU division and root are off by 2.5 and 3 ulp",
);
const FACET: Tolerance =
    Tolerance::relative(1.0e-4, 1.0, "z is the root of 1 - x^2 - y^2: at the rim an ulp grows to 2e-5");
const RATIO: Tolerance = Tolerance::relative(1.0e-4, 0.0, "the parity rule, of quantities with a unit");

const SHONE_BY_TEXELS: Tolerance = Tolerance::relative(
    1.0e-3,
    0.0,
    "beside a bright texel the ulps of a point are more of what a dark one shines",
);

/// Compares uniform numbers bit for bit, and warps of them.
pub fn sample(runners: &mut RunnerPair, table: &mut Table) {
    runners.step(&STEP_SAMPLE, 100_000);
    let (cpu, gpu) = runners.head::<SampleStep>("samples", 100_000);
    table.add(
        "step.sample",
        records(&cpu, &gpu, Tolerance::EXACT, |field| match field.name {
            "facet" => FACET,
            _ => WARP,
        }),
    );
}

/// Compares closest hits of rays through the air and from surfaces.
pub fn hit(runners: &mut RunnerPair, scene: &Scene, table: &mut Table) {
    let through = rays::through(scene, 100_000);
    let hits = compare_hits(runners, scene, "step.hit", &through, table);
    let from = rays::from_surfaces(scene, &through, &hits);
    assert!(from.len() > 90_000, "the room is closed: {}", from.len());
    compare_hits(runners, scene, "step.hit (surfaces)", &from, table);
}

fn compare_hits(
    runners: &mut RunnerPair,
    scene: &Scene,
    name: &str,
    rays: &[Ray],
    table: &mut Table,
) -> Vec<Hit> {
    runners.write("rays", rays);
    runners.step(&STEP_HIT, rays.len());
    let (cpu, gpu) = runners.head::<Hit>("hits", rays.len());
    let ids = |hits: &[Hit]| hits.iter().map(|hit| hit.triangle).collect::<Vec<_>>();
    let edges = Tolerance::EXACT.except(0.002, "a ray on a shared edge may take either triangle");
    let differing = words("triangle", 1, &ids(&cpu), &ids(&gpu), edges);

    // Both triangles of a differing ray must lie at one distance.
    let pick = |hits: &[Hit]| differing.indices.iter().map(|&i| hits[i].distance).collect::<Vec<_>>();
    let tie = Tolerance::relative(1.0e-4, 0.0, "triangles of one edge are met at one distance");
    let ties = floats("distance, other triangle", 1, &pick(&cpu), &pick(&gpu), tie);
    for &i in ties.indices.iter().take(5) {
        let index = differing.indices[i];
        eprintln!("{name} {index}: {:?}\n  {:?}\n  {:?}", rays[index], cpu[index], gpu[index]);
    }

    let same = |hits: &[Hit]| {
        let kept = (0..hits.len()).filter(|&i| cpu[i].triangle == gpu[i].triangle);
        kept.map(|i| hits[i]).collect::<Vec<_>>()
    };
    // A distance is a quotient of differences of coordinates, so its error scales with the room.
    let size = scene.triangles.iter().fold(0.0f32, |largest, t| largest.max(t.a.abs().max_element()));
    let near = Tolerance::relative(1.0e-4, 0.05 * size, "distances cancel near the origin of a ray");
    let slivers = near.except(1.0e-3, "barycentrics of slivers and of grazing rays amplify ulps");
    let hits = records(&same(&cpu), &same(&gpu), Tolerance::EXACT, |field| match field.name {
        "distance" => near,
        _ => Tolerance { absolute: 1.0e-4, ..slivers },
    });
    table.add(name, [differing, ties]);
    table.add(name, hits);
    cpu
}

/// Compares scattering at the hits of random rays, from both sides.
pub fn scatter(runners: &mut RunnerPair, scene: &Scene, table: &mut Table) {
    let through = rays::through(scene, 100_000);
    runners.write("rays", &through);
    runners.step_on_cpu(&STEP_HIT, through.len());
    let (hits, _) = runners.head::<Hit>("hits", through.len());
    let mut events = rays::events(scene, &through, &hits);
    let reversed = rays::from_surfaces(scene, &through, &hits);
    runners.write("rays", &reversed);
    runners.step_on_cpu(&STEP_HIT, reversed.len());
    let (hits, _) = runners.head::<Hit>("hits", reversed.len());
    events.extend(rays::events(scene, &reversed, &hits));
    compare_events(runners, &events, table);
}

fn compare_events(runners: &mut RunnerPair, events: &[ScatterIn], table: &mut Table) {
    runners.write("scatter_in", events);
    runners.step(&STEP_SCATTER, events.len());
    let (cpu, gpu) = runners.head::<ScatterOut>("scatter_out", events.len());
    let choices = Tolerance::EXACT.except(1.0e-4, "a random number within ulps of a lobe's probability");
    let near = Tolerance::relative(1.0e-4, 1.0, "the parity rule").except(1.0e-4, choices.reason);
    let peak = Tolerance::relative(1.0e-4, 1.0, "the parity rule: single steps to 1e-4");
    let differences = records(&cpu, &gpu, choices, |field| match field.name {
        "pdf" => Tolerance { absolute: 0.0, ..peak }.except(near.share, peak.reason),
        _ => near,
    });
    for difference in differences.iter().filter(|difference| !difference.passes()) {
        for &i in difference.indices.iter().take(3) {
            eprintln!("{} {i}: {:?}\n  {:?}\n  {:?}", difference.name, events[i], cpu[i], gpu[i]);
        }
    }
    table.add("step.scatter", differences);
}

/// Compares starts of light paths and light samples.
pub fn emit(runners: &mut RunnerPair, scene: &Scene, table: &mut Table) {
    runners.step(&STEP_EMIT, 100_000);
    let (cpu, gpu) = runners.head::<EmitStep>("emit_steps", 100_000);
    let unit = Tolerance::relative(1.0e-4, 1.0, "the parity rule");
    let light = if scene.textures.textures.is_empty() { RATIO } else { SHONE_BY_TEXELS };
    table.add(
        "step.emit",
        records(&cpu, &gpu, Tolerance::EXACT, |field| match field.name {
            "flux" | "radiance_over_pdf" => light,
            "pdf" => RATIO,
            _ => unit,
        }),
    );
}
