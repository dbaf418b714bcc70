//! `animated-light`: a lamp swings over a room. Its caustics move over floor and walls, and two mirrors show them.
//!
//! A screen keeps its light off one corner, where a weak, resting lamp casts a resting caustic.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use crate::gltf::{Document, Interpolation, Property, emitter, glass, lambert, metal};
use crate::mesh::Mesh;
use crate::walls;

/// Period of the swing (s).
const PERIOD: f64 = 2.0;
/// Largest angle of the swing (rad).
const LARGEST: f64 = 0.6;
/// Pivot of the swing (m).
const PIVOT: DVec3 = DVec3::new(-1.35, 2.5, -0.95);
/// Length of the rod (m).
const ROD: f64 = 0.8;
/// Gap between faces of touching objects (m).
const GAP: f64 = 0.001;

/// Builds the scene.
pub fn build() -> Document {
    let mut document = Document::default();
    add_walls(&mut document);
    add_mirrors(&mut document);
    add_swing(&mut document);
    add_casters(&mut document);
    add_corner(&mut document);
    document.camera("main", DVec3::new(0.0, 1.75, 2.0), DVec3::new(0.05, 0.55, -1.5), 0.82, 16.0 / 9.0);
    document
}

fn add_walls(document: &mut Document) {
    let (centre, half) = (DVec3::new(0.0, 1.4, 0.0), DVec3::new(2.2, 1.4, 2.1));
    // Name, albedo, facing direction
    let walls = [
        ("floor", [0.34, 0.32, 0.29], DVec3::Y),
        ("ceiling", [0.30, 0.30, 0.29], DVec3::NEG_Y),
        ("left wall", [0.34, 0.24, 0.20], DVec3::X),
        ("right wall", [0.20, 0.27, 0.33], DVec3::NEG_X),
        ("front wall", [0.28, 0.27, 0.25], DVec3::NEG_Z),
        ("back wall", [0.12, 0.12, 0.13], DVec3::Z),
    ];
    walls::add_walls(document, centre, half, walls);
}

fn add_mirrors(document: &mut Document) {
    for (name, x, roughness) in [("mirror", -1.1, 0.0), ("glossy mirror", 0.55, 0.15)] {
        let material = document.material(name, metal([0.95, 0.95, 0.95], roughness));
        let panel = Mesh::default().panel(DVec3::new(x, 0.95, -2.08), 0.75 * DVec3::X, 0.75 * DVec3::Y);
        document.mesh(name, material, &panel);
    }
}

/// Adds the swinging light: built around its pivot, facing down, and turned about z.
fn add_swing(document: &mut Document) {
    let material = document.material("lamp", emitter([1.0, 0.93, 0.82], 900.0));
    let panel = Mesh::default().panel(DVec3::new(0.0, -ROD, 0.0), 0.05 * DVec3::X, 0.05 * DVec3::Z);
    let light = document.mesh("lamp", material, &panel);
    document.place(light, PIVOT);
    // The angle is a sine. Cubics with the quaternion's tangents between eight keys are within 1e-4 of it.
    let times: Vec<f64> = (0..=8).map(|key| PERIOD * f64::from(key) / 8.0).collect();
    let rows: Vec<[f64; 4]> = times
        .iter()
        .flat_map(|time| {
            let phase = TAU * time / PERIOD;
            let (half, speed) = (0.5 * LARGEST * phase.sin(), 0.5 * LARGEST * phase.cos() * TAU / PERIOD);
            let tangent = [0.0, 0.0, half.cos() * speed, -half.sin() * speed];
            [tangent, DQuat::from_rotation_z(2.0 * half).to_array(), tangent]
        })
        .collect();
    document.animate(light, Property::Rotation, Interpolation::Cubic, &times, &rows);
}

fn add_casters(document: &mut Document) {
    let clear = document.material("glass", glass(1.5, 0.5));
    let centre = DVec3::new(-0.55, 0.24 + GAP, -0.85);
    document.mesh("ball", clear, &Mesh::default().sphere(centre, 0.24, 80, 40));
    let brass = document.material("ring", metal([0.95, 0.87, 0.68], 0.02));
    let base = DVec3::new(0.45, GAP, -0.7);
    document.mesh("ring", brass, &Mesh::default().ring(base, 0.3, 0.308, 0.14, 192, 2));
}

/// Adds the corner with the weak light.
fn add_corner(document: &mut Document) {
    let grey = document.material("screen", lambert([0.25, 0.25, 0.26]));
    let wall = Mesh::default().block(DVec3::new(1.36, GAP, -2.0), DVec3::new(1.38, 1.7, -0.45));
    document.mesh("screen", grey, &wall);
    let weak = document.material("weak lamp", emitter([0.75, 0.85, 1.0], 500.0));
    let (light, target) = (DVec3::new(1.8, 1.5, -1.95), DVec3::new(1.8, 0.0, -0.95));
    let facing = (target - light).normalize();
    let panel = Mesh::default().panel(light, 0.04 * DVec3::X, 0.04 * facing.cross(DVec3::X));
    document.mesh("weak lamp", weak, &panel);
    let steel = document.material("steel ring", metal([0.9, 0.9, 0.92], 0.0));
    let base = DVec3::new(1.8, GAP, -0.95);
    document.mesh("resting ring", steel, &Mesh::default().ring(base, 0.26, 0.268, 0.2, 192, 2));
}
