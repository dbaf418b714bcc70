//! `still-life`: coloured glass and brass on a wooden table, in warm and cool light.
//!
//! A framed mirror behind the table leans towards the camera and shows the table from above, with all caustics. On the right, a pane
//! of glass stands before the clear ball and its caustic.

use glam::DVec3;

use crate::gltf::{Document, MaterialId, Texture, glass, lambert, metal, tinted};
use crate::lathe::{curve, lathe, line};
use crate::mesh::Mesh;
use crate::texture::{byte, draw, noise};
use crate::walls;

/// Lower corner of the room (m); the table's top is at y = 0.
const ROOM_MIN: DVec3 = DVec3::new(-2.4, -0.8, -1.4);
/// Upper corner of the room (m).
const ROOM_MAX: DVec3 = DVec3::new(2.4, 2.4, 3.2);
/// Half the table's width, and its rear and front edge (m).
const TABLE: [f64; 3] = [1.3, -0.85, 0.9];
/// Angle by which the mirror leans over the table (rad).
const LEAN: f64 = 0.30;
/// Ends of the pane along x, its position along z, and its height (m).
const PANE: [f64; 4] = [0.22, 0.66, 0.30, 0.27];
/// Gap between faces of touching objects (m).
const GAP: f64 = 0.001;

/// Builds the scene and its image, by file name.
pub fn build() -> (Document, Vec<(&'static str, Vec<u8>)>) {
    let mut document = Document::default();
    let wood = document.texture("wood.png");
    add_room(&mut document);
    add_table(&mut document, wood);
    let frame = document.material("frame", lambert([0.34, 0.24, 0.11]));
    add_mirror(&mut document, frame);
    add_pane(&mut document, frame);
    add_things(&mut document);
    add_lights(&mut document);
    document.camera("main", DVec3::new(0.0, 0.86, 2.6), DVec3::new(0.0, 0.30, -0.15), 0.385, 16.0 / 9.0);
    (document, vec![("wood.png", draw(256, planks))])
}

fn add_room(document: &mut Document) {
    let (centre, half) = (0.5 * (ROOM_MIN + ROOM_MAX), 0.5 * (ROOM_MAX - ROOM_MIN));
    let walls = [
        ("floor", [0.30, 0.24, 0.20], DVec3::Y),
        ("ceiling", [0.70, 0.68, 0.65], DVec3::NEG_Y),
        ("left wall", [0.42, 0.34, 0.30], DVec3::X),
        ("right wall", [0.30, 0.36, 0.42], DVec3::NEG_X),
        ("front wall", [0.60, 0.56, 0.52], DVec3::NEG_Z),
        ("back wall", [0.85, 0.68, 0.55], DVec3::Z),
    ];
    walls::add_walls(document, centre, half, walls);
}

fn add_table(document: &mut Document, wood: Texture) {
    let [width, rear, front] = TABLE;
    let mut top = lambert([0.6; 3]);
    top["pbrMetallicRoughness"]["baseColorTexture"] = wood.info();
    let top = document.material("wood", top);
    let (centre, half) = (DVec3::new(0.0, 0.0, 0.5 * (rear + front)), 0.5 * (front - rear));
    let mesh = Mesh::default().mapped_panel(centre, width * DVec3::X, half * DVec3::NEG_Z, 1.0);
    document.mesh("table top", top, &mesh);
    let body = document.material("table", lambert([0.20, 0.13, 0.09]));
    let (min, max) = (DVec3::new(-width, -0.05, rear), DVec3::new(width, -GAP, front));
    document.mesh("table", body, &Mesh::default().block(min, max));
}

fn add_mirror(document: &mut Document, frame: MaterialId) {
    let mirror = document.material("mirror", metal([0.95, 0.95, 0.95], 0.0));
    let up = DVec3::new(0.0, LEAN.cos(), LEAN.sin());
    let front = DVec3::X.cross(up);
    let half = DVec3::new(0.80, 0.38, 0.0);
    let centre = DVec3::new(0.0, 0.03, -0.74) + half.y * up;
    let panel = Mesh::default().panel(centre, half.x * DVec3::X, half.y * up);
    document.mesh("mirror", mirror, &panel);
    // Frame: a panel behind the mirror, 3 cm wider on each side.
    let behind = centre - 0.004 * front;
    let panel = Mesh::default().panel(behind, (half.x + 0.03) * DVec3::X, (half.y + 0.03) * up);
    document.mesh("frame", frame, &panel);
}

fn add_pane(document: &mut Document, frame: MaterialId) {
    let [left, right, at, height] = PANE;
    let block = |mesh: Mesh, x: [f64; 2], y: [f64; 2], half: f64| {
        mesh.block(DVec3::new(x[0], y[0], at - half), DVec3::new(x[1], y[1], at + half))
    };
    let pane = document.material("pane", glass(1.5, 0.008));
    document.mesh("pane", pane, &block(Mesh::default(), [left, right], [2.0 * GAP, height], 0.004));
    // Frame: two posts and a bar.
    let (outer_left, outer_right) = (left - GAP - 0.014, right + GAP + 0.014);
    let top = height + GAP;
    let mesh = block(Mesh::default(), [outer_left, left - GAP], [GAP, top], 0.007);
    let mesh = block(mesh, [right + GAP, outer_right], [GAP, top], 0.007);
    let mesh = block(mesh, [outer_left, outer_right], [top, top + 0.014], 0.007);
    document.mesh("frame of the pane", frame, &mesh);
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
    document.mesh("ruby ball", ruby, &ball([-0.48, 0.14], 0.12));
    document.mesh("clear ball", clear, &ball([0.42, 0.14], 0.085));
    document.mesh("sapphire ball", sapphire, &ball([0.64, -0.16], 0.10));
    let ring = |position: [f64; 2], radius: f64, height: f64| {
        let base = DVec3::new(position[0], GAP, position[1]);
        Mesh::default().ring(base, radius, radius + 0.006, height, 160, 2)
    };
    document.mesh("brass ring", brass, &ring([0.20, -0.26], 0.17, 0.11));
    document.mesh("steel ring", steel, &ring([-0.56, -0.28], 0.11, 0.09));

    // Solids of revolution of glass: a vase and a drop.
    let vase = [
        line([0.0, 0.30], [0.045, 0.30]),
        curve(&[[0.045, 0.30], [0.032, 0.24], [0.050, 0.16], [0.078, 0.09], [0.070, 0.03], [0.050, 0.0]], 5),
        line([0.050, 0.0], [0.0, 0.0]),
    ];
    let drop =
        [curve(&[[0.0, 0.24], [0.018, 0.18], [0.058, 0.10], [0.062, 0.05], [0.030, 0.0], [0.0, 0.0]], 5)];
    for (name, material, outline, position) in
        [("emerald vase", emerald, &vase[..], [-0.19, -0.12]), ("amber drop", amber, &drop[..], [0.02, 0.20])]
    {
        let mut mesh = lathe(72, outline);
        let offset = DVec3::new(position[0], GAP, position[1]).as_vec3();
        mesh.positions.iter_mut().for_each(|position| *position += offset);
        document.mesh(name, material, &mesh);
    }
}

fn add_lights(document: &mut Document) {
    let middle = DVec3::new(0.0, 0.0, -0.02);
    let wall = DVec3::new(0.0, 0.6, ROOM_MIN.z);
    for (name, position, target, color, intensity, angles) in [
        ("warm lamp", DVec3::new(-1.35, 0.72, -0.42), middle, [1.0, 0.72, 0.42], 22.0, [0.5, 0.7]),
        ("cool lamp", DVec3::new(1.50, 0.95, 0.55), middle, [0.55, 0.75, 1.0], 20.0, [0.38, 0.5]),
        ("room lamp", DVec3::new(0.3, 2.2, 1.8), wall, [1.0, 0.90, 0.80], 1.5, [1.2, 1.5]),
    ] {
        document.spot(name, position, target, color, intensity, angles);
    }
}

/// Texture of planks along the texture's rows, each with its own shade and a grain.
fn planks(x: f64, y: f64) -> [u8; 4] {
    let row = (12.0 * y) as u32;
    let across = (12.0 * y).fract();
    if across.min(1.0 - across) < 0.03 {
        return [44, 28, 18, 255];
    }
    let shade = 0.75 + 0.25 * noise(row, 3);
    // Streaks of half a plank's length, a few texels wide.
    let streak = noise((256.0 * y) as u32, 11 + 2 * row + ((2.0 * x + noise(row, 5)) as u32));
    let [red, green, blue] = [0.62, 0.45, 0.31].map(|channel| byte(channel * shade * (0.90 + 0.10 * streak)));
    [red, green, blue, 255]
}
