//! Baselines `kim2019` and `yang2021` in known failure modes (`tests/stability.toml`), beside OurBasic.

use caustics::render_config::{Paths, RenderConfig};
use caustics::rendered_image::RenderedImage;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::method::Method;
use caustics_kernels::method::basic::BASIC;
use caustics_kernels::method::kim2019::KIM2019;
use caustics_kernels::method::yang2021::YANG2021;
use caustics_tests::scenes::{Builder, committed, half_room, lambert, metal};
use glam::{DVec3, Vec3};

/// The methods whose receivers are primary surfaces.
const BASELINES: [&Method; 2] = [&KIM2019, &YANG2021];

fn config(width: u32, height: u32) -> RenderConfig {
    RenderConfig { width, height, light_paths: Paths::Count(100_000), seed: 4, ..RenderConfig::default() }
}

fn image(scene: &Scene, config: &RenderConfig, method: &'static Method) -> RenderedImage {
    let (choice, features) = (RunnerChoice::Cpu { threads: 0 }, scene.features(config.specular_roughness));
    let mut session =
        Session::new(&choice, scene, &scene.cameras[0], &RenderConfig { method, ..config.clone() }, features)
            .unwrap();
    session.frame(0).unwrap();
    session.image().unwrap()
}

fn sum(layer: &[Vec3]) -> f64 {
    layer.iter().map(|value| f64::from(value.element_sum())).sum()
}

/// A block whose back face a small mirror lights, while its top, which the camera faces, stays dark. The virtual light,
/// the mirror's upper edge and the block's edge are on one line. Without the block the light lies on the ground.
fn lit_from_behind(block: bool) -> Scene {
    let mut b = Builder::default();
    let grey = b.material(lambert(0.6));
    let mirror = b.material(metal(1.0, 0.0));
    if block {
        b.block(grey, DVec3::new(-0.4, 0.0, -0.2), DVec3::new(0.4, 0.5, 0.2), false);
    } else {
        b.panel(grey, DVec3::ZERO, 2.0 * DVec3::Z, 2.0 * DVec3::X);
    }
    // Seen from the virtual light at z = -1.2, y = 1.3 at the mirror is y = 0.5 at the block's edge.
    let (low, high) = (1.2, 1.299);
    let centre = DVec3::new(0.0, 0.5 * (low + high), -1.0);
    b.panel(mirror, centre, 0.06 * DVec3::X, 0.5 * (high - low) * DVec3::Y);
    b.light(DVec3::new(0.0, 1.5, -0.8), 1.0);
    b.camera(DVec3::new(0.0, 2.5, 1.5), DVec3::new(0.0, 0.5, -0.1), 0.35);
    b.build()
}

/// Photons in screen space are placed by their distance, on any face: photons just behind an edge are taken for photons
/// before it. A disc knows its face.
#[test]
fn kim_leaks_round_a_corner_and_discs_do_not() {
    let (block, ground, config) = (lit_from_behind(true), lit_from_behind(false), config(128, 128));
    let caustics = |scene, method| sum(&image(scene, &config, method).caustics);
    let lit = caustics(&ground, &BASIC);
    let (basic, [kim, yang]) = (caustics(&block, &BASIC), BASELINES.map(|method| caustics(&block, method)));
    println!("leaks: basic {basic}, kim2019 {kim:.3}, yang2021 {yang:.3}; without the block {lit:.3}");
    assert!(lit > 1.0, "the test has nothing to check");
    assert_eq!((basic, yang), (0.0, 0.0));
    assert!(kim > 1.0e-2, "the baseline has become better than its source");
}

/// A wall of 0.8 % of its distance separates a room with a mirror and a light from the viewer's half. That is within
/// the tolerance of photons in screen space. The wall's far side faces away from the viewer, and contributes nothing.
#[test]
fn no_baseline_lets_a_caustic_through_a_thin_wall() {
    let (dark, lit) = (half_room(Some(0.004)), half_room(None));
    for method in BASELINES {
        let rendered = |scene| image(scene, &config(32, 32), method);
        assert!(sum(&rendered(&lit).caustics) > 1.0, "the test has nothing to check");
        let name = method.name;
        assert!(
            rendered(&dark).caustics.iter().all(|value| *value == Vec3::ZERO),
            "{name} leaks through the wall"
        );
    }
}

/// The half room in a wide strip of a view, which sees a wall of 3 % of its distance stand on the side walls. A pixel
/// there reaches along a side wall from before the thin wall to behind it.
#[test]
fn kim_leaks_no_light_along_a_side_wall_past_a_thin_wall() {
    let caustics = |mut scene: Scene| {
        scene.cameras[0].fov_y = 0.4;
        sum(&image(&scene, &config(23, 3), &KIM2019).caustics)
    };
    assert_eq!(caustics(half_room(Some(0.02))), 0.0);
    assert!(caustics(half_room(None)) > 1.0, "the test has nothing to check");
}

#[test]
fn baselines_render_odd_sizes_and_no_caustics_without_casters_or_light_paths() {
    for method in BASELINES {
        for (width, height) in [(1, 1), (1, 37), (19, 1), (33, 17)] {
            let rendered = image(&committed("ring"), &config(width, height), method);
            let name = method.name;
            assert_eq!(rendered.caustics.len(), (width * height) as usize, "{name}");
            assert!(rendered.caustics.iter().all(|value| value.is_finite()), "{name} at {width}x{height}");
            assert!(sum(&rendered.caustics) > 0.0 || width * height < 100, "{name} at {width}x{height}");
        }
        let plain = image(&committed("plain-room"), &config(64, 36), method);
        assert_eq!(sum(&plain.caustics), 0.0, "{}: there is no caster", method.name);
        let none = RenderConfig { light_paths: Paths::Count(0), ..config(64, 36) };
        assert_eq!(sum(&image(&committed("ring"), &none, method).caustics), 0.0, "{}", method.name);
    }
}
