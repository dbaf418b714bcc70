//! A prism in a narrow beam and a ball under a small lamp, of dispersive glass.

use glam::{DVec2, DVec3};
use serde_json::{Value, json};
use std::f64::consts::TAU;

use crate::gltf::{Document, emitter, glass, lambert};
use crate::mesh::Mesh;

/// Index of refraction of green light.
const IOR: f64 = 1.6;
/// 20 over the Abbe number of 10: that of rutile, twice as dispersive as any glass.
const DISPERSION: f64 = 2.0;
/// Axis of the prism, along z, in the x-y plane (m).
const AXIS: DVec2 = DVec2::new(-0.5, 0.8);
/// Distance of its edges from the axis (m).
const RADIUS: f64 = 0.22;
/// Half its length (m).
const HALF_LENGTH: f64 = 0.25;
/// Centre of the ball, whose focus lies above the floor (m).
const BALL: DVec3 = DVec3::new(0.85, 0.47, 0.1);
/// Rotation from the upright position (rad), so that the beam leaves downwards.
const TURN: f64 = -0.6;

/// Glass of this dispersion.
fn flint(ior: f64, thickness: f64) -> Value {
    let mut material = glass(ior, thickness);
    material["extensions"]["KHR_materials_dispersion"] = json!({ "dispersion": DISPERSION });
    material
}

/// A prism of three equal sides.
fn prism() -> Mesh {
    let edge = |index: usize| AXIS + RADIUS * DVec2::from_angle(0.25 * TAU + TURN + index as f64 * TAU / 3.0);
    let (front, back) = (HALF_LENGTH, -HALF_LENGTH);
    let sides = (0..3).fold(Mesh::default(), |mesh, index| {
        let (a, b) = (edge(index), edge(index + 1));
        mesh.quad([a.extend(front), a.extend(back), b.extend(back), b.extend(front)])
    });
    let [a, b, c] = [0, 1, 2].map(edge);
    sides.face([a, b, c].map(|edge| edge.extend(front))).face([c, b, a].map(|edge| edge.extend(back)))
}

/// Direction of a beam that passes the prism at minimum deviation.
fn beam() -> DVec2 {
    let inside = TAU / 12.0;
    DVec2::from_angle((IOR * inside.sin()).asin() - inside + TURN)
}

/// Builds the scene.
pub fn build() -> Document {
    let mut document = Document::default();
    let white = document.material("white", lambert([0.75, 0.75, 0.75]));
    let glass = document.material("flint", flint(IOR, RADIUS));
    let light = document.material("lamp", emitter([1.0, 1.0, 1.0], 4000.0));
    let dim = document.material("dim", emitter([0.9, 0.95, 1.0], 0.05));

    document.mesh("floor", white, &Mesh::default().panel(DVec3::ZERO, 3.0 * DVec3::Z, 3.0 * DVec3::X));
    let wall = Mesh::default().panel(DVec3::new(0.0, 1.5, -1.2), 3.0 * DVec3::X, 1.5 * DVec3::Y);
    document.mesh("wall", white, &wall);
    document.mesh("prism", glass, &prism());
    let ball = Mesh::default().sphere(BALL, 0.25, 96, 48);
    document.mesh("ball", glass, &ball);

    // The beam enters through the side that faces up and left.
    let entrance = AXIS + 0.5 * RADIUS * DVec2::from_angle(5.0 * TAU / 12.0 + TURN);
    let from = (entrance - 1.8 * beam()).extend(0.0);
    document.spot("beam", from, entrance.extend(0.0), [1.0; 3], 100.0, [0.026, 0.028]);
    // A dim light makes the room visible.
    let above = Mesh::default().panel(DVec3::new(0.0, 2.9, 0.3), DVec3::X, DVec3::Z);
    document.mesh("dim lamp", dim, &above);
    // The lamp faces the ball.
    let down = DVec3::new(-0.3, -1.0, 0.1).normalize();
    let (right, up) = (DVec3::Z.cross(down).normalize(), down.cross(DVec3::Z.cross(down)).normalize());
    let position = BALL - 2.2 * down;
    document.mesh("lamp", light, &Mesh::default().panel(position, 0.02 * right, 0.02 * up));

    document.camera("main", DVec3::new(0.2, 1.3, 2.3), DVec3::new(0.2, 0.35, 0.0), 0.6, 16.0 / 9.0);
    document
}
