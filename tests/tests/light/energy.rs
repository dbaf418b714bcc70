//! O10: the energy ledger. Emitted flux is absorbed, escapes, is cut by the length of paths, or is lost where shading
//! normals differ from the faces. Absorption is computed independently of the flux that sampled paths leave over.

use caustics::energy::EnergyLedger;
use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::gather::variant::PHOTONS_GRID;
use caustics_kernels::history::{PAPER, VALIDATED};
use caustics_kernels::interface::choice::Caustics;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::material::{FLAG_THIN, Material};
use caustics_tests::direct::{Beam, World};
use caustics_tests::energy::{ledger, ledgers, share};
use caustics_tests::gpu::gpu;
use caustics_tests::moving::{Moving, kept};
use caustics_tests::quadrature::dielectric_by_quadrature;
use caustics_tests::scenes::*;
use caustics_tests::statistics::Mean;
use glam::{DVec3, Vec3};

/// Light paths per frame.
const PATHS: u32 = 32_768;

/// Light paths that follow every lobe from their first surface on: all energy is in the ledger.
fn config(max_bounces: u32) -> RenderConfig {
    let caustics = Caustics::Any;
    RenderConfig {
        width: 8,
        height: 8,
        light_paths: Paths::Count(PATHS),
        max_bounces,
        caustics,
        ..RenderConfig::default()
    }
}

/// Ledgers of a scene's own lights.
fn scene_ledgers(scene: &Scene, max_bounces: u32, frames: u32) -> Vec<EnergyLedger> {
    let world = World::new(scene, &config(max_bounces));
    ledgers(&world, &world.by_power(), 0..frames)
}

fn room(wall: Material) -> Builder {
    let mut b = Builder::default();
    let wall = b.material(wall);
    b.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    b.camera(DVec3::new(0.0, 0.0, 0.9), DVec3::ZERO, 1.0);
    b
}

/// A closed Lambertian room of albedo a half absorbs 2^-k at bounce k. A light path without a specular event is cut one
/// bounce early, so that a length of m absorbs at m - 1 bounces. Three standard errors from 8 frames.
#[test]
fn closed_room_absorbs_two_to_the_minus_k_at_bounce_k() {
    let mut b = room(lambert(0.5));
    b.light(DVec3::new(0.2, 0.1, -0.3), 1.0);
    let scene = b.build();
    let mut before = vec![0.0; 8];
    for bounces in 1..=6 {
        let all = scene_ledgers(&scene, bounces + 1, 8);
        let flux = f64::from(scene.flux.element_sum());
        assert!(all.iter().all(|energy| (energy.emitted / flux - 1.0).abs() < 1e-5));
        assert!(all.iter().all(|energy| energy.escaped == 0.0 && energy.shading_normals.abs() < 1e-6 * flux));
        let absorbed: Vec<f64> = all.iter().map(|energy| energy.absorbed / energy.emitted).collect();
        let here = Mean::from_samples(
            &absorbed.iter().zip(&before).map(|(now, then)| now - then).collect::<Vec<_>>(),
        );
        let expected = 0.5f64.powi(bounces as i32);
        println!("bounce {bounces}: {:.6} +- {:.6}, expected {expected:.6}", here.value, here.error);
        assert!((here.value - expected).abs() < 3.0 * here.error + 1e-5);
        assert!(here.error < 0.02 * expected);
        before = absorbed;
    }
}

/// Smooth glass, thin walls and a perfect mirror in a white room absorb nothing: all flux is cut in the end. 1e-5 is
/// for rounding of 12 bounces in f32.
#[test]
fn lossless_glass_in_a_white_room_absorbs_nothing() {
    let mut b = room(lambert(1.0));
    let (ball, thin, mirror) = (b.material(glass(1.5)), b.material(pane(1.5)), b.material(metal(1.0, 0.0)));
    b.block(ball, DVec3::new(-0.8, -0.8, -0.3), DVec3::new(-0.1, 0.1, 0.4), false);
    b.sphere(mirror, DVec3::new(0.4, -0.3, -0.3), 0.3, 32, 16);
    b.panel(thin, DVec3::new(0.3, 0.5, 0.2), 0.3 * DVec3::X, DVec3::new(0.0, 0.2, 0.2));
    b.light(DVec3::new(0.2, 0.8, -0.3), 1.0);
    for energy in scene_ledgers(&b.build(), 12, 4) {
        assert!(energy.absorbed.abs() < 1e-5 * energy.emitted && energy.escaped == 0.0, "{energy:?}");
        let kept = (energy.cut + energy.shading_normals) / energy.emitted;
        assert!((kept - 1.0).abs() < 1e-2, "{energy:?}");
    }
}

/// One scattering by rough glass absorbs the loss of single scattering, known by quadrature.
#[test]
fn rough_glass_absorbs_what_single_scattering_loses() {
    for (roughness, thin) in [(0.3, false), (0.6, false), (1.0, false), (0.6, true)] {
        let flags = if thin { FLAG_THIN } else { 0 };
        let material = Material { roughness, flags, ..glass(1.5) };
        let mut b = Builder::default();
        let frosted = b.material(material);
        b.panel(frosted, DVec3::ZERO, 5.0 * DVec3::Z, 5.0 * DVec3::X);
        b.camera(DVec3::Y, DVec3::ZERO, 1.0);
        let scene = b.build();
        let mut world = World::new(&scene, &config(4));
        // The scene has no light of its own to derive the unit from.
        world.params.quantum = 2.0f32.powi(-40);
        let cos = 0.6;
        let beam = Beam {
            centre: Vec3::new(-0.8, 0.6, 0.0),
            direction: Vec3::new(0.8, -cos, 0.0),
            axes: [0.1 * Vec3::Z, 0.1 * Vec3::new(0.6, 0.8, 0.0)],
            round: false,
            irradiance: 1.0,
        };
        let all = ledgers(&world, &beam, 0..64);
        let (absorbed, residual) = (share(&all, |e| e.absorbed), share(&all, |e| e.residual * e.emitted));
        let (r, t) = dielectric_by_quadrature(&material, f64::from(cos), if thin { 1.0 } else { 1.0 / 1.5 });
        println!(
            "roughness {roughness}, thin {thin}: {absorbed:?}, expected {}, residual {residual:?}",
            1.0 - r - t
        );
        assert!((absorbed.value - (1.0 - r - t)).abs() < 3.0 * absorbed.error + 1e-3);
        assert!(residual.value.abs() < 3.0 * residual.error + 1e-5 && residual.error < 1e-3);
    }
}

/// Rooms with an area light, a point light, and two objects of a material: a block and a coarse ball with smooth
/// normals.
fn furnished(wall: Material, thing: Material) -> Scene {
    let mut b = room(wall);
    let (thing, light) = (b.material(thing), b.material(emitter(3.0)));
    b.block(thing, DVec3::new(-0.8, -0.9, -0.6), DVec3::new(0.0, -0.2, 0.2), false);
    b.sphere(thing, DVec3::new(0.45, -0.3, -0.2), 0.4, 16, 8);
    b.panel(light, DVec3::new(0.0, 0.95, 0.0), 0.4 * DVec3::X, 0.4 * DVec3::Z);
    b.light(DVec3::new(-0.5, 0.6, 0.5), 1.0);
    b.build()
}

/// The ledger balances to 2.5 times O10's bound in a short run: in three rooms that have every lobe between them, and
/// with blended surfaces.
#[test]
fn ledger_balances_in_rooms_of_every_lobe() {
    rooms_balance(
        Caustics::Any,
        &["everything at once", "everything smooth", "mixed room", "things that blend"],
        56,
        2.5e-3,
    );
}

/// The ledger also balances where light paths follow the specular lobes of their first surface alone.
#[test]
fn ledger_balances_where_light_paths_follow_specular_lobes_alone() {
    rooms_balance(Caustics::First, &["everything at once", "rough thin glass", "mixed room"], 32, 2.5e-3);
}

/// Tests the rooms of these names, or all. Three standard errors must fit into the bound: after 64 frames, or 32 more
/// at a time, up to `max_frames`.
fn rooms_balance(caustics: Caustics, names: &[&str], max_frames: u32, bound: f64) {
    let tinted = Vec3::new(0.9, 0.6, 0.3);
    let rough = |roughness| Material { roughness, ..glass(1.5) };
    let grey = lambert(0.6);
    let rooms = [
        ("lambert", furnished(grey, lambert(0.3))),
        ("mirror", furnished(grey, metal(0.8, 0.0))),
        ("polished metal", furnished(grey, Material { base_color: tinted, ..metal(0.8, 0.1) })),
        ("rough metal", furnished(grey, Material { base_color: tinted, ..metal(0.8, 0.6) })),
        ("walls of metal", furnished(metal(0.7, 0.5), lambert(0.5))),
        ("smooth coat", furnished(grey, coated(0.5, 0.0))),
        ("rough coat", furnished(coated(0.5, 0.5), Material { ior: 1.8, ..coated(0.9, 0.2) })),
        ("glass", furnished(grey, glass(1.5))),
        ("glossy glass", furnished(grey, rough(0.2))),
        ("rough glass", furnished(grey, Material { base_color: tinted, ..rough(0.6) })),
        ("rough thin glass", furnished(grey, Material { flags: FLAG_THIN, ..rough(0.5) })),
        ("absorbing glass", furnished(grey, Material { absorption: Vec3::new(0.5, 1.0, 4.0), ..rough(0.3) })),
        (
            "everything at once",
            furnished(grey, Material { metallic: 0.3, transmission: 0.5, ..coated(0.6, 0.4) }),
        ),
        (
            "everything smooth",
            furnished(grey, Material { metallic: 0.3, transmission: 0.5, ..coated(0.6, 0.0) }),
        ),
        ("mixed room", mixed_room().build()),
        ("things that blend", blended_room().build()),
    ];
    println!(
        "shares of what is emitted: absorbed, cut, shading normals, left to the camera; residual +- standard error"
    );
    for (name, scene) in rooms.into_iter().filter(|(name, _)| names.is_empty() || names.contains(name)) {
        let world = World::new(&scene, &RenderConfig { caustics, ..config(10) });
        let more = |frames| ledgers(&world, &world.by_power(), frames);
        let residual = |all: &[EnergyLedger]| share(all, |e| e.residual * e.emitted);
        let mut frames = max_frames.min(64);
        let mut all = more(0..frames);
        while frames < max_frames && 3.0 * residual(&all).error > bound {
            all.extend(more(frames..max_frames.min(frames + 32)));
            frames = all.len() as u32;
        }
        let [absorbed, cut, normals] =
            [share(&all, |e| e.absorbed), share(&all, |e| e.cut), share(&all, |e| e.shading_normals)];
        let left = share(&all, |e| e.left_to_camera);
        let residual = residual(&all);
        println!(
            "{name}: {:.4} {:.4} {:+.4} {:.4}; {:+.6} +- {:.6} of {frames} frames",
            absorbed.value, cut.value, normals.value, left.value, residual.value, residual.error
        );
        // A few in a million escape through an edge, where the offset of a ray's start crosses the next wall.
        assert!(share(&all, |e| e.escaped).value < 1e-5, "{name}: the room is closed");
        match caustics {
            Caustics::Any => assert!(absorbed.value > 0.3 && cut.value > 0.0 && left.value == 0.0, "{name}"),
            // Where nothing casts caustics, paths end at their first surface, and nothing is cut.
            Caustics::First => assert!(absorbed.value > 0.05 && left.value > 0.1, "{name}"),
        }
        assert!(3.0 * residual.error < bound, "{name}: too noisy to tell: {residual:?}");
        // 3.5 errors: one false alarm in 140 runs of 15 rooms, but never beyond the bound. 1e-6 is for rounding, where
        // a room of closed albedos has no noise.
        let noise = 3.5 * residual.error + 1e-6;
        assert!(residual.value.abs() < noise.min(bound), "{name}: {residual:?}");
    }
}

/// On a ball of 6 x 3 facets with smooth normals the adjoint correction changes much flux; the ledger accounts for it.
#[test]
fn ledger_accounts_for_flux_lost_at_shading_normals() {
    for (name, ball) in
        [("mirror", metal(1.0, 0.0)), ("lambert", lambert(0.9)), ("rough metal", metal(1.0, 0.5))]
    {
        let mut b = room(lambert(0.3));
        let ball = b.material(ball);
        b.sphere(ball, DVec3::ZERO, 0.8, 6, 3);
        b.light(DVec3::new(0.9, 0.9, 0.2), 1.0);
        let all = scene_ledgers(&b.build(), 8, 32);
        let (normals, residual) =
            (share(&all, |e| e.shading_normals), share(&all, |e| e.residual * e.emitted));
        println!("{name}: {normals:?}, residual {residual:?}");
        assert!(normals.error > 1e-5, "{name}: the test has nothing to check");
        assert!(residual.value.abs() < 3.5 * residual.error && residual.error < 1e-3, "{name}: {residual:?}");
    }
}

/// Coarse meshes with smooth normals absorb as their material does: directions on which normals disagree are flipped
/// and lose no flux. The rest in `shading_normals` is the adjoint correction, whose mean is 0 over even light only.
#[test]
fn ledger_balances_on_coarse_meshes_with_smooth_normals() {
    type Add = fn(&mut Builder, u32);
    let shapes: [(&str, Add); 3] = [
        ("12 segments", |b, thing| b.sphere(thing, DVec3::new(0.0, -0.4, 0.0), 0.45, 12, 6)),
        ("steep waves", |b, thing| b.waves(thing, DVec3::new(0.0, -0.7, 0.0), 0.8, 0.13, 3)),
        ("smooth block", |b, thing| b.smooth_block(thing, DVec3::new(0.0, -0.4, 0.0), 0.35)),
    ];
    let things = [
        ("lambert", lambert(0.7)),
        ("mirror", metal(1.0, 0.0)),
        ("rough metal", metal(1.0, 0.4)),
        ("glass", glass(1.5)),
    ];
    for (shape, add) in shapes {
        for (name, material) in things {
            let mut b = room(lambert(0.5));
            let (thing, light) = (b.material(material), b.material(emitter(3.0)));
            add(&mut b, thing);
            b.panel(light, DVec3::new(0.1, 0.95, 0.0), 0.4 * DVec3::X, 0.4 * DVec3::Z);
            let all = scene_ledgers(&b.build(), 8, 16);
            let (normals, residual) =
                (share(&all, |e| e.shading_normals), share(&all, |e| e.residual * e.emitted));
            println!("{shape}, {name}: shading normals {normals:?}, residual {residual:?}");
            // As in `ledger_balances_in_rooms_of_every_lobe`.
            assert!(residual.error < 2e-3, "{shape}, {name}: too noisy to tell: {residual:?}");
            assert!(residual.value.abs() < 3.5 * residual.error, "{shape}, {name}: {residual:?}");
        }
    }
}

/// A sampler that lacks a lobe of the albedo leaves a residual.
#[test]
fn detects_a_lobe_that_is_never_sampled() {
    let scene = furnished(coated(0.6, 0.4), coated(0.5, 0.4));
    let mut world = World::new(&scene, &config(10));
    assert!(world.features.has(Features::COAT));
    world.features = Features(world.features.0 & !Features::COAT.0);
    let residual = share(&ledgers(&world, &world.by_power(), 0..32), |e| e.residual * e.emitted);
    println!("{residual:?}");
    assert!(residual.value.abs() > 1e-3 && residual.value.abs() > 5.0 * residual.error);
}

/// A point light in an open scene: flux that meets nothing escapes.
#[test]
fn half_of_a_point_lights_flux_escapes_over_a_floor() {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.0));
    b.panel(floor, DVec3::ZERO, 1e4 * DVec3::Z, 1e4 * DVec3::X);
    b.light(DVec3::Y, 2.0);
    b.camera(DVec3::Y, DVec3::ZERO, 1.0);
    let all = scene_ledgers(&b.build(), 5, 8);
    let (escaped, absorbed) = (share(&all, |e| e.escaped), share(&all, |e| e.absorbed));
    println!("{escaped:?} {absorbed:?}");
    // 1e-4: the floor ends at 10 km.
    assert!((escaped.value - 0.5).abs() < 3.0 * escaped.error + 1e-4);
    assert!((absorbed.value + escaped.value - 1.0).abs() < 1e-5);
}

/// Light inside a glass cube (n = 1.5) whose three cosines are all below that of the critical angle, 0.745, is
/// reflected totally forever. This is 1 - 3 (1 - 0.745) = 0.236 of an isotropic source; it ends as cut. The rest
/// leaves, except light near the critical angle that still bounces after 64 bounces (computed here from Fresnel's
/// formula).
#[test]
fn endless_total_reflection_ends_and_is_counted_as_cut() {
    let mut b = Builder::default();
    let cube = b.material(glass(1.5));
    b.block(cube, DVec3::splat(-1.0), DVec3::splat(1.0), false);
    b.light(DVec3::new(0.1, 0.2, 0.3), 1.0);
    b.camera(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, 1.0);
    let all = scene_ledgers(&b.build(), 64, 8);
    let (cut, escaped) = (share(&all, |e| e.cut), share(&all, |e| e.escaped));
    let critical = (1.0 - 1.0 / 2.25f64).sqrt();
    let trapped = 1.0 - 3.0 * (1.0 - critical);
    println!("cut {cut:?}, trapped {trapped:.6}, escaped {escaped:?}");
    assert!((cut.value + escaped.value - 1.0).abs() < 1e-5, "glass absorbs nothing");
    assert!(cut.value > trapped - 3.0 * cut.error);
    // Upper bound: the band in which a quarter of 64 bounces (a ray meets each pair of faces by its cosine) reflects >
    // 1 %.
    let reflectance = |c: f64| {
        let t = (1.0 - 2.25 * (1.0 - c * c)).max(0.0).sqrt();
        0.5 * (((1.5 * c - t) / (1.5 * c + t)).powi(2) + ((c - 1.5 * t) / (c + 1.5 * t)).powi(2))
    };
    let steps = 100_000;
    let band: f64 = (0..steps)
        .map(|i| critical + (1.0 - critical) * (f64::from(i) + 0.5) / f64::from(steps))
        .map(|c| reflectance(c).powi(16) * 3.0 * (1.0 - critical) / f64::from(steps))
        .sum();
    println!("band {band:.6}");
    assert!(cut.value < trapped + band + 3.0 * cut.error);
}

/// Energies and the caustic image of a frame through a session.
fn session(choice: &RunnerChoice, scene: &Scene, features: Features) -> (EnergyLedger, Vec<Vec3>) {
    let config = RenderConfig { width: 48, height: 27, ..config(6) };
    let mut session = Session::new(
        choice,
        scene,
        &scene.cameras[0],
        &RenderConfig { gather: Some(&PHOTONS_GRID), ..config.clone() },
        features,
    )
    .unwrap();
    session.frame(3).unwrap();
    (session.energy().unwrap(), session.image().unwrap().caustics)
}

/// The ledger has the same bits on any number of threads, and computing it changes no bit of the image.
#[test]
fn ledger_is_deterministic_and_changes_no_bit_of_the_image() {
    let scene = mixed_room().build();
    let features = scene.features(0.25);
    let with = |threads| session(&RunnerChoice::Cpu { threads }, &scene, features | Features::LEDGER);
    let (one, three) = (with(1), with(3));
    assert!(one.0.emitted > 0.0 && one.0.absorbed > 0.0);
    assert_eq!(one, three);
    // Workers that add up on their own first give the same sums.
    let config = RenderConfig { width: 48, height: 27, ..config(6) };
    let world = World::new(&scene, &config);
    assert_eq!(one.0, ledger(&world, &world.by_power(), 3));
    let without = session(&RunnerChoice::Cpu { threads: 2 }, &scene, features);
    assert_eq!(without.0, EnergyLedger::default());
    assert!(without.1 == one.1 && one.1.iter().any(|value| *value != Vec3::ZERO));
}

/// The GPU's ledger is the CPU's, except for the paths that diverge: at most 0.2 % of them, which carry about as much
/// flux.
#[test]
fn ledgers_of_cpu_and_gpu_agree() {
    let Some(gpu) = gpu() else { return };
    let scene = mixed_room().build();
    let features = scene.features(0.25) | Features::LEDGER;
    let (cpu, _) = session(&RunnerChoice::Cpu { threads: 0 }, &scene, features);
    for &hardware in gpu.tracers() {
        let (gpu, _) = session(&gpu.choice(hardware), &scene, features);
        println!("CPU {cpu:?}\nGPU {gpu:?}");
        let parts =
            |e: &EnergyLedger| [e.emitted, e.absorbed, e.escaped, e.cut, e.shading_normals, e.left_to_camera];
        for (a, b) in parts(&cpu).iter().zip(parts(&gpu)) {
            assert!((a - b).abs() < 2e-3 * cpu.emitted, "{a} {b}");
        }
    }
}

mod long {
    use super::*;

    /// O10's bound, 1e-3 of the emitted flux.
    #[test]
    #[ignore = "three minutes"]
    fn ledger_balances_in_every_room_to_1e_3() {
        rooms_balance(Caustics::Any, &[], 512, 1e-3);
        rooms_balance(Caustics::First, &[], 512, 1e-3);
    }
}

mod release {
    use super::*;

    /// The validated history keeps the energy of caustics under any motion and with any number of light paths. Seeds
    /// are added until the standard error is below 1 %. The energy of the published history is printed beside it.
    #[test]
    #[ignore = "minutes"]
    fn validated_history_keeps_the_energy_of_moving_scenes_to_2_percent() {
        for (width, height, paths, frames) in [(192, 108, 0.5, 24), (64, 36, 200.0, 8)] {
            let light_paths = (paths * f64::from(width * height)) as u32;
            let config = RenderConfig {
                width,
                height,
                light_paths: Paths::Count(light_paths),
                ..RenderConfig::default()
            };
            for moving in Moving::ALL {
                let mut seeds = 2;
                let [mut validated, paper] = kept(moving, [&VALIDATED, &PAPER], &config, frames, seeds);
                while validated.error > 0.01 {
                    seeds *= 2;
                    assert!(seeds < 100, "the test has nothing to check: {validated:?}");
                    [validated] = kept(moving, [&VALIDATED], &config, frames, seeds);
                }
                println!(
                    "{moving:?}, {paths} paths a pixel: {:.4} +- {:.4}, {seeds} seeds; paper {:.3}",
                    validated.value, validated.error, paper.value
                );
                assert!((validated.value - 1.0).abs() < (3.0 * validated.error).max(0.02), "{moving:?}");
            }
        }
    }
}
