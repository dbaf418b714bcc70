//! Passes that trace whole paths. Few may diverge, and only where the CPU's own perturbed path diverges too.

use std::collections::BTreeSet;

use caustics::scene::Scene;
use caustics_kernels::interface::counters::PhotonState;
use caustics_kernels::interface::point::{PhotonGeometry, PhotonLight, PointGeometry, PointShading};
use caustics_tests::collected::Collected;
use caustics_tests::compare::{Difference, Tolerance, floats, records, words};
use caustics_tests::fields::Field;
use caustics_tests::matching::{Photon, pair};
use caustics_tests::parity::RunnerPair;
use caustics_tests::table::Table;
use caustics_tests::tremble::LightPathContext;

use super::passes::NEAR;

/// Tolerance of counts over whole paths.
pub const COUNTS: Tolerance =
    Tolerance::relative(2.0e-3, 0.0, "the parity rule: 0.2 % of the paths may diverge");
/// Tolerance of quantities of whole paths that have a unit, and so no scale of their own.
const RATIOS: Tolerance =
    Tolerance::relative(1.0e-3, 0.0, "curved vertices and grazing cosines amplify ulps along a path");
/// Tolerance of shares.
const SHARES: Tolerance = Tolerance { absolute: RATIOS.relative, relative: 0.0, ..RATIOS };
/// Distance within which photons are the same (m): a tenth of a typical radius of a point.
const REACH: f32 = 1.0e-3;
/// Number of divergences that are printed.
const PRINTED: usize = 12;

/// The tolerance, except for paths that may diverge.
fn but_for_some(scene: &Scene, tolerance: Tolerance) -> Tolerance {
    if scene.textures.textures.is_empty() {
        return tolerance.except(2.0e-3, "the parity rule: 0.2 % of the paths may diverge");
    }
    tolerance.except(1.0e-2, "texels say what is there and how it leans: 1 % of the paths may diverge")
}

/// Compares camera paths, pixel by pixel.
pub fn collect(runners: &mut RunnerPair, paths: LightPathContext<'_>, table: &mut Table) {
    let (cpu_radiance, gpu_radiance) = runners.records::<f32>("path_radiance");
    let (cpu_geometry, gpu_geometry) = runners.records::<PointGeometry>("point_geometry");
    let (cpu_shading, gpu_shading) = runners.records::<PointShading>("point_shading");
    let but_for_some = |tolerance| but_for_some(paths.scene, tolerance);
    let (words_tolerance, near) = (but_for_some(Tolerance::EXACT), but_for_some(NEAR));
    let field_tolerance = |field: &Field| but_for_some(path_field(field.name));
    let mut all = vec![floats("path_radiance", 3, &cpu_radiance, &gpu_radiance, near)];
    all.extend(records(&cpu_geometry, &gpu_geometry, words_tolerance, field_tolerance));
    all.extend(records(&cpu_shading, &gpu_shading, words_tolerance, field_tolerance));

    let pixels: BTreeSet<usize> =
        all.iter().flat_map(|difference| difference.indices.iter().copied()).collect();
    let mut unexplained = 0;
    for (rank, &pixel) in pixels.iter().enumerate() {
        let fields = all.iter().filter(|difference| difference.indices.contains(&pixel));
        let fields: Vec<_> = fields.map(|difference| difference.name.as_str()).collect();
        let why = paths.explain_camera(pixel as u32, diverges);
        unexplained += usize::from(why.is_none());
        if rank < PRINTED || why.is_none() {
            eprintln!("collect diverges at pixel {pixel} in {}: {why:?}", fields.join(", "));
        }
    }
    table.add("collect", all);
    table.add("collect", summary(paths.scene, "pixels", cpu_geometry.len(), pixels.len(), unexplained));
}

fn path_field(name: &str) -> Tolerance {
    if ["radius", "flux", "distance"].contains(&name) {
        RATIOS
    } else if name == "astigmatism" {
        SHARES
    } else {
        NEAR
    }
}

/// Whether two camera paths differ by more than the comparison allows.
fn diverges(a: &Collected, b: &Collected) -> bool {
    let radiance = floats("", 3, &a.light.radiance.to_array(), &b.light.radiance.to_array(), NEAR);
    let geometry =
        records(&[a.point.geometry], &[b.point.geometry], Tolerance::EXACT, |field| path_field(field.name));
    let shading =
        records(&[a.point.shading], &[b.point.shading], Tolerance::EXACT, |field| path_field(field.name));
    geometry.iter().chain(&shading).chain([&radiance]).any(|difference| difference.exceeding > 0)
}

/// Compares light paths, photon by photon.
pub fn shoot(runners: &mut RunnerPair, paths: LightPathContext<'_>, name: &str, table: &mut Table) {
    let (cpu_state, gpu_state) = runners.records::<u32>("photon_state");
    let (cpu_geometry, gpu_geometry) = runners.records::<PhotonGeometry>("photon_geometry");
    let (cpu_light, gpu_light) = runners.records::<PhotonLight>("photon_light");
    let stored = |state: &[u32]| state[PhotonState::Stored as usize] as usize;
    let zip = |geometry: Vec<PhotonGeometry>, light: Vec<PhotonLight>, count| -> Vec<Photon> {
        geometry.into_iter().zip(light).take(count).collect()
    };
    let cpu = zip(cpu_geometry, cpu_light, stored(&cpu_state));
    let gpu = zip(gpu_geometry, gpu_light, stored(&gpu_state));

    // Trace the paths of the CPU's photons, which its runner stores in any order.
    let known = paths.starts_are_known();
    let traced = if known { paths.photons() } else { (0..).zip(cpu.iter().copied()).collect() };
    let by_path: Vec<_> = traced.iter().map(|(_, photon)| *photon).collect();
    assert!(sorted(&by_path) == sorted(&cpu), "the CPU runner stores other photons");

    // A path diverges if it loses a photon, or if a photon's position, direction or flux differs too much.
    let matching = pair(&by_path, &gpu, REACH);
    let partners: Vec<_> = matching.pairs.iter().map(|&(left, right)| (by_path[left], gpu[right])).collect();
    let fields = compare(&partners, |tolerance| but_for_some(paths.scene, tolerance));
    let exceeding: BTreeSet<usize> = fields.iter().flat_map(|field| field.indices.iter().copied()).collect();
    let lost = matching.left.iter().chain(exceeding.iter().map(|&index| &matching.pairs[index].0));
    let diverging: BTreeSet<u32> = lost.map(|&index| traced[index].0).collect();
    let mut unexplained = 0;
    for (rank, &path) in diverging.iter().enumerate() {
        let trembles = || paths.explain_light(path, diverges_with_light);
        let why = if known { trembles() } else { Some("its emission is not known here".into()) };
        unexplained += usize::from(why.is_none());
        if rank < PRINTED || why.is_none() {
            eprintln!("{name} diverges on path {path}: {why:?}");
        }
    }
    table.add(name, fields);
    let lost = matching.left.len().max(matching.right.len()) + exceeding.len();
    table.add(name, summary(paths.scene, "photons", cpu.len(), lost, unexplained));
}

/// Compares partners field by field; `allow` adapts each field's tolerance.
fn compare(partners: &[(Photon, Photon)], allow: impl Fn(Tolerance) -> Tolerance) -> Vec<Difference> {
    let (left, right): (Vec<_>, Vec<_>) = partners.iter().copied().unzip();
    let split = |photons: Vec<Photon>| photons.into_iter().unzip::<_, _, Vec<_>, Vec<_>>();
    let ((geometry, light), (other_geometry, other_light)) = (split(left), split(right));
    let tolerance = |field: &Field| allow(path_field(field.name));
    let mut all = records(&geometry, &other_geometry, Tolerance::EXACT, tolerance);
    all.extend(records(&light, &other_light, Tolerance::EXACT, tolerance));
    all
}

/// Whether two versions of a light path differ by more than the comparison allows.
fn diverges_with_light(a: &[Photon], b: &[Photon]) -> bool {
    let matching = pair(a, b, REACH);
    let partners: Vec<_> = matching.pairs.iter().map(|&(left, right)| (a[left], b[right])).collect();
    let lost = matching.left.len() + matching.right.len();
    lost > 0 || compare(&partners, |tolerance| tolerance).iter().any(|difference| difference.exceeding > 0)
}

/// Photons as bytes, sorted.
fn sorted(photons: &[Photon]) -> Vec<Vec<u8>> {
    let bytes =
        |(geometry, light): &Photon| [bytemuck::bytes_of(geometry), bytemuck::bytes_of(light)].concat();
    let mut all: Vec<_> = photons.iter().map(bytes).collect();
    all.sort();
    all
}

/// Number of paths that diverge out of `count`, and number of those that the CPU's perturbation does not explain.
fn summary(scene: &Scene, what: &str, count: usize, diverging: usize, unexplained: usize) -> [Difference; 2] {
    let marks = |marked: usize| (0..count).map(|i| u32::from(i < marked)).collect::<Vec<_>>();
    let tolerance = but_for_some(scene, Tolerance::EXACT);
    [
        words(&format!("diverging {what}"), 1, &marks(0), &marks(diverging), tolerance),
        words("unexplained", 1, &marks(0), &marks(unexplained), Tolerance::EXACT),
    ]
}
