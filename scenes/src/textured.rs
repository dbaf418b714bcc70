//! `textured-room`: every kind of texture in one room.
//!
//! A lamp of bright panes shines through a sheet of leaves onto a tiled floor. A metal panel, polished in rings, casts caustics
//! on it. A flat brick wall has a normal map. A glass ball stands on the tiles.

use glam::DVec3;
use serde_json::json;

use crate::gltf::{Document, Texture, emitter, glass, lambert, metal};
use crate::mesh::Mesh;
use crate::texture::{byte, draw, noise, normal};

/// Lower corner of the room (m).
const MIN: DVec3 = DVec3::new(-2.0, 0.0, -2.0);
/// Upper corner (m).
const MAX: DVec3 = DVec3::new(2.0, 2.6, 2.0);
/// Centre of the light (m).
const LIGHT_CENTRE: DVec3 = DVec3::new(0.9, 2.55, -0.3);
/// Half the light's side (m).
const LIGHT_HALF_SIDE: f64 = 0.07;
/// Radiance of the light's brightest panes (W m^-2 sr^-1).
const LIGHT_RADIANCE: f64 = 800.0;
/// Radius of the glass ball (m).
const BALL_RADIUS: f64 = 0.22;
/// Gap between faces of touching objects (m).
const GAP: f64 = 0.001;

/// Builds the room and its images, by file name.
pub fn build() -> (Document, Vec<(&'static str, Vec<u8>)>) {
    let images = vec![
        ("tiles.png", draw(256, tiles)),
        ("bricks.png", draw(256, bricks)),
        ("rings.png", draw(128, rings)),
        ("leaves.png", draw(256, leaves)),
        ("panes.png", draw(32, panes)),
    ];
    let mut document = Document::default();
    let textures: Vec<Texture> = images.iter().map(|(name, _)| document.texture(name)).collect();
    let [tiles, bricks, rings, leaves, panes] = textures[..] else {
        unreachable!("five images, five textures")
    };
    add_walls(&mut document, tiles, bricks);
    add_things(&mut document, rings, leaves, panes);
    document.camera("main", DVec3::new(-0.1, 1.45, 1.9), DVec3::new(0.0, 0.75, -1.0), 0.9, 16.0 / 9.0);
    (document, images)
}

fn add_walls(document: &mut Document, tiles: Texture, bricks: Texture) {
    let (centre, half) = (0.5 * (MIN + MAX), 0.5 * (MAX - MIN));
    let mut tiled = lambert([1.0; 3]);
    tiled["pbrMetallicRoughness"]["baseColorTexture"] = tiles.info();
    let mut bricked = lambert([0.55, 0.36, 0.28]);
    bricked["normalTexture"] = bricks.info();
    let walls = [
        ("floor", tiled, DVec3::Y, 4.0),
        ("ceiling", lambert([0.7, 0.7, 0.68]), DVec3::NEG_Y, 1.0),
        ("left wall", lambert([0.55, 0.58, 0.62]), DVec3::X, 1.0),
        ("right wall", lambert([0.62, 0.60, 0.55]), DVec3::NEG_X, 1.0),
        ("front wall", lambert([0.6; 3]), DVec3::NEG_Z, 1.0),
        ("back wall", bricked, DVec3::Z, 3.0),
    ];
    for (name, material, facing, repeats) in walls {
        let right = if facing.y == 0.0 { DVec3::Y.cross(facing) } else { DVec3::X };
        let up = facing.cross(right);
        let wall = Mesh::default().mapped_panel(centre - facing * half, right * half, up * half, repeats);
        let material = document.material(name, material);
        document.mesh(name, material, &wall);
    }
}

fn add_things(document: &mut Document, rings: Texture, leaves: Texture, panes: Texture) {
    let mut light = emitter([1.0; 3], LIGHT_RADIANCE);
    light["emissiveTexture"] = panes.info();
    let light = document.material("lamp", light);
    let panel = Mesh::default().mapped_panel(
        LIGHT_CENTRE,
        LIGHT_HALF_SIDE * DVec3::X,
        LIGHT_HALF_SIDE * DVec3::Z,
        1.0,
    );
    document.mesh("lamp", light, &panel);

    let mut foliage = lambert([1.0; 3]);
    foliage["pbrMetallicRoughness"]["baseColorTexture"] = leaves.info();
    foliage["alphaMode"] = json!("MASK");
    foliage["alphaCutoff"] = json!(0.5);
    foliage["doubleSided"] = json!(true);
    let foliage = document.material("leaves", foliage);
    let sheet =
        Mesh::default().mapped_panel(DVec3::new(0.7, 0.95, -0.55), 0.55 * DVec3::X, 0.55 * DVec3::Z, 1.0);
    document.mesh("leaves", foliage, &sheet);

    let mut polished = metal([0.95, 0.86, 0.66], 1.0);
    polished["pbrMetallicRoughness"]["metallicRoughnessTexture"] = rings.info();
    let polished = document.material("panel", polished);
    // The panel leans on the left wall, turned to the lamp.
    let up = DVec3::new(-0.25, 1.0, 0.0).normalize();
    let centre = DVec3::new(-1.6, 0.62, -0.7);
    let panel = Mesh::default().mapped_panel(centre, 0.6 * DVec3::NEG_Z, 0.6 * up, 1.0);
    document.mesh("panel", polished, &panel);

    let ball = document.material("ball", glass(1.5, 2.0 * BALL_RADIUS));
    let centre = DVec3::new(-0.45, BALL_RADIUS + GAP, -0.2);
    document.mesh("ball", ball, &Mesh::default().sphere(centre, BALL_RADIUS, 96, 48));
}

/// Texture of four by four tiles of two woods, with joints.
fn tiles(x: f64, y: f64) -> [u8; 4] {
    let (column, row) = ((4.0 * x) as u32, (4.0 * y) as u32);
    let (along_x, along_y) = ((4.0 * x).fract(), (4.0 * y).fract());
    let edge = along_x.min(1.0 - along_x).min(along_y).min(1.0 - along_y);
    if edge < 0.03 {
        return [70, 66, 60, 255];
    }
    let base = if (column + row).is_multiple_of(2) { [0.82, 0.74, 0.62] } else { [0.50, 0.36, 0.26] };
    // Eight planks a tile, each with its own shade.
    let plank = if (column + row).is_multiple_of(2) { along_x } else { along_y };
    let shade = 0.86 + 0.14 * noise(8 * (4 * row + column) + (8.0 * plank) as u32, 7);
    let [red, green, blue] = base.map(|channel| byte(channel * shade));
    [red, green, blue, 255]
}

/// Normal map of bricks: eight rows in a bond, with rounded edges.
fn bricks(x: f64, y: f64) -> [u8; 4] {
    let row = (8.0 * y) as u32;
    let shifted = 4.0 * x + if row.is_multiple_of(2) { 0.5 } else { 0.0 };
    let (along_x, along_y) = (shifted.fract(), (8.0 * y).fract());
    // Slope at this distance from an edge, in brick lengths.
    let slope =
        |distance: f64, width: f64| if distance < width { 1.2 * (1.0 - distance / width) } else { 0.0 };
    let right = slope(along_x, 0.08) - slope(1.0 - along_x, 0.08);
    let down = slope(along_y, 0.16) - slope(1.0 - along_y, 0.16);
    let rough = |seed: u32| 0.12 * (noise((64.0 * x) as u32, 64 * seed + (64.0 * y) as u32) - 0.5);
    normal(right + rough(1), -down + rough(2))
}

/// Metal texture, polished to a mirror in rings and matt between.
fn rings(x: f64, y: f64) -> [u8; 4] {
    let distance = (x - 0.5).hypot(y - 0.5);
    let wave = 0.5 + 0.5 * (distance * 40.0).cos();
    [0, byte(0.02 + 0.43 * (1.0 - wave) * (1.0 - wave)), 255, 255]
}

/// Texture of leaves on a transparent ground: an ellipse in each of seven by seven cells, turned and shifted at random.
fn leaves(x: f64, y: f64) -> [u8; 4] {
    let cells = 7;
    let (column, row) = ((x * 7.0) as i32, (y * 7.0) as i32);
    for cell_y in row - 1..=row + 1 {
        for cell_x in column - 1..=column + 1 {
            if !(0..cells).contains(&cell_x) || !(0..cells).contains(&cell_y) {
                continue;
            }
            let random = |k: u32| noise((cell_y * cells + cell_x) as u32, k);
            let (sin, cos) = (random(1) * std::f64::consts::TAU).sin_cos();
            let (dx, dy) = (
                x * 7.0 - f64::from(cell_x) - 0.3 - 0.4 * random(2),
                y * 7.0 - f64::from(cell_y) - 0.3 - 0.4 * random(3),
            );
            let (along, across) = (cos * dx + sin * dy, cos * dy - sin * dx);
            // Pointed at both ends.
            let width = 0.26 * (1.0 - (along / 0.62) * (along / 0.62));
            if width > 0.0 && across.abs() < width {
                let vein = if across.abs() < 0.03 { 0.7 } else { 1.0 };
                let green = (0.45 + 0.25 * random(4)) * vein;
                return [byte(0.45 * green), byte(green), byte(0.2 * green), 255];
            }
        }
    }
    [60, 90, 30, 0]
}

/// Texture of four by four panes of different warmth behind dark bars.
fn panes(x: f64, y: f64) -> [u8; 4] {
    let (along_x, along_y) = ((4.0 * x).fract(), (4.0 * y).fract());
    let edge = along_x.min(1.0 - along_x).min(along_y).min(1.0 - along_y);
    if edge < 0.12 {
        return [20, 16, 12, 255];
    }
    let warmth = noise((4.0 * x) as u32, (4.0 * y) as u32);
    [255, byte(0.98 - 0.15 * warmth), byte(0.92 - 0.35 * warmth), 255]
}
