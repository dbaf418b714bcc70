//! `animated-camera`: a flight along a perfect and a glossy mirror, which show the caustics on the floor before them.
//!
//! Lamps hang on the wall above the mirrors and face away from it, so that hardly any of their light meets the mirrors. The light
//! in a mirror is thus a reflection of the room.

use glam::DVec3;

use crate::gltf::{Document, Interpolation, Property, emitter, glass, looking, metal};
use crate::mesh::Mesh;
use crate::walls;

/// Duration of the flight (s).
const DURATION: f64 = 2.0;
/// Keys of the orientation: one for each frame at 24 per second, and the last.
const KEYS: u32 = 48;
/// Gap between faces of touching objects (m).
const GAP: f64 = 0.001;
/// Position of the left casters along x (m).
const LEFT: f64 = -1.3;
/// Position of the right casters along x (m).
const RIGHT: f64 = 1.3;

/// Builds the scene.
pub fn build() -> Document {
    let mut document = Document::default();
    add_walls(&mut document);
    add_mirrors(&mut document);
    add_lights(&mut document);
    add_casters(&mut document);
    add_camera(&mut document);
    document
}

/// Eye and target at a fraction of the flight; smooth.
fn view(share: f64) -> (DVec3, DVec3) {
    let x = -1.7 + 3.4 * share;
    // An arc that dips towards the mirrors, and a rise.
    let bow = 4.0 * share * (1.0 - share);
    let eye = DVec3::new(x, 1.55 + 0.25 * share, 1.85 - 0.35 * bow);
    let target = DVec3::new(-1.25 + 2.5 * share, 0.45, -1.35);
    (eye, target)
}

fn add_camera(document: &mut Document) {
    let (eye, target) = view(0.0);
    let camera = document.camera("main", eye, target, 45_f64.to_radians(), 16.0 / 9.0);
    // The path is a parabola: a single cubic is exact.
    let slope = |share: f64| {
        let step = 1e-3;
        (view(share + step).0 - view(share - step).0) / (2.0 * step * DURATION)
    };
    let keys: Vec<[f64; 3]> = [0.0, 1.0]
        .iter()
        .flat_map(|&share| [slope(share), view(share).0, slope(share)].map(|row| row.to_array()))
        .collect();
    document.animate(camera, Property::Translation, Interpolation::Cubic, &[0.0, DURATION], &keys);
    let shares: Vec<f64> = (0..=KEYS).map(|key| f64::from(key) / f64::from(KEYS)).collect();
    let times: Vec<f64> = shares.iter().map(|share| share * DURATION).collect();
    let turns: Vec<[f64; 4]> = shares
        .iter()
        .map(|&share| {
            let (eye, target) = view(share);
            looking(eye, target).to_array()
        })
        .collect();
    document.animate(camera, Property::Rotation, Interpolation::Linear, &times, &turns);
}

fn add_walls(document: &mut Document) {
    let (centre, half) = (DVec3::new(0.0, 1.4, 0.0), DVec3::new(3.0, 1.4, 2.2));
    // Name, albedo, facing direction
    let walls = [
        ("floor", [0.34, 0.32, 0.29], DVec3::Y),
        ("ceiling", [0.30, 0.30, 0.29], DVec3::NEG_Y),
        ("left wall", [0.36, 0.22, 0.18], DVec3::X),
        ("right wall", [0.18, 0.26, 0.34], DVec3::NEG_X),
        ("front wall", [0.28, 0.27, 0.25], DVec3::NEG_Z),
        ("back wall", [0.12, 0.12, 0.13], DVec3::Z),
    ];
    walls::add_walls(document, centre, half, walls);
}

fn add_mirrors(document: &mut Document) {
    for (name, x, roughness) in [("mirror", LEFT, 0.0), ("glossy mirror", RIGHT, 0.15)] {
        let material = document.material(name, metal([0.95, 0.95, 0.95], roughness));
        let centre = DVec3::new(x, 1.0, -2.18);
        let panel = Mesh::default().panel(centre, 1.15 * DVec3::X, 0.85 * DVec3::Y);
        document.mesh(name, material, &panel);
    }
}

fn add_lights(document: &mut Document) {
    let material = document.material("lamp", emitter([1.0, 0.92, 0.80], 1500.0));
    let mut panels = Mesh::default();
    for x in [LEFT, RIGHT] {
        // From the side: caustics fall beside their casters, visible to the camera and in the mirrors.
        let centre = DVec3::new(x + 1.3 * x.signum(), 2.05, -2.1);
        let facing = (DVec3::new(x, 0.0, -0.7) - centre).normalize();
        let right = facing.cross(DVec3::Y).normalize();
        panels = panels.panel(centre, 0.05 * right, 0.05 * right.cross(-facing));
    }
    document.mesh("lamps", material, &panels);
}

fn add_casters(document: &mut Document) {
    let clear = document.material("glass", glass(1.5, 0.4));
    let brass = document.material("ring", metal([0.95, 0.87, 0.68], 0.02));
    let ball =
        |x: f64, z: f64, radius: f64| Mesh::default().sphere(DVec3::new(x, radius + GAP, z), radius, 64, 32);
    document.mesh("left ball", clear, &ball(LEFT - 0.35, -0.85, 0.2));
    document.mesh("right ball", clear, &ball(RIGHT + 0.3, -0.8, 0.24));
    let ring = |x: f64, z: f64, radius: f64| {
        Mesh::default().ring(DVec3::new(x, GAP, z), radius, radius + 0.008, 0.12, 192, 2)
    };
    document.mesh("left ring", brass, &ring(LEFT + 0.4, -0.7, 0.3));
    document.mesh("right ring", brass, &ring(RIGHT - 0.4, -0.75, 0.28));
}
