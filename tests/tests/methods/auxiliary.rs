//! Auxiliary layers for other tools: known answers on planes and in a plane mirror, lengths in curved glass, and no
//! effect on anything else.

use caustics::render_config::{Paths, RenderConfig};
use caustics::rendered_image::Auxiliary;
use caustics::rendered_image::auxiliary::NO_MATERIAL;
use caustics::scene::{Scene, SceneCamera};
use caustics::session::Session;
use caustics::{history, method};
use caustics_kernels::interface::instance::Instance;
use caustics_kernels::interface::point::{PointGeometry, PointShading};
use caustics_tests::moving::Moving;
use caustics_tests::scenes::*;
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::collections::BTreeMap;

const WIDTH: u32 = 96;
const HEIGHT: u32 = 54;
/// Offset of the file's coordinates from the kernels' (m).
const ORIGIN: DVec3 = DVec3::new(100.0, 20.0, -50.0);
/// Planes of the mirror and of the wall: their z (m).
const MIRROR: f64 = -1.0;
const WALL: f64 = 2.9;

fn config() -> RenderConfig {
    RenderConfig {
        width: WIDTH,
        height: HEIGHT,
        light_paths: Paths::Count(2000),
        auxiliary: true,
        ..RenderConfig::default()
    }
}

/// A floor and a wall behind the camera, seen directly and in a mirror.
fn room() -> Scene {
    let mut b = Builder::default();
    let floor = b.material(lambert(0.7));
    let wall = b.material(lambert(0.3));
    let mirror = b.material(metal(1.0, 0.0));
    b.panel(floor, DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X);
    b.panel(wall, DVec3::new(0.0, 1.0, WALL), -3.0 * DVec3::X, 3.0 * DVec3::Y);
    b.panel(mirror, DVec3::new(0.0, 0.9, MIRROR), 1.5 * DVec3::X, 0.85 * DVec3::Y);
    b.light(DVec3::new(0.3, 2.0, 0.6), 5.0);
    b.camera(DVec3::new(0.1, 1.3, 1.6), DVec3::new(0.0, 0.75, -1.0), 0.9);
    Scene { origin: ORIGIN, ..b.build() }
}

/// Surface that a pixel shows, by plane geometry in f64.
struct Shown {
    material: f32,
    position: DVec3,
    normal: DVec3,
    depth: f64,
    /// Position of its virtual image (m).
    virtual_image: DVec3,
}

/// Unit direction of the ray through the middle of a pixel.
fn direction(camera: &SceneCamera, pixel: u32) -> DVec3 {
    let frame = camera.camera(WIDTH, HEIGHT);
    let x = (f64::from(pixel % WIDTH) + 0.5) / f64::from(WIDTH) * 2.0 - 1.0;
    let y = 1.0 - (f64::from(pixel / WIDTH) + 0.5) / f64::from(HEIGHT) * 2.0;
    (frame.forward.as_dvec3() + x * frame.right.as_dvec3() + y * frame.up.as_dvec3()).normalize()
}

/// Position of a point in a camera's image (px).
fn position_px(camera: &SceneCamera, at: DVec3) -> DVec2 {
    let frame = camera.camera(WIDTH, HEIGHT);
    let along = at - frame.position.as_dvec3();
    let coordinate = |axis: Vec3| {
        along.dot(axis.as_dvec3()) / along.dot(frame.forward.as_dvec3()) / f64::from(axis.length_squared())
    };
    let (x, y) = (coordinate(frame.right), coordinate(frame.up));
    DVec2::new(0.5 + 0.5 * x, 0.5 - 0.5 * y) * DVec2::new(f64::from(WIDTH), f64::from(HEIGHT))
}

/// The nearer of floor and wall along a ray: its material, distance (m) and normal.
fn on_room(from: DVec3, along: DVec3) -> (f32, f64, DVec3) {
    let floor = if along.y < 0.0 { -from.y / along.y } else { f64::INFINITY };
    let wall = if along.z > 0.0 { (WALL - from.z) / along.z } else { f64::INFINITY };
    if floor < wall { (0.0, floor, DVec3::Y) } else { (1.0, wall, -DVec3::Z) }
}

/// Surface that a pixel shows; none where there is nothing, or within a hundredth of an edge.
fn shown(camera: &SceneCamera, pixel: u32) -> Option<Shown> {
    let (eye, along) = (camera.position.as_dvec3(), direction(camera, pixel));
    let to_mirror = (MIRROR - eye.z) / along.z;
    let at = eye + to_mirror * along;
    let beside = (at.x.abs() - 1.5).max((at.y - 0.9).abs() - 0.85);
    if to_mirror > 0.0 && beside < -0.01 && at.y > 0.0 {
        let back = DVec3::new(along.x, along.y, -along.z);
        let (material, distance, normal) = on_room(at, back);
        let depth = to_mirror + distance;
        let position = at + distance * back;
        return Some(Shown { material, position, normal, depth, virtual_image: eye + depth * along })
            .filter(|shown| shown.position.x.abs() < 2.9);
    }
    let (material, depth, normal) = on_room(eye, along);
    let position = eye + depth * along;
    let is_there = depth.is_finite() && position.x.abs().max(position.z.abs()) < 2.9;
    let hides = to_mirror > 0.0 && to_mirror < depth && beside < 0.01;
    (is_there && !hides).then_some(Shown { material, position, normal, depth, virtual_image: position })
}

fn session(scene: &Scene, config: RenderConfig) -> Session {
    Session::builder(scene).config(config).build().expect("a session")
}

fn auxiliary(session: &mut Session, frame: u32) -> Auxiliary {
    session.frame(frame).expect("a frame");
    session.image().expect("an image").auxiliary
}

#[test]
fn auxiliary_layers_in_a_mirror_show_the_mirrored_surface() {
    let scene = room();
    let camera = scene.cameras[0].clone();
    let found = auxiliary(&mut session(&scene, config()), 0);
    let (mut direct, mut mirrored) = ([0; 2], [0; 2]);
    for pixel in 0..WIDTH * HEIGHT {
        let Some(shown) = shown(&camera, pixel) else { continue };
        let at = pixel as usize;
        let is_direct = (shown.virtual_image - shown.position).length() < 1e-9;
        let count = if is_direct { &mut direct } else { &mut mirrored };
        count[shown.material as usize] += 1;
        assert_eq!(found.material[at], shown.material, "pixel {pixel}");
        assert_eq!(found.albedo[at], Vec3::splat([0.7, 0.3][shown.material as usize]));
        assert!((found.normal[at].as_dvec3() - shown.normal).length() < 1e-6);
        // f32 of coordinates of 100 m.
        let position = found.position[at].as_dvec3();
        assert!((position - shown.position - ORIGIN).length() < 2e-5, "{position} {}", shown.position);
        assert!((f64::from(found.depth[at]) / shown.depth - 1.0).abs() < 1e-5);
        assert_eq!(found.motion[at], Vec2::ZERO, "nothing moved");
    }
    // The wall stands behind the camera.
    assert!(
        direct[0] > 300 && direct[1] == 0 && mirrored.iter().all(|&count| count > 300),
        "{direct:?} {mirrored:?}"
    );
    // The first pixel looks past all geometry.
    let nothing = (found.depth[0], found.position[0], found.normal[0], found.albedo[0], found.material[0]);
    assert_eq!(nothing, (0.0, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO, NO_MATERIAL));
}

/// Compares a still camera with one that moved aside and turned.
#[test]
fn motion_is_the_displacement_since_the_last_frame_in_mirrors_too() {
    let scene = room();
    let before = scene.cameras[0].clone();
    let eye = before.position + Vec3::new(0.15, -0.05, 0.1);
    let after = SceneCamera::look_at("main", eye, Vec3::new(0.1, 0.7, -1.0), Vec3::Y, before.fov_y);
    let mut session = session(&scene, config());
    auxiliary(&mut session, 0);
    session.pose(&scene, &after).expect("a pose");
    let found = auxiliary(&mut session, 1);
    let mut longest = 0.0f64;
    for pixel in 0..WIDTH * HEIGHT {
        let Some(shown) = shown(&after, pixel) else { continue };
        let expected = position_px(&after, shown.virtual_image) - position_px(&before, shown.virtual_image);
        let motion = found.motion[pixel as usize].as_dvec2();
        assert!((motion - expected).length() < 1e-3, "pixel {pixel}: {motion} instead of {expected}");
        longest = longest.max(expected.length());
    }
    assert!(longest > 3.0, "{longest}");
    // The camera is at rest again.
    assert!(auxiliary(&mut session, 2).motion.iter().all(|motion| *motion == Vec2::ZERO));
}

/// A plate slides by 0.6 m/s below a ring; a session that is opened at a pose moves from there.
#[test]
fn motion_of_a_moving_instance_is_its_displacement_in_the_image() {
    let mut scene = Moving::Receiver.scene();
    let mut session = session(&scene, config());
    for time in [0.5, 0.5 + 1.0 / 24.0] {
        scene.pose(time).expect("a pose");
        session.pose(&scene, &scene.cameras[0].clone()).expect("a pose");
        session.stand();
    }
    let found = auxiliary(&mut session, 0);
    let camera = &scene.cameras[0];
    let points: Vec<PointGeometry> = session.read("point_geometry").expect("points");
    let shading: Vec<PointShading> = session.read("point_shading").expect("points");
    let instances: Vec<Instance> = session.read("instances").expect("instances");
    assert!(instances.len() > 1);
    let (mut moving, mut still) = (0, 0);
    for ((point, shading), motion) in points.iter().zip(&shading).zip(&found.motion) {
        if point.depth != 1 {
            continue;
        }
        let way = if shading.instance == 0 { DVec3::ZERO } else { DVec3::X * 0.6 / 24.0 };
        let now = point.position.as_dvec3();
        let expected = position_px(camera, now) - position_px(camera, now - way);
        assert!((motion.as_dvec2() - expected).length() < 1e-3, "{motion} instead of {expected}");
        *(if shading.instance == 0 { &mut still } else { &mut moving }) += 1;
    }
    assert!(moving > 300 && still > 300, "{moving} {still}");
}

/// A scene that begins at a time has no motion there, whatever its pose was before.
#[test]
fn a_scene_that_begins_at_a_time_is_at_rest() {
    let mut scene = Moving::Receiver.scene();
    let opened = |scene: &Scene| auxiliary(&mut session(scene, config()), 0).motion;
    scene.pose(0.5).expect("a pose");
    assert!(opened(&scene).iter().any(|motion| motion.length() > 1.0), "the test has nothing to check");
    scene.begin_at(0.5).expect("a pose");
    assert!(opened(&scene).iter().all(|motion| *motion == Vec2::ZERO));
}

/// Curved glass: depth is the length of the light's path, whether or not a history needs the virtual image.
#[test]
fn depth_is_the_length_of_the_path_and_auxiliary_layers_change_no_bit() {
    let scene = committed("mirror-room");
    let rendered = |history, asked| {
        let config = RenderConfig { auxiliary: asked, history, ..config() };
        let mut session = session(&scene, config);
        let auxiliary = auxiliary(&mut session, 0);
        let lengths: Vec<PointShading> = session.read("point_shading").expect("points");
        let lengths: Vec<f32> = lengths.iter().map(|shading| shading.distance).collect();
        (session.image().expect("an image"), session.counters().expect("counters"), lengths, auxiliary)
    };
    let (image, counters, lengths, found) = rendered(&history::NONE, true);
    let there = found.depth.iter().filter(|depth| **depth > 0.0).count();
    assert!(lengths == found.depth && there > lengths.len() / 2, "{there}");
    let (plain, plain_counters, _, nothing) = rendered(&history::NONE, false);
    assert!(nothing.is_empty());
    assert_eq!((plain.beauty(), plain_counters), (image.beauty(), counters));
    // With a history, a point's distance is that of its virtual image.
    let (_, _, virtual_image_distances, same) = rendered(&history::VALIDATED, true);
    assert_eq!(same, found);
    let distorted = virtual_image_distances
        .iter()
        .zip(&found.depth)
        .filter(|(virtual_image, depth)| virtual_image != depth)
        .count();
    assert!(distorted > 50, "{distorted}");
    // Methods without points give the same layers.
    let mut path =
        Session::builder(&scene).config(config()).method(&method::PATH).build().expect("a session");
    assert_eq!(auxiliary(&mut path, 0), found);
}

#[test]
fn pixels_with_the_number_of_a_cell_lie_in_one_cube_on_one_surface() {
    let found = auxiliary(&mut session(&room(), config()), 0);
    let mut cells = BTreeMap::<u32, Vec<usize>>::new();
    for pixel in (0..found.cell.len()).filter(|&pixel| found.cell[pixel] != NO_MATERIAL) {
        cells.entry(found.cell[pixel] as u32).or_default().push(pixel);
    }
    assert!(cells.len() > 8, "{} cells", cells.len());
    for pixels in cells.values() {
        let positions = pixels.iter().map(|&pixel| found.position[pixel]);
        let (low, high) = positions.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), position| {
            (low.min(position), high.max(position))
        });
        let first = (found.material[pixels[0]], found.normal[pixels[0]]);
        assert!(pixels.iter().all(|&pixel| (found.material[pixel], found.normal[pixel]) == first));
        // Edges are powers of two; points are at most some 5 m from the eye, where 48 px are 2.4 m.
        assert!((high - low).max_element() < 2.0 + 1.0e-4, "{low} {high}");
    }
}
