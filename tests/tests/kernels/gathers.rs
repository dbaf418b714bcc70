//! Every gather matches brute force bit for bit over any points and photons (O11 of
//! `tests/tests/light/known_answers.rs`).

use bytemuck::{cast_slice, pod_collect_to_vec};
use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::session::{self, RunnerChoice, Session};
use caustics_kernels::declare::Step;
use caustics_kernels::gather::accumulator::{WORDS, rounding_offset};
use caustics_kernels::gather::contribution::{contribution, takes};
use caustics_kernels::gather::points_rt::bound;
use caustics_kernels::gather::tables::{Build, Tables};
use caustics_kernels::gather::variant::{self, BRUTE, Variant};
use caustics_kernels::gather::{Gather, Index, Near, Visit};
use caustics_kernels::interface::choice::Caustics;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::point::{PhotonGeometry, PhotonLight, PointGeometry, PointShading};
use caustics_kernels::math::quanta::Quanta;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::math::warp::uniform_sphere;
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::method::frame as gather;
use caustics_kernels::method::frame::frame_buffers;
use caustics_kernels::pass::collect::pixel_order;
use caustics_tests::direct::{self, Photons, render};
use caustics_tests::gpu::gpu;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};
use proptest::prelude::*;

/// Points and photons for a gather.
#[derive(Debug)]
struct Case {
    points: Vec<PointGeometry>,
    shadings: Vec<PointShading>,
    photons: Photons,
}

/// A scene for its table of materials: Lambert, rough metal, coat.
fn materials_scene() -> Scene {
    let mut b = Builder::default();
    let ids = [lambert(0.7), metal(0.9, 0.5), coated(0.5, 0.4)].map(|material| b.material(material));
    for (at, id) in ids.into_iter().enumerate() {
        b.panel(id, DVec3::new(0.0, at as f64, 0.0), DVec3::Z, DVec3::X);
    }
    b.light(DVec3::Y, 1.0);
    b.camera(DVec3::new(0.0, 5.0, 0.0), DVec3::ZERO, 0.5);
    b.build()
}

fn params(scene: &Scene, pixels: u32, photons: u32) -> FrameParams {
    let config =
        RenderConfig { width: pixels, height: 1, light_paths: Paths::Count(1024), ..RenderConfig::default() };
    let base = config.params(scene, &scene.cameras[0], 0);
    FrameParams {
        light_path_count: 1024,
        light_path_batch: 1024,
        photon_capacity: photons.max(1),
        // A small table, so that cells share slots.
        cell_mask: 63,
        quantum: 2.0_f32.powi(-30),
        ..base
    }
}

/// Random points with radii over six orders of magnitude, a share of them missing. Photons are near and far,
/// duplicated, and a radius away to the bit.
fn random_case(seed: u32, point_count: u32, photon_count: u32, missing: f32, spread: f32) -> Case {
    let mut rng = Rng::new(Stream::Camera, seed, 0, 0);
    let (mut points, mut shadings) = (Vec::new(), Vec::new());
    for _ in 0..point_count {
        let (a, b, c) = (rng.next4(), rng.next4(), rng.next4());
        let mut normal = uniform_sphere(b.x, b.y);
        if b.z < 0.3 {
            normal = Vec3::AXES[(b.w * 2.999) as usize];
        }
        let there = c.x >= missing;
        points.push(PointGeometry {
            position: (Vec3::new(a.x, a.y, a.z) - 0.5) * spread,
            radius: if there { 10.0_f32.powf(6.0 * a.w - 4.0) } else { 0.0 },
            normal,
            depth: if there { 1 + (c.y * 3.0) as u32 } else { 0 },
        });
        let view = uniform_sphere(c.z, c.w);
        shadings.push(PointShading {
            to_viewer: view * view.dot(normal).signum(),
            material: (c.y * 2.999) as u32,
            shading_normal: normal,
            throughput: Vec3::ONE,
            ..PointShading::default()
        });
    }
    let mut photons = Photons::default();
    while photons.len() < photon_count {
        let (a, b, c) = (rng.next4(), rng.next4(), rng.next4());
        let near = points[(a.x * point_count as f32) as usize % points.len()];
        let tangent = near.normal.any_orthonormal_vector();
        let turn = tangent * (2.0 * a.y - 1.0) + near.normal.cross(tangent) * (2.0 * a.z - 1.0);
        let position = match (b.x * 4.0) as u32 {
            // Inside and around the disc.
            0 => near.position + (turn + near.normal * (0.3 * b.y - 0.15)) * near.radius,
            // At its bound, to the precision of f32.
            1 => near.position + turn.normalize() * near.radius,
            2 => near.position + Vec3::AXES[(b.y * 2.999) as usize] * near.radius,
            _ => (Vec3::new(b.y, b.z, b.w) - 0.5) * spread,
        };
        let normal = (near.normal + uniform_sphere(c.x, c.y) * 0.3).normalize();
        let to_light = uniform_sphere(c.z, c.w);
        let geometry = PhotonGeometry { position, scatterings: 1 + (a.w * 4.0) as u32, normal, instance: 0 };
        let light = PhotonLight {
            to_light: to_light * to_light.dot(normal).signum(),
            flux: Vec3::new(b.y, b.z, b.w) * 10.0_f32.powf(4.0 * a.w - 3.0),
            ..PhotonLight::default()
        };
        for _ in 0..1 + (a.w * 40.0) as u32 % 3 {
            photons.push(geometry, light);
        }
    }
    Case { points, shadings, photons }
}

/// Accumulator words of a variant over the photons of each case, by one runner.
fn by_runner(
    choice: &RunnerChoice,
    variant: &'static Variant,
    scene: &Scene,
    cases: &[Case],
) -> Vec<Vec<u32>> {
    let points = cases.iter().map(|case| case.points.len()).max().unwrap_or(0) as u32;
    let photons = cases.iter().map(|case| case.photons.len()).max().unwrap_or(0);
    let params = params(scene, points, photons);
    // The given photons replace the light paths.
    let mut steps = vec![Step::Clear { buffer: "accumulator" }];
    steps.extend(gather::prepare(variant, &params));
    steps.extend(gather::exchange(variant, &params));
    let buffers = frame_buffers(&BASIC, variant.into(), &params);
    let mut runner = session::open(choice, scene, Features::ALL, &buffers).unwrap();
    let order = pixel_order(params.width, params.height);
    runner.write("pixel_order", cast_slice(&order)).unwrap();
    let mut words = |case: &Case| {
        assert_eq!(case.points.len(), points as usize);
        runner.write("point_geometry", cast_slice(&case.points)).unwrap();
        runner.write("point_shading", cast_slice(&case.shadings)).unwrap();
        runner.write("photon_geometry", cast_slice(&case.photons.geometry)).unwrap();
        runner.write("photon_light", cast_slice(&case.photons.light)).unwrap();
        runner.write("photon_state", cast_slice(&[case.photons.len(), 0, 0, 0])).unwrap();
        runner.run(&params, &steps).unwrap();
        pod_collect_to_vec(&runner.read("accumulator").unwrap())
    };
    cases.iter().map(&mut words).collect()
}

/// Words by brute force, on this thread.
fn by_brute(scene: &Scene, case: &Case) -> Vec<u32> {
    let params = params(scene, case.points.len() as u32, case.photons.len());
    let (points, shadings) = (&case.points, &case.shadings);
    direct::gather(&BRUTE, points, shadings, &case.photons, &scene.materials, Features::ALL, &params)
}

/// Asserts that a variant's words are the expected ones.
fn assert_equal(variant: &Variant, words: &[u32], expected: &[u32], case: &Case) {
    for (pixel, (got, want)) in words.chunks(WORDS as usize).zip(expected.chunks(WORDS as usize)).enumerate()
    {
        assert_eq!(got, want, "{}: point {pixel} {:?}", variant.name, case.points[pixel]);
    }
}

/// Runs every variant in software on the CPU, and returns the words of all.
fn all_agree(scene: &Scene, case: &Case) -> Vec<u32> {
    let expected = by_brute(scene, case);
    for variant in variant::ALL.iter().filter(|variant| !variant.hardware) {
        let cpu = RunnerChoice::Cpu { threads: 2 };
        let words = by_runner(&cpu, variant, scene, std::slice::from_ref(case)).remove(0);
        assert_equal(variant, &words, &expected, case);
    }
    expected
}

/// Compares every variant on the GPU with brute force there: a device rounds in its own way, but in one way.
#[test]
fn every_gather_on_the_gpu_matches_brute_force_to_the_bit() {
    let Some(gpu) = gpu() else { return };
    let scene = materials_scene();
    let case = |(seed, spread)| random_case(seed, 300, 500, if seed == 4 { 0.9 } else { 0.1 }, spread);
    let cases = [(1, 0.01), (2, 0.3), (3, 1.0), (4, 30.0), (5, 1000.0), (6, 1.0e4)].map(case);
    for &hardware in gpu.tracers() {
        let choice = gpu.choice(hardware);
        let expected = by_runner(&choice, &BRUTE, &scene, &cases);
        let taken: usize = expected.iter().map(|words| takers(words)).sum();
        println!("{taken} points take photons");
        assert!(taken > 500, "the test has nothing to check");
        for variant in variant::ALL.iter().filter(|variant| hardware || !variant.hardware) {
            let found = by_runner(&choice, variant, &scene, &cases);
            println!("{} (hardware {hardware})", variant.name);
            for ((case, words), expected) in cases.iter().zip(&found).zip(&expected) {
                assert_equal(variant, words, expected, case);
            }
        }
    }
}

/// Example variant outside of the kernels: `CONTRIBUTING.md` quotes it, and `.ci/new-variant` copies it into the
/// kernels.
#[path = "../../example_variants/stripes.rs"]
mod stripes;

/// Its passes; the list of the kernels generates them for variants of its own.
mod stripes_passes {
    caustics_kernels::index_pass!(stripes, super::stripes::Stripes);
    caustics_kernels::gather_pass!(stripes, super::stripes::Stripes);
}

#[test]
fn example_gather_matches_brute_force_on_the_cpu() {
    static STRIPES: Variant = Variant {
        index: &stripes_passes::INDEX,
        gather: &stripes_passes::GATHER,
        ..stripes::Stripes::VARIANT
    };
    let scene = materials_scene();
    for (seed, spread) in [(1, 0.3), (2, 10.0), (3, 1000.0)] {
        let case = random_case(seed, 300, 500, 0.1, spread);
        let cpu = RunnerChoice::Cpu { threads: 2 };
        let words = by_runner(&cpu, &STRIPES, &scene, std::slice::from_ref(&case)).remove(0);
        assert_equal(&STRIPES, &words, &by_brute(&scene, &case), &case);
    }
    // Compare a whole frame too.
    let scene = committed("mirror-room");
    let config =
        RenderConfig { width: 80, height: 45, light_paths: Paths::Count(30_000), ..RenderConfig::default() };
    let choice = RunnerChoice::Cpu { threads: 0 };
    let image = |variant: &'static Variant| {
        let (camera, features) = (&scene.cameras[0], scene.features(config.specular_roughness));
        let mut session = Session::new(
            &choice,
            &scene,
            camera,
            &RenderConfig { gather: Some(variant), ..config.clone() },
            features,
        )
        .unwrap();
        let times = session.frame(0).unwrap();
        assert!(times.iter().any(|time| time.pass == variant.gather.name));
        session.image().unwrap()
    };
    assert!(image(&STRIPES) == image(&BRUTE));
}

/// A gather that skips one photon in a thousand.
mod careless {
    use super::*;

    pub struct Careless;
    impl Index for Careless {
        const VARIANT: Variant = Variant { name: "careless", ..Variant::NEW };
        fn build(_: u32, _: u32, _: &mut Build<'_>) {}
    }
    impl Gather for Careless {
        fn for_each_near<V: Visit>(tables: &mut Tables<'_>, _: Near, visit: &mut V) {
            (0..tables.photon_count).filter(|id| id % 1000 != 500).for_each(|id| visit.visit(tables, id));
        }
    }
    caustics_kernels::gather_pass!(careless, Careless);
}

/// Its sums differ from those of brute force.
#[test]
fn detects_a_gather_that_misses_one_photon() {
    static CARELESS: Variant = Variant { gather: &careless::GATHER, ..careless::Careless::VARIANT };
    let scene = materials_scene();
    let mut case = random_case(1, 300, 600, 0.1, 1.0);
    // A photon that the point takes.
    case.photons.geometry[500] = PhotonGeometry {
        position: case.points[0].position,
        normal: case.points[0].normal,
        scatterings: 1,
        instance: 0,
    };
    case.points[0].depth = 1;
    case.points[0].radius = case.points[0].radius.max(0.1);
    let words = by_runner(&RunnerChoice::Cpu { threads: 1 }, &CARELESS, &scene, std::slice::from_ref(&case));
    assert_ne!(words[0], by_brute(&scene, &case));
}

fn takers(words: &[u32]) -> usize {
    words.chunks(WORDS as usize).filter(|point| point[WORDS as usize - 1] > 0).count()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_gather_matches_brute_force_to_the_bit(
        seed in any::<u32>(), points in 1_u32..400, photons in 1_u32..600, spread in -2.0_f32..3.0,
    ) {
        let case = random_case(seed, points, photons, 0.1, 10.0_f32.powf(spread));
        all_agree(&materials_scene(), &case);
    }

    #[test]
    fn every_gather_matches_brute_force_with_nine_points_in_ten_missing(seed in any::<u32>()) {
        let case = random_case(seed, 300, 300, 0.9, 1.0);
        all_agree(&materials_scene(), &case);
    }

    #[test]
    fn point_boxes_contain_every_photon_taken(seed in any::<u32>(), spread in -2.0_f32..3.0) {
        let case = random_case(seed, 200, 400, 0.0, 10.0_f32.powf(spread));
        for point in &case.points {
            let b = bound(point);
            for photon in case.photons.geometry.iter().filter(|photon| takes(point, photon, 9)) {
                let inside = photon.position.cmpge(b.0).all() && photon.position.cmple(b.1).all();
                prop_assert!(inside, "{:?} {:?} {:?}", point, b, photon);
            }
        }
    }
}

#[test]
fn random_cases_have_photons_inside_and_at_the_bound_of_discs() {
    let case = random_case(1, 300, 600, 0.1, 1.0);
    let words = by_brute(&materials_scene(), &case);
    let taken: u32 = words.chunks(WORDS as usize).map(|point| point[WORDS as usize - 1]).sum();
    let at_bound = case.points.iter().flat_map(|p| {
        case.photons.geometry.iter().filter(move |d| (d.position - p.position).length() == p.radius)
    });
    println!(
        "{} of 300 points take {taken} photons, {} at the bound",
        takers(&words),
        at_bound.clone().count()
    );
    assert!(takers(&words) > 100 && taken > 1000 && at_bound.count() > 20);
}

#[test]
fn gathers_agree_without_photons_without_points_and_with_one_photon() {
    let scene = materials_scene();
    let mut case = random_case(2, 100, 50, 0.3, 1.0);
    let one = (case.photons.geometry[0], case.photons.light[0]);
    case.photons = Photons::default();
    assert_eq!(takers(&all_agree(&scene, &case)), 0);
    case.photons.push(one.0, one.1);
    all_agree(&scene, &case);
    case.points.iter_mut().for_each(|point| *point = PointGeometry::default());
    assert_eq!(takers(&all_agree(&scene, &case)), 0);
}

/// The sum of 1e6 equal photons at one position is the integer product, on any number of threads.
#[test]
fn million_photons_at_one_position_sum_exactly() {
    let scene = materials_scene();
    let point = PointGeometry { position: Vec3::ONE, radius: 0.01, normal: Vec3::Y, depth: 1 };
    let shading = PointShading {
        to_viewer: Vec3::Y,
        shading_normal: Vec3::Y,
        throughput: Vec3::ONE,
        ..PointShading::default()
    };
    let mut photons = Photons::default();
    let geometry = PhotonGeometry { position: Vec3::ONE, scatterings: 1, normal: Vec3::Y, instance: 0 };
    let light = PhotonLight {
        to_light: Vec3::new(0.6, 0.8, 0.0),
        flux: Vec3::new(3.0, 0.1, 1e-7),
        ..PhotonLight::default()
    };
    (0..1_000_000).for_each(|_| photons.push(geometry, light));
    let case = Case { points: vec![point; 3], shadings: vec![shading; 3], photons };
    let words = all_agree(&scene, &case);
    let params = params(&scene, 3, 1_000_000);
    let value = contribution(&shading, scene.materials[0], &light, params.specular_roughness, Features::ALL);
    for channel in 0..3 {
        let offset = rounding_offset(geometry.position, point.position);
        let one = Quanta::rounded(value[channel], params.inverse_quantum(), offset);
        let exact = 1_000_000 * (u64::from(one.high) << 32 | u64::from(one.low));
        let got = u64::from(words[2 * channel + 1]) << 32 | u64::from(words[2 * channel]);
        assert!(exact > 0);
        assert_eq!(got, exact, "channel {channel}");
    }
    assert_eq!(words[6], 1_000_000);
}

/// The disc test rounds: it takes a photon slightly beyond the radius, whose cell may be the next one.
#[test]
fn every_gather_takes_a_photon_that_rounding_puts_into_the_disc() {
    let scene = materials_scene();
    let point = PointGeometry { position: Vec3::new(0.3, 0.5, 0.5), radius: 0.3, normal: Vec3::Z, depth: 1 };
    let shading = PointShading {
        to_viewer: Vec3::Z,
        shading_normal: Vec3::Z,
        throughput: Vec3::ONE,
        ..PointShading::default()
    };
    let geometry =
        PhotonGeometry { position: Vec3::new(-1e-9, 0.5, 0.5), scatterings: 1, normal: Vec3::Z, instance: 0 };
    assert!(takes(&point, &geometry, 5));
    let b = bound(&point);
    assert!(geometry.position.cmpge(b.0).all() && geometry.position.cmple(b.1).all());
    let mut photons = Photons::default();
    // Enough photons that the grid is searched by cells.
    let light = PhotonLight { to_light: Vec3::Z, flux: Vec3::ONE, ..PhotonLight::default() };
    (0..100).for_each(|_| photons.push(geometry, light));
    all_agree(&scene, &Case { points: vec![point], shadings: vec![shading], photons });
}

#[test]
fn gathers_agree_to_the_bit_on_committed_scenes() {
    for name in ["mirror-room", "ring"] {
        let scene = committed(name);
        // Gather more photons than those of casters that are met first.
        let (light_paths, caustics) = (30_000, Caustics::Any);
        let config = RenderConfig {
            width: 80,
            height: 45,
            light_paths: Paths::Count(light_paths),
            caustics,
            ..RenderConfig::default()
        };
        let mut first: Option<caustics::rendered_image::RenderedImage> = None;
        for variant in variant::ALL {
            if variant.hardware {
                println!("{} needs ray queries: not on the CPU", variant.name);
                continue;
            }
            let (image, _) = render(&scene, &config, variant.name, None, 0, 1).remove(0);
            let taken: f32 = image.photons.iter().sum();
            println!("{name}, {}: {taken} photons taken", variant.name);
            assert!(taken > 300.0, "the test has nothing to check");
            let first = first.get_or_insert_with(|| image.clone());
            assert!(*first == image, "{name}: {} differs", variant.name);
        }
    }
}
