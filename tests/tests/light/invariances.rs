//! O9: changes that must keep an image, and changes that must scale it.

use bytemuck::{cast_slice, pod_collect_to_vec};
use caustics::render_config::{Paths, RenderConfig};
use caustics::rendered_image::RenderedImage;
use caustics::scene::Scene;
use caustics::session::{RunnerChoice, open};
use caustics_kernels::gather::variant;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::method::basic::{self, BASIC};
use caustics_kernels::method::frame::frame_buffers;
use caustics_kernels::pass::collect::pixel_order;
use caustics_tests::direct::*;
use caustics_tests::scenes::*;
use glam::{DVec3, Vec3};
use std::path::Path;

fn config() -> RenderConfig {
    RenderConfig { width: 64, height: 48, light_paths: Paths::Count(60_000), ..RenderConfig::default() }
}

fn image(scene: &Scene, config: &RenderConfig) -> RenderedImage {
    render(scene, config, "photons-grid", None, 0, 1).remove(0).0
}

fn assert_same(a: &RenderedImage, b: &RenderedImage, what: &str) {
    assert!(a.path == b.path, "{what}: path differs in {} pixels", differing(&a.path, &b.path));
    assert!(a.caustics == b.caustics, "{what}: {} pixels", differing(&a.caustics, &b.caustics));
    assert!(a == b, "{what}: points differ");
}

fn differing(a: &[Vec3], b: &[Vec3]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

fn max_relative(a: &[Vec3], b: &[Vec3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (*a - *b).length() / (b.length() + 1e-20)).fold(0.0, f32::max)
}

#[test]
fn threads_change_no_bit_of_any_gather() {
    let scene = mixed_room().build();
    for gather in variant::ALL.iter().filter(|variant| !variant.hardware) {
        let light_paths = if gather.name == "brute" { 2_000 } else { 60_000 };
        let config = RenderConfig { light_paths: Paths::Count(light_paths), ..config() };
        let runs = [1, 2, 7].map(|threads| render(&scene, &config, gather.name, None, threads, 2));
        for frame in 0..2 {
            for run in &runs[1..] {
                assert_same(&runs[0][frame].0, &run[frame].0, gather.name);
                assert_eq!(runs[0][frame].1, run[frame].1);
            }
        }
        let first = &runs[0];
        assert!(first[0].0.caustics != first[1].0.caustics && first[0].0.path != first[1].0.path);
        assert!(first[0].0.photons.iter().sum::<f32>() > 50.0, "the test has nothing to check");
    }
}

#[test]
fn threads_change_no_bit_of_a_blended_scene() {
    let scene = blended_room().build();
    let config = RenderConfig { light_paths: Paths::Count(60_000), ..config() };
    let runs = [1, 2, 7].map(|threads| render(&scene, &config, "photons-grid", None, threads, 2));
    for frame in 0..2 {
        for run in &runs[1..] {
            assert_same(&runs[0][frame].0, &run[frame].0, "what blends");
        }
    }
    let (first, second) = (&runs[0][0].0, &runs[0][1].0);
    assert!(first.caustics != second.caustics && mean_of(&first.caustics) > 1e-3);
}

#[test]
fn another_seed_changes_most_pixels() {
    let scene = mixed_room().build();
    let (a, b) = (image(&scene, &config()), image(&scene, &RenderConfig { seed: 1, ..config() }));
    assert!(differing(&a.path, &b.path) > 64 * 48 / 2);
    assert!(differing(&a.caustics, &b.caustics) > 100);
}

/// Builds a scene.
type Make = fn() -> Builder;
/// Scenes that together have every kind of light.
const SCENES: [(&str, Make); 2] = [("mixed room", mixed_room), ("open air", open_air)];

#[test]
fn images_scale_with_the_light() {
    for (name, scene) in SCENES {
        let plain = image(&scene().build(), &config());
        assert!(mean_of(&plain.caustics) > 1e-3, "{name} has no caustics");
        for exponent in [-20, 20] {
            let scale = 2.0_f32.powi(exponent);
            let mut scaled = image(&scene().brightened(scale).build(), &config());
            scaled.path.iter_mut().chain(&mut scaled.caustics).for_each(|value| *value /= scale);
            assert_same(&plain, &scaled, &format!("{name}, light x 2^{exponent}"));
        }
        // Other factors: the paths are the same, so that only rounding differs.
        for scale in [1e-6_f32, 1e6] {
            let mut scaled = image(&scene().brightened(scale).build(), &config());
            scaled.path.iter_mut().chain(&mut scaled.caustics).for_each(|value| *value /= scale);
            let (path, caustics) =
                (max_relative(&scaled.path, &plain.path), max_relative(&scaled.caustics, &plain.caustics));
            println!(
                "{name}, light x {scale:e}: largest relative difference: path {path:e}, caustics {caustics:e}"
            );
            assert!(path < 1e-4 && caustics < 1e-4);
        }
    }
}

#[test]
fn images_do_not_depend_on_the_unit_of_length() {
    for (name, scene) in SCENES {
        let plain = image(&scene().build(), &config());
        for exponent in [-10, 13] {
            let scale = 2.0_f32.powi(exponent);
            let mut scaled = image(&scene().scaled(scale).build(), &config());
            scaled.radius.iter_mut().for_each(|radius| *radius /= scale);
            assert_same(&plain, &scaled, &format!("{name}, lengths x 2^{exponent}"));
        }
        for scale in [1e-3_f32, 0.1, 10.0, 1e4] {
            let scaled = image(&scene().scaled(scale).build(), &config());
            let path = mean_of(&scaled.path) / mean_of(&plain.path) - 1.0;
            let caustics = mean_of(&scaled.caustics) / mean_of(&plain.caustics) - 1.0;
            let off =
                plain.path.iter().zip(&scaled.path).filter(|(a, b)| (**a - **b).length() > 1e-3 * a.length());
            println!(
                "{name}, lengths x {scale:e}: mean path {path:e}, mean caustics {caustics:e}, {} pixels off by 1e-3",
                off.count()
            );
            // The mean over few pixels moves where one path takes another turn.
            assert!(path.abs() < 1e-3 && caustics.abs() < 1e-3);
        }
    }
}

/// Renders with the scene's features and with all; prints the features that change a bit.
fn assert_needs_change_nothing(name: &str, scene: &Scene) {
    let own = render(scene, &config(), "photons-grid", None, 0, 1).remove(0);
    let with = |features| render(scene, &config(), "photons-grid", Some(features), 0, 1).remove(0);
    let all = with(Features::ALL);
    if own.0 != all.0 {
        let features = scene.features(0.25);
        for (bit, bit_name) in Features::NAMES.into_iter().filter(|&(bit, _)| !features.has(bit)) {
            let one = with(features | bit).0;
            let off = |a: &[Vec3], b: &[Vec3]| (differing(a, b), max_relative(a, b));
            let (path, caustics) = (off(&one.path, &own.0.path), off(&one.caustics, &own.0.caustics));
            println!("{name} with {bit_name}: path {path:?}, caustics {caustics:?} (pixels, largest)");
        }
    }
    assert_same(&own.0, &all.0, name);
    assert_eq!(own.1, all.1, "{name}");
}

#[test]
fn code_of_unused_features_changes_no_bit() {
    for name in ["mirror-room", "glossy-room", "plain-room", "ring", "textured-room"] {
        assert_needs_change_nothing(name, &committed(name));
    }
    for (name, scene) in SCENES {
        assert_needs_change_nothing(name, &scene().build());
    }
    // An index of 1 leaves the coat its grazing reflection.
    let mut scene = committed("plain-room");
    scene.materials[0].specular = 1.0;
    scene.materials[0].ior = 1.0;
    scene.materials[0].roughness = 0.5;
    assert_needs_change_nothing("coat of index 1", &scene);
}

/// Flat faces only: interpolated normals must equal the face's to the bit.
#[test]
fn code_for_smooth_normals_changes_no_bit_of_flat_scenes() {
    let mut flat = Builder::default();
    let wall = flat.material(lambert(0.6));
    let mirror = flat.material(metal(0.9, 0.0));
    flat.block(wall, DVec3::splat(-1.0), DVec3::splat(1.0), true);
    flat.panel(mirror, DVec3::new(0.0, -0.9, -0.5), 0.5 * DVec3::Z, DVec3::new(0.4, 0.1, 0.0));
    flat.light(DVec3::new(0.2, 0.7, 0.1), 1.0);
    flat.camera(DVec3::new(0.1, 0.2, 0.95), DVec3::new(0.0, -0.45, 0.0), 0.9);
    assert_needs_change_nothing("flat", &flat.build());
}

/// The committed ring below a root node that is translated by `by` along every axis.
fn translated_ring(folder: &Path, by: f64) -> Scene {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/ring");
    let text = std::fs::read_to_string(source.join("scene.gltf")).unwrap();
    let mut document: serde_json::Value = serde_json::from_str(&text).unwrap();
    let roots = document["scenes"][0]["nodes"].clone();
    let nodes = document["nodes"].as_array_mut().unwrap();
    nodes.push(serde_json::json!({ "name": "moved", "children": roots, "translation": [by, -by, by] }));
    let root = nodes.len() - 1;
    document["scenes"][0]["nodes"] = serde_json::json!([root]);
    std::fs::copy(source.join("scene.bin"), folder.join("scene.bin")).unwrap();
    let path = folder.join("scene.gltf");
    std::fs::write(&path, document.to_string()).unwrap();
    Scene::load(&path).unwrap()
}

#[test]
fn scene_moved_by_1e5_m_keeps_its_image_means() {
    let folder = tempfile::tempdir().unwrap();
    let plain = translated_ring(folder.path(), 0.0);
    let expected = image(&plain, &config());
    assert_same(&expected, &image(&committed("ring"), &config()), "a root node at the origin");
    for by in [1e4, 1e5] {
        let moved = translated_ring(folder.path(), by);
        assert!((moved.origin - plain.origin - DVec3::new(by, -by, by)).length() < 1e-9 * by);
        let farthest = plain
            .triangles
            .iter()
            .zip(&moved.triangles)
            .map(|(a, b)| (a.a - b.a).length().max((a.b - b.b).length()).max((a.c - b.c).length()))
            .fold(0.0, f32::max);
        let got = image(&moved, &config());
        let path = mean_of(&got.path) / mean_of(&expected.path) - 1.0;
        let caustics = mean_of(&got.caustics) / mean_of(&expected.caustics) - 1.0;
        println!(
            "moved by {by:e}: corners by {farthest:e} m, mean path {path:e}, mean caustics {caustics:e}, {} pixels differ",
            differing(&got.path, &expected.path)
        );
        // Corners round to another f32 in an ulp of 7 m at most; single paths may take another turn.
        assert!(farthest <= 1e-6);
        assert!(path.abs() < 1e-3 && caustics.abs() < 1e-2);
    }
}

/// Light paths in batches give the bits of one batch: sums are integers.
#[test]
fn batches_of_light_paths_change_no_bit() {
    let scene = mixed_room().build();
    let config = config();
    let features = scene.features(config.specular_roughness);
    let variant = &variant::PHOTONS_GRID;
    let whole = config.params(&scene, &scene.cameras[0], 0);
    assert_eq!(whole.light_path_batch, whole.light_path_count, "one batch");
    let caustics = [60_000, 7_001, 1_000].map(|batch| {
        let params = FrameParams {
            light_path_batch: batch,
            photon_capacity: batch * (config.max_bounces - 1),
            ..whole
        };
        let buffers = frame_buffers(&BASIC, variant.into(), &params);
        let mut runner = open(&RunnerChoice::Cpu { threads: 0 }, &scene, features, &buffers).unwrap();
        let order = pixel_order(params.width, params.height);
        runner.write("pixel_order", cast_slice(&order)).unwrap();
        runner.run(&params, &basic::steps(variant, &params)).unwrap();
        let words: Vec<u32> = pod_collect_to_vec(&runner.read("accumulator").unwrap());
        let counters: Vec<u32> = pod_collect_to_vec(&runner.read("counters").unwrap());
        (words, counters)
    });
    assert!(caustics[0].0.iter().any(|&word| word != 0));
    assert!(caustics[1] == caustics[0] && caustics[2] == caustics[0]);
}

/// A delta lobe is specular whatever the threshold: mirror-room has no other reflections.
#[test]
fn specular_threshold_of_0_changes_no_bit_of_a_delta_mirror() {
    let scene = committed("mirror-room");
    let with = |specular_roughness| {
        let config = RenderConfig { specular_roughness, ..config() };
        render(&scene, &config, "photons-grid", None, 0, 1).remove(0).0
    };
    assert_same(&with(0.25), &with(0.0), "threshold 0");
}
