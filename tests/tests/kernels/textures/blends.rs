//! Blended surfaces block a share of the rays: each layer and each ray decides independently, in every tracer and for
//! every kind of ray.

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::Scene;
use caustics::scene::texture::Role;
use caustics_kernels::interface::choice::Caustics;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::ray::Ray;
use caustics_kernels::interface::texture::MaterialTextures;
use caustics_kernels::math::rng::{Rng, Stream};
use caustics_kernels::texture::cut_out::hash_float;
use caustics_kernels::trace::Tracer;
use caustics_tests::chi_square::Fit;
use caustics_tests::direct::*;
use caustics_tests::energy::{ledgers, share};
use caustics_tests::scenes::*;
use caustics_tests::statistics::Mean;
use glam::{DVec3, Vec3};

/// Numbers of layers of a stack.
const LAYERS: [u32; 4] = [0, 1, 2, 4];

/// Black panes of alpha a half above each other, between heights of 0.5 m and 0.9 m; a floor and a far light above.
fn stack(layers: u32, floor: bool) -> Builder {
    let mut b = Builder::default();
    let (grey, dark) = (b.material(lambert(0.5)), b.textured(lambert(0.0), veil(0.5)));
    if floor {
        b.panel(grey, DVec3::ZERO, 1.0 * DVec3::Z, 1.0 * DVec3::X);
    }
    for layer in 0..layers {
        b.panel(dark, DVec3::new(0.0, 0.5 + 0.1 * f64::from(layer), 0.0), 4.0 * DVec3::Z, 4.0 * DVec3::X);
    }
    b.light(DVec3::new(0.0, 1000.0, 0.0), 1e6);
    b.camera(DVec3::new(0.0, 0.45, 0.0), DVec3::ZERO, 1.2);
    b
}

/// Whether a mean is the share of `all` that `layers` panes of alpha a half pass. Three standard errors exclude one
/// layer less.
fn passes(layers: u32, mean: &Mean, all: f64) -> bool {
    let expected = all * 0.5f64.powi(layers as i32);
    println!("{layers} layers: {:.5} +- {:.5} of {expected:.5}", mean.value, mean.error);
    assert!(layers == 0 || mean.error < 0.1 * expected, "too noisy to tell");
    (mean.value - expected).abs() <= 3.0 * mean.error + 1e-6 * all
}

/// Shares of rays that pass a stack, in 64 groups, by keys as paths have them.
fn through(layers: u32, key: impl Fn(u32) -> u32) -> Mean {
    let scene = stack(layers, true).build();
    let features = scene.features(0.25);
    assert_eq!(features.has(Features::BLENDS), layers > 0);
    let mut tracer = scene.tracer(features);
    let groups = (0..64).map(|group| {
        let passed = (0..1000).filter(|path| {
            let path = 1000 * group + path;
            let u = Rng::new(Stream::Light, 2, path, 0).next4();
            let origin = Vec3::new(7.9 * u.x - 3.95, 2.0, 7.9 * u.y - 3.95);
            let ray = Ray { length: 1.9, key: key(path), ..Ray::endless(origin, Vec3::NEG_Y) };
            let hit = tracer.closest(&ray);
            assert_eq!(tracer.occluded(&ray), !hit.is_miss(), "occlusion and closest hit differ");
            hit.is_miss()
        });
        passed.count() as f64 / 1000.0
    });
    Mean::from_samples(&groups.collect::<Vec<_>>())
}

#[test]
fn rays_pass_n_layers_of_alpha_half_with_probability_2_to_the_minus_n() {
    for layers in LAYERS {
        let key = |path| Rng::new(Stream::Camera, 7, path, 0).ray_key(0);
        assert!(passes(layers, &through(layers, key), 1.0));
    }
    // With one key all rays pass a triangle, or none does.
    assert!(!passes(2, &through(2, |_| 5), 1.0));
}

#[test]
fn cameras_see_2_to_the_minus_n_of_light_through_n_layers_of_alpha_half() {
    let background = Some([0.25, 0.5, 1.0]);
    let config = RenderConfig {
        width: 48,
        height: 48,
        light_paths: Paths::Count(1),
        background,
        ..RenderConfig::default()
    };
    for layers in &LAYERS[1..] {
        let mut b = stack(*layers, false);
        // From above, where the panes fill the view.
        b.camera(DVec3::new(0.0, 1.5, 0.0), DVec3::new(0.0, 0.0, 0.1), 1.0);
        let mut scene = b.build();
        scene.cameras.remove(0);
        let frames = render(&scene, &config, "photons-grid", None, 0, 16);
        let means: Vec<f64> = frames.iter().map(|frame| mean_of(&frame.0.path)).collect();
        let all = mean_of(&[Vec3::new(0.25, 0.5, 1.0)]);
        assert!(passes(*layers, &Mean::from_samples(&means), all));
    }
}

#[test]
fn direct_light_through_n_layers_of_alpha_half_is_2_to_the_minus_n() {
    let config = RenderConfig {
        width: 48,
        height: 48,
        light_paths: Paths::Count(1),
        max_bounces: 1,
        ..RenderConfig::default()
    };
    let frames = |layers| {
        let frames = render(&stack(layers, true).build(), &config, "photons-grid", None, 0, 16);
        Mean::from_samples(&frames.iter().map(|frame| mean_of(&frame.0.path)).collect::<Vec<_>>())
    };
    let open = frames(0).value;
    assert!(LAYERS.into_iter().all(|layers| passes(layers, &frames(layers), open)));
}

/// The ledger counts the blocked light as absorbed.
#[test]
fn light_paths_pass_n_layers_of_alpha_half_with_probability_2_to_the_minus_n() {
    for layers in &LAYERS[1..] {
        let scene = stack(*layers, false).build();
        let caustics = Caustics::Any;
        let config = RenderConfig {
            width: 8,
            height: 8,
            light_paths: Paths::Count(10_000),
            caustics,
            ..RenderConfig::default()
        };
        let mut world = World::new(&scene, &config);
        world.params.quantum = 2.0f32.powi(-40);
        let beam = Beam {
            centre: Vec3::new(0.0, 2.0, 0.0),
            direction: Vec3::NEG_Y,
            axes: [3.0 * Vec3::Z, 3.0 * Vec3::X],
            round: false,
            irradiance: 1.0,
        };
        let all = ledgers(&world, &beam, 0..32);
        assert!(passes(*layers, &share(&all, |energy| energy.escaped), 1.0));
        let lost = share(&all, |energy| energy.emitted - energy.escaped - energy.absorbed);
        assert!(lost.value.abs() < 1e-5, "{lost:?}");
    }
}

/// A pair of numbers for each of many positions in a sequence.
type Pairs<'a> = &'a dyn Fn(u32) -> (f32, f32);

/// Whether pairs pass a chi-square test of independence and uniformity at a level of 1e-5.
fn are_independent(pairs: Pairs) -> bool {
    const SIDE: usize = 16;
    let count = 200_000;
    let mut cells = [0u32; SIDE * SIDE];
    for index in 0..count {
        let (a, b) = pairs(index);
        cells[(a * SIDE as f32) as usize * SIDE + (b * SIDE as f32) as usize] += 1;
    }
    Fit::new(&cells, &[f64::from(count) / (SIDE * SIDE) as f64; SIDE * SIDE]).passes()
}

#[test]
fn alpha_tests_of_layers_and_rays_are_independent() {
    // Key of a path after a number of samples, as collect and shoot compute it.
    let key = |stream: Stream, path: u32, frame: u32, samples: u32, number: u32| {
        let mut rng = Rng::new(stream, 3, path, frame);
        for _ in 0..samples {
            rng.next4();
        }
        rng.ray_key(number)
    };
    let camera = |path: u32| key(Stream::Camera, path, 0, 1, 0);
    for step in [1, 2, 3, 64, 1000, 1 << 20] {
        assert!(
            are_independent(&|i| (hash_float(camera(i), 17, 0), hash_float(camera(i), 17 + step, 0))),
            "triangles {step}"
        );
        assert!(
            are_independent(&|i| (hash_float(camera(i), i, 0), hash_float(camera(i), i + step, 0))),
            "triangles {step}"
        );
        assert!(
            are_independent(&|i| (hash_float(camera(i), 17, 3), hash_float(camera(i), 17, 3 + step))),
            "instances {step}"
        );
        assert!(
            are_independent(&|i| (hash_float(camera(i), 5, 0), hash_float(camera(i + step), 5, 0))),
            "paths {step}"
        );
        let frame = |frame| move |i| hash_float(key(Stream::Camera, i, frame, 1, 0), 5, 0);
        assert!(are_independent(&|i| (frame(0)(i), frame(step)(i))), "frames {step}");
    }
    let others: [(&str, &dyn Fn(u32) -> u32); 4] = [
        ("the next segment", &|i| key(Stream::Camera, i, 0, 2, 0)),
        ("the one after", &|i| key(Stream::Camera, i, 0, 4, 0)),
        ("a shadow ray", &|i| key(Stream::Camera, i, 0, 2, 1)),
        ("a light path", &|i| key(Stream::Light, i, 0, 1, 0)),
    ];
    for (what, other) in others {
        assert!(are_independent(&|i| (hash_float(camera(i), 9, 0), hash_float(other(i), 9, 0))), "{what}");
        let sample = |i| Rng::new(Stream::Camera, 3, i, 0).next4();
        assert!(
            are_independent(&|i| (sample(i).x, hash_float(other(i), 9, 0))),
            "{what} and what is sampled"
        );
    }
    // A hash of the key alone makes all layers decide alike; a hash of the triangle alone makes all rays decide alike.
    assert!(!are_independent(&|i| (hash_float(camera(i), 0, 0), hash_float(camera(i), 0, 0))));
    assert!(!are_independent(&|i| (hash_float(0, i % 64, 0), hash_float(0, (i + 1) % 64, 0))));
}

/// A pane with a texture in a lit room.
fn pane_of(record: impl Fn(&mut Builder) -> MaterialTextures) -> Scene {
    let mut b = mixed_room();
    let record = record(&mut b);
    let pane = b.textured(lambert(0.7), record);
    b.panel(pane, DVec3::new(0.0, -0.2, 0.5), 0.3 * DVec3::X, 0.3 * DVec3::Y);
    b.build()
}

/// A texture of alpha 1 except for one texel of this alpha.
fn spotted(b: &mut Builder, alpha: u8) -> u32 {
    b.texture(Role::Color, 8, 8, |x, y| [255, 200, 90, if (x, y) == (3, 5) { alpha } else { 255 }])
}

#[test]
fn alpha_of_1_everywhere_is_opaque_to_the_bit() {
    let config =
        RenderConfig { width: 48, height: 36, light_paths: Paths::Count(4000), ..RenderConfig::default() };
    let image = |scene: &Scene| render(scene, &config, "photons-grid", None, 0, 1).remove(0).0;
    let textured = |b: &mut Builder, alpha, blends| MaterialTextures {
        base_color: spotted(b, alpha),
        blends,
        ..MaterialTextures::default()
    };
    let opaque = pane_of(|b| textured(b, 255, 0));
    let blended = pane_of(|b| textured(b, 255, 1));
    assert!(!blended.features(0.25).has(Features::BLENDS) && image(&opaque) == image(&blended));
    let plain = pane_of(|_| MaterialTextures::default());
    let blended = pane_of(|_| veil(1.0));
    assert!(!blended.features(0.25).has(Features::BLENDS) && image(&plain) == image(&blended));
    // One texel is enough.
    let spotted = pane_of(|b| textured(b, 254, 1));
    assert!(spotted.features(0.25).has(Features::BLENDS));
    assert!(image(&pane_of(|_| veil(0.5))) != image(&plain));
}

/// All code compiled in changes no bit of a scene in which nothing blends.
#[test]
fn blend_code_changes_no_bit_where_nothing_blends() {
    let config =
        RenderConfig { width: 48, height: 36, light_paths: Paths::Count(4000), ..RenderConfig::default() };
    let scene = mixed_room().build();
    let all = render(&scene, &config, "photons-grid", Some(Features::ALL), 0, 1);
    let own = render(&scene, &config, "photons-grid", None, 0, 1);
    assert!(!scene.features(0.25).has(Features::BLENDS) && all[0].0.path == own[0].0.path);
}

/// The faces of a medium exist for all rays: otherwise its inside would begin and never end.
#[test]
fn media_ignore_alpha_and_thin_walls_blend() {
    for (material, blends) in [(glass(1.5), false), (pane(1.5), true)] {
        let mut b = mixed_room();
        let material = b.textured(material, veil(0.5));
        b.block(material, DVec3::new(-0.1, -0.1, 0.3), DVec3::new(0.1, 0.1, 0.5), false);
        assert_eq!(b.build().features(0.25).has(Features::BLENDS), blends);
    }
}
