//! `still-life`: coloured glass and brass on a wooden table, in warm and cool light.
//!
//! A low screen hides the table from the camera, except through a pane of glass. A mirror leans over the table towards the camera
//! and shows it from above. Caustics are visible in the mirror and through the pane only; their casters are also visible
//! directly.

use glam::DVec3;

use crate::gltf::{Document, Texture, glass, lambert, metal, tinted};
use crate::lathe::{curve, lathe, line};
use crate::mesh::Mesh;
use crate::texture::{byte, draw, noise};
use crate::walls;

/// Lower corner of the room (m); the table's top is at y = 0.
const ROOM_MIN: DVec3 = DVec3::new(-2.4, -0.8, -1.4);
/// Upper corner of the room (m).
const ROOM_MAX: DVec3 = DVec3::new(2.4, 2.4, 3.2);
/// Half the table's width, and its rear and front edge (m).
const TABLE: [f64; 3] = [1.0, -0.75, 0.5];
/// Angle by which the mirror leans over the table (rad).
const LEAN: f64 = 0.42;
/// Position of the screen along z, and its height (m).
const SCREEN: [f64; 2] = [0.47, 0.2];
/// Ends of the pane in the screen along x (m).
const PANE: [f64; 2] = [0.2, 0.62];
/// Gap between faces of touching objects (m).
const GAP: f64 = 0.001;

/// Builds the scene and its image, by file name.
pub fn build() -> (Document, Vec<(&'static str, Vec<u8>)>) {
    let mut document = Document::default();
    let wood = document.texture("wood.png");
    add_room(&mut document);
    add_table(&mut document, wood);
    add_mirror(&mut document);
    add_screen(&mut document);
    add_things(&mut document);
    add_lights(&mut document);
    document.camera("main", DVec3::new(0.0, 0.62, 2.5), DVec3::new(0.0, 0.31, 0.0), 0.345, 16.0 / 9.0);
    (document, vec![("wood.png", draw(256, planks))])
}

fn add_room(document: &mut Document) {
    let (centre, half) = (0.5 * (ROOM_MIN + ROOM_MAX), 0.5 * (ROOM_MAX - ROOM_MIN));
    let walls = [
        ("floor", [0.30, 0.24, 0.20], DVec3::Y),
        ("ceiling", [0.55, 0.55, 0.55], DVec3::NEG_Y),
        ("left wall", [0.42, 0.34, 0.30], DVec3::X),
        ("right wall", [0.30, 0.36, 0.42], DVec3::NEG_X),
        ("front wall", [0.40, 0.38, 0.36], DVec3::NEG_Z),
        ("back wall", [0.16, 0.20, 0.24], DVec3::Z),
    ];
    walls::add_walls(document, centre, half, walls);
}

fn add_table(document: &mut Document, wood: Texture) {
    let [width, rear, front] = TABLE;
    let mut top = lambert([1.0; 3]);
    top["pbrMetallicRoughness"]["baseColorTexture"] = wood.info();
    let top = document.material("wood", top);
    let (centre, half) = (DVec3::new(0.0, 0.0, 0.5 * (rear + front)), 0.5 * (front - rear));
    let mesh = Mesh::default().mapped_panel(centre, width * DVec3::X, half * DVec3::NEG_Z, 1.0);
    document.mesh("table top", top, &mesh);
    let body = document.material("table", lambert([0.20, 0.13, 0.09]));
    let (min, max) = (DVec3::new(-width, -0.05, rear), DVec3::new(width, -GAP, front));
    document.mesh("table", body, &Mesh::default().block(min, max));
}

fn add_mirror(document: &mut Document) {
    let mirror = document.material("mirror", metal([0.95, 0.95, 0.95], 0.0));
    let frame = document.material("frame", lambert([0.34, 0.24, 0.11]));
    let up = DVec3::new(0.0, LEAN.cos(), LEAN.sin());
    let front = DVec3::X.cross(up);
    let half = DVec3::new(0.82, 0.36, 0.0);
    let centre = DVec3::new(0.0, 0.06, -0.74) + half.y * up;
    let panel = Mesh::default().panel(centre, half.x * DVec3::X, half.y * up);
    document.mesh("mirror", mirror, &panel);
    // A panel behind the mirror, 3 cm wider on each side.
    let behind = centre - 0.004 * front;
    let sheet = Mesh::default().panel(behind, (half.x + 0.03) * DVec3::X, (half.y + 0.03) * up);
    document.mesh("frame", frame, &sheet);
}

fn add_screen(document: &mut Document) {
    let cloth = document.material("screen", lambert([0.10, 0.06, 0.07]));
    let [at, height] = SCREEN;
    let [left, right] = PANE;
    let panel = |from: f64, to: f64| {
        let (min, max) = (DVec3::new(from, GAP, at - 0.004), DVec3::new(to, height, at + 0.004));
        Mesh::default().block(min, max)
    };
    document.mesh("left screen", cloth, &panel(-TABLE[0], left - GAP));
    document.mesh("right screen", cloth, &panel(right + GAP, TABLE[0]));
    let pane = document.material("pane", glass(1.5, 0.008));
    document.mesh("pane", pane, &panel(left, right));
}

fn add_things(document: &mut Document) {
    let ruby = document.material("ruby", tinted(1.52, [0.92, 0.10, 0.14], 0.10));
    let emerald = document.material("emerald", tinted(1.52, [0.10, 0.72, 0.42], 0.10));
    let sapphire = document.material("sapphire", tinted(1.52, [0.16, 0.34, 0.95], 0.10));
    let amber = document.material("amber", tinted(1.54, [0.98, 0.62, 0.10], 0.10));
    let clear = document.material("clear", glass(1.5, 0.2));
    let brass = document.material("brass", metal([0.94, 0.76, 0.42], 0.02));
    let steel = document.material("steel", metal([0.90, 0.90, 0.92], 0.02));

    let ball = |position: [f64; 2], radius: f64| {
        let centre = DVec3::new(position[0], radius + GAP, position[1]);
        Mesh::default().sphere(centre, radius, 80, 40)
    };
    document.mesh("ruby ball", ruby, &ball([-0.46, 0.10], 0.12));
    document.mesh("clear ball", clear, &ball([0.41, 0.20], 0.085));
    document.mesh("sapphire ball", sapphire, &ball([0.64, -0.12], 0.10));
    let ring = |position: [f64; 2], radius: f64, height: f64| {
        let base = DVec3::new(position[0], GAP, position[1]);
        Mesh::default().ring(base, radius, radius + 0.006, height, 160, 2)
    };
    document.mesh("brass ring", brass, &ring([0.24, -0.24], 0.17, 0.11));
    document.mesh("steel ring", steel, &ring([-0.60, -0.28], 0.11, 0.09));

    // Solids of revolution of glass: a vase and a drop.
    let vase = [
        line([0.0, 0.30], [0.045, 0.30]),
        curve(&[[0.045, 0.30], [0.032, 0.24], [0.050, 0.16], [0.078, 0.09], [0.070, 0.03], [0.050, 0.0]], 5),
        line([0.050, 0.0], [0.0, 0.0]),
    ];
    let drop =
        [curve(&[[0.0, 0.24], [0.018, 0.18], [0.058, 0.10], [0.062, 0.05], [0.030, 0.0], [0.0, 0.0]], 5)];
    for (name, material, outline, position) in
        [("emerald vase", emerald, &vase[..], [-0.18, -0.12]), ("amber drop", amber, &drop[..], [0.05, 0.14])]
    {
        let mut mesh = lathe(72, outline);
        let offset = DVec3::new(position[0], GAP, position[1]).as_vec3();
        mesh.positions.iter_mut().for_each(|position| *position += offset);
        document.mesh(name, material, &mesh);
    }
}

fn add_lights(document: &mut Document) {
    let middle = DVec3::new(0.0, 0.0, -0.1);
    for (name, position, color, intensity) in [
        ("warm lamp", DVec3::new(-1.70, 0.95, 0.55), [1.0, 0.72, 0.42], 14.0),
        ("cool lamp", DVec3::new(1.70, 1.05, 0.25), [0.55, 0.75, 1.0], 10.0),
    ] {
        document.spot(name, position, middle, color, intensity, [0.45, 0.65]);
    }
}

/// Texture of planks along the texture's rows, each with its own shade and a grain.
fn planks(x: f64, y: f64) -> [u8; 4] {
    let row = (9.0 * y) as u32;
    let across = (9.0 * y).fract();
    if across.min(1.0 - across) < 0.03 {
        return [44, 28, 18, 255];
    }
    let shade = 0.75 + 0.25 * noise(row, 3);
    // Streaks of half a plank's length, a few texels wide.
    let streak = noise((256.0 * y) as u32, 11 + 2 * row + ((2.0 * x + noise(row, 5)) as u32));
    let [red, green, blue] = [0.62, 0.45, 0.31].map(|channel| byte(channel * shade * (0.90 + 0.10 * streak)));
    [red, green, blue, 255]
}
