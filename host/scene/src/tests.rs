//! Committed scenes: warnings, kernel features, and visibility in the mirror room.

use std::path::Path;

use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::triangle::Triangle;
use glam::Vec3;

use super::*;

fn load(name: &str) -> Scene {
    Scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name).join("scene.gltf"))
        .unwrap()
}

/// Distance and triangle of the closest hit, by brute force [Moeller and Trumbore 1997].
fn closest(scene: &Scene, origin: Vec3, direction: Vec3) -> Option<(f32, usize)> {
    let hit = |triangle: &Triangle| {
        let (ab, ac) = (triangle.b - triangle.a, triangle.c - triangle.a);
        let p = direction.cross(ac);
        let scale = 1.0 / ab.dot(p);
        let from_a = origin - triangle.a;
        let (u, q) = (from_a.dot(p) * scale, from_a.cross(ab));
        let (v, t) = (direction.dot(q) * scale, ac.dot(q) * scale);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-4).then_some(t)
    };
    let hits = scene.triangles.iter().enumerate().filter_map(|(id, triangle)| Some((hit(triangle)?, id)));
    hits.min_by(|a, b| a.0.total_cmp(&b.0))
}

fn material(scene: &Scene, triangle: usize) -> &str {
    &scene.material_names[scene.surfaces[triangle].material as usize]
}

#[test]
fn scenes_load_without_warnings() {
    for name in caustics_scenes::NAMES {
        let scene = load(name);
        assert_eq!((scene.name.as_str(), scene.dropped_triangles), (name, 0));
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        assert_eq!(scene.cameras[0].name, "main");
        assert!((1_000..32_000).contains(&scene.triangles.len()), "{name}: {}", scene.triangles.len());
    }
}

#[test]
fn scenes_need_the_features_that_they_show() {
    let common = Features::AREA_LIGHTS | Features::SMOOTH_NORMALS | Features::RECEIVERS;
    let casting = common | Features::CASTERS | Features::MIRROR;
    assert_eq!(load("mirror-room").features(0.25), casting | Features::DIELECTRIC);
    assert_eq!(load("glossy-room").features(0.25), casting | Features::DIELECTRIC | Features::METAL);
    assert_eq!(load("ring").features(0.25), casting);
    assert_eq!(load("plain-room").features(0.25), common);
}

#[test]
fn casters_and_table_are_seen_in_the_mirror_only() {
    let scene = load("mirror-room");
    let camera = scene.cameras[0].camera(96, 54);
    let (mut in_mirror, mut seen) = (0, Vec::new());
    for pixel in 0..96 * 54 {
        let x = ((pixel % 96) as f32 + 0.5) / 48.0 - 1.0;
        let y = 1.0 - ((pixel / 96) as f32 + 0.5) / 27.0;
        let direction = (camera.forward + x * camera.right + y * camera.up).normalize();
        let (distance, first) = closest(&scene, camera.position, direction).expect("the room is closed");
        if material(&scene, first) != "mirror" {
            // Surfaces that the camera sees directly face away from the mirror, and get no light from it at once.
            let normal = geometry::face_normal(&scene.triangles[first]);
            let facing = normal * -normal.dot(direction).signum();
            assert!(facing.z > 0.9, "{} faces {facing}", material(&scene, first));
            continue;
        }
        in_mirror += 1;
        let mirrored = direction * Vec3::new(1.0, 1.0, -1.0);
        let (_, second) = closest(&scene, camera.position + distance * direction, mirrored).unwrap();
        seen.push(material(&scene, second));
    }
    assert!(in_mirror > 96 * 54 / 2, "the mirror must fill half of the image: {in_mirror} pixels");
    for name in ["ball", "ring", "table"] {
        assert!(seen.contains(&name), "{name} must be seen in the mirror");
    }
}
