//! `uplight`: a lamp close below a ceiling lights a small bright spot, and a glass ball focuses the spot's light.

use glam::DVec3;

use crate::gltf::{Document, emitter, glass, lambert};
use crate::mesh::Mesh;

/// Height of the ceiling (m).
const CEILING: f64 = 2.4;
/// Distance of the light from the ceiling (m).
const GAP: f64 = 0.08;
/// Half the light's side (m).
const HALF_SIDE: f64 = 0.04;
/// Radiance of the light (W m^-2 sr^-1).
const RADIANCE: f64 = 4000.0;
/// Radius of the ball (m).
const BALL_RADIUS: f64 = 0.3;

/// Builds the scene.
pub fn build() -> Document {
    let mut document = Document::default();
    let white = document.material("white", lambert([0.8, 0.8, 0.8]));
    let floor = document.material("floor", lambert([0.6, 0.55, 0.5]));
    let clear = document.material("glass", glass(1.5, 2.0 * BALL_RADIUS));
    let light = document.material("lamp", emitter([1.0, 0.9, 0.75], RADIANCE));

    document.mesh("floor", floor, &Mesh::default().panel(DVec3::ZERO, 2.5 * DVec3::Z, 2.5 * DVec3::X));
    let ceiling = Mesh::default().panel(CEILING * DVec3::Y, 2.5 * DVec3::X, 2.5 * DVec3::Z);
    document.mesh("ceiling", white, &ceiling);
    let centre = DVec3::new(0.0, 0.5, 0.0);
    document.mesh("ball", clear, &Mesh::default().sphere(centre, BALL_RADIUS, 96, 48));

    // The lamp faces up: only the ceiling receives its direct light.
    let position = DVec3::new(0.4, CEILING - GAP, 0.0);
    document.mesh(
        "lamp",
        light,
        &Mesh::default().panel(position, HALF_SIDE * DVec3::Z, HALF_SIDE * DVec3::X),
    );

    document.camera("main", DVec3::new(0.0, 1.5, 2.2), DVec3::new(-0.1, 0.2, 0.0), 0.7, 16.0 / 9.0);
    document
}
