//! A camera inside of glass: radiance from outside is n^2 (1 - F) times its value there, however the glass is stored.

use caustics::render_config::{Paths, RenderConfig};
use caustics::scene::{EnvironmentMap, Scene};
use caustics_kernels::interface::choice::PixelFilter;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::material::Material;
use caustics_tests::direct::{mean_and_error, render};
use caustics_tests::document::{self, Document};
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};
use serde_json::{Value, json};

use super::near;

const SIDE: u32 = 64;

/// Unpolarised Fresnel reflectance from a medium of index `n` into one of index 1 (or of their ratio).
fn fresnel(cos: f64, n: f64) -> f64 {
    let sin_out = n * (1.0 - cos * cos).sqrt();
    if sin_out >= 1.0 {
        return 1.0;
    }
    let cos_out = (1.0 - sin_out * sin_out).sqrt();
    let s = (n * cos - cos_out) / (n * cos + cos_out);
    let p = (cos - n * cos_out) / (cos + n * cos_out);
    0.5 * (s * s + p * p)
}

/// Radiance seen along -z, over what `expected` returns for the cosine between a pixel's direction and -z.
fn seen_over(scene: &Scene, max_bounces: u32, frames: u32, expected: impl Fn(f64) -> f64) -> (f64, f64) {
    let config = RenderConfig {
        width: SIDE,
        height: SIDE,
        light_paths: Paths::Count(1),
        max_bounces,
        pixel_filter: PixelFilter::Centre,
        ..RenderConfig::default()
    };
    let camera = scene.cameras[0].camera(SIDE, SIDE);
    assert!((camera.forward - Vec3::NEG_Z).length() < 1e-6);
    let expected: Vec<f64> = (0..SIDE * SIDE)
        .map(|pixel| {
            let at = |index: u32| (2.0 * f64::from(index) + 1.0) / f64::from(SIDE) - 1.0;
            let (x, y) = (at(pixel % SIDE), -at(pixel / SIDE));
            let direction =
                camera.forward.as_dvec3() + x * camera.right.as_dvec3() + y * camera.up.as_dvec3();
            expected(direction.normalize().dot(DVec3::NEG_Z))
        })
        .collect();
    let frames = render(scene, &config, "photons-grid", None, 0, frames);
    let ratios: Vec<f64> = frames
        .iter()
        .flat_map(|(image, _)| image.path.iter().zip(&expected))
        .map(|(seen, expected)| f64::from(seen.x) / expected)
        .collect();
    mean_and_error(&ratios)
}

/// Puts a scene under a uniform sky of radiance 1.
fn under_a_sky(mut scene: Scene) -> Scene {
    scene.set_environment(EnvironmentMap::constant(Vec3::ONE)).expect("a sky");
    assert!(scene.features(0.25).has(Features::STARTS_IN_MEDIUM));
    scene
}

/// A block of 2 x 2 x 2 m around a camera that looks along -z.
fn block(material: Material, fov: f32) -> Builder {
    let mut b = Builder::default();
    let solid = b.material(material);
    b.block(solid, DVec3::NEG_ONE, DVec3::ONE, false);
    b.camera(DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.1, 0.2, -1.0), fov);
    b
}

#[test]
fn camera_in_a_block_sees_n_squared_times_the_transmitted_sky() {
    for n in [1.33, 1.5, 2.4] {
        // Up to 0.33 rad at a corner, within the critical angle of an index of 2.4 (0.43 rad).
        let scene = under_a_sky(block(glass(n), 0.47).build());
        let n = f64::from(n);
        let seen = seen_over(&scene, 1, 16, |cos| n * n * (1.0 - fresnel(cos, n)));
        // f32: indices, Fresnel terms near the critical angle.
        near(&format!("n {n}, one bounce"), seen, 1.0, 1e-4);
        // All light reflected inside leaves through the opposite face, or comes back: 20 bounces leave out F^20.
        let all = seen_over(&scene, 20, 4, |_| n * n);
        near(&format!("n {n}, all bounces"), all, 1.0, 1e-4);
    }
}

#[test]
fn camera_in_a_tinted_block_sees_n_squared_times_the_transmitted_light() {
    let mut b = block(Material { absorption: Vec3::splat(0.5), ..glass(1.5) }, 0.02);
    let light = b.material(emitter(1.0));
    b.panel(light, DVec3::new(0.0, 0.0, -3.0), 4.0 * DVec3::X, 4.0 * DVec3::Y);
    // 1.3 m to the face; 1e-4 is for the field of view.
    let expected = 2.25 * 0.96 * (-0.65f64).exp();
    near("area light", seen_over(&b.build(), 1, 16, |_| expected), 1.0, 1e-4);
}

/// Glass within water: two faces, each by its own index.
#[test]
fn camera_in_glass_in_water_sees_n_squared_times_the_light_transmitted_by_both() {
    let mut b = block(glass(1.5), 0.02);
    let water = b.material(glass(1.33));
    b.block(water, DVec3::splat(-2.0), DVec3::splat(2.0), false);
    let scene = under_a_sky(b.build());
    let expected = 2.25 * (1.0 - fresnel(1.0, 1.5 / 1.33)) * (1.0 - fresnel(1.0, 1.33));
    near("glass in water", seen_over(&scene, 2, 16, |_| expected), 1.0, 1e-4);
}

/// A camera below the open surface of a basin.
#[test]
fn camera_under_water_sees_n_squared_times_the_transmitted_light() {
    let mut b = Builder::default();
    let (water, wall, light) = (b.material(glass(1.33)), b.material(lambert(0.0)), b.material(emitter(1.0)));
    b.block(wall, DVec3::NEG_ONE, DVec3::ONE, true);
    // Its front looks away from the camera.
    b.panel(water, DVec3::ZERO, 0.999 * DVec3::Y, 0.999 * DVec3::X);
    b.panel(light, DVec3::new(0.0, 0.0, -0.9), 0.9 * DVec3::X, 0.9 * DVec3::Y);
    b.camera(DVec3::new(0.0, 0.0, 0.5), DVec3::NEG_Z, 0.2);
    let seen = seen_over(&b.build(), 1, 16, |cos| 1.33 * 1.33 * (1.0 - fresnel(cos, 1.33)));
    near("water", seen, 1.0, 1e-4);
}

/// A block of glass on a node of this transform, around a camera at (5, 0.2, 0.3).
fn on_a_node(transform: Value, moves: bool, copies: u64) -> Scene {
    let mut document = Document::default();
    let solid = document.material(document::glass(1.5));
    let primitive = document.block(solid, DVec3::NEG_ONE, DVec3::ONE, false);
    let mesh = document.mesh(&[primitive]);
    let mut below = transform;
    below["mesh"] = json!(mesh);
    let nodes = document.json["nodes"].as_array_mut().expect("nodes");
    nodes.push(below);
    let centre = DVec3::new(5.0, 0.0, 0.0);
    let above = document.node(json!({ "children": [0], "translation": centre.to_array() }));
    if moves {
        document.animate(above, &[0.0, 1.0], &[centre, centre + DVec3::Y]);
    } else {
        // Store it once: another node has the mesh too, far away.
        document.node(json!({ "mesh": mesh, "translation": [-50.0, 0.0, 0.0] }));
    }
    document.camera(centre + DVec3::new(0.0, 0.2, 0.3), 0.47);
    document.load(copies)
}

#[test]
fn camera_in_an_instanced_block_sees_as_much_as_in_a_copied_block() {
    let transforms = [
        ("as it is", json!({})),
        ("mirrored", json!({ "scale": [-1.0, 1.0, 1.0] })),
        ("mirrored twice", json!({ "scale": [-1.0, -1.0, 1.0] })),
        ("turned by a right angle", json!({ "rotation": [0.0, 0.5f64.sqrt(), 0.0, 0.5f64.sqrt()] })),
        ("turned by half", json!({ "rotation": [1.0, 0.0, 0.0, 0.0] })),
        ("stretched and mirrored", json!({ "scale": [2.0, -1.5, 1.2] })),
    ];
    for (transform, node) in transforms {
        for (placement, moves, copies) in
            [("copied", false, u64::MAX), ("stored once", false, 0), ("moving", true, 0)]
        {
            let mut scene = on_a_node(node.clone(), moves, copies);
            let is_instance = !scene.instanced.instances.is_empty();
            assert_eq!(is_instance, placement != "copied");
            scene.set_environment(EnvironmentMap::constant(Vec3::ONE)).expect("a sky");
            let seen = seen_over(&scene, 1, 4, |cos| 2.25 * (1.0 - fresnel(cos, 1.5)));
            near(&format!("{transform}, {placement}"), seen, 1.0, 1e-4);
        }
    }
}
