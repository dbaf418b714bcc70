//! The room of `mirror-room`, `glossy-room` and `plain-room`.
//!
//! The camera looks down over a screen into a mirror on the back wall. Between screen and mirror stands the table, which the
//! screen hides: a ray over the screen meets the table only after the mirror. Other surfaces that the camera sees directly are
//! dark and face away from the mirror. A shade keeps the lamp's direct light off the mirror. Caustic light thus needs two bounces
//! to be visible outside of the mirror.

use glam::DVec3;

use crate::gltf::{Document, emitter, glass, lambert, metal};
use crate::mesh::Mesh;
use crate::walls;

/// Selects one of the three rooms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A perfect wall mirror.
    Mirror,
    /// A wall mirror of roughness 0.15.
    Glossy,
    /// Lambertian surfaces only.
    Plain,
}

/// Lower corner of the room (m).
const ROOM_MIN: DVec3 = DVec3::new(-2.2, 0.0, -2.0);
/// Upper corner of the room (m).
const ROOM_MAX: DVec3 = DVec3::new(2.2, 3.0, 2.0);
/// Lower left corner of the mirror, on its plane (m).
const MIRROR_MIN: DVec3 = DVec3::new(-1.3, 0.55, -1.98);
/// Upper right corner of the mirror (m).
const MIRROR_MAX: DVec3 = DVec3::new(1.3, 1.9, -1.98);
/// Height of the table's top (m).
const TABLE_TOP: f64 = 0.5;
/// Height of the screen (m).
const SCREEN_TOP: f64 = 1.37;
/// Position of the eye (m).
const EYE: DVec3 = DVec3::new(0.0, 2.65, 1.85);
/// Centre of the light (m).
const LIGHT_CENTRE: DVec3 = DVec3::new(1.75, 2.5, -1.7);
/// Half the light's side (m).
const LIGHT_HALF_SIDE: f64 = 0.06;
/// Radiance of the light (W m^-2 sr^-1).
const LIGHT_RADIANCE: f64 = 1500.0;
/// Radius of the ball (m).
const BALL_RADIUS: f64 = 0.18;
/// Gap between faces of touching objects (m).
const GAP: f64 = 0.001;

/// Builds the room.
pub fn build(kind: Kind) -> Document {
    let mut document = Document::default();
    add_walls(&mut document);
    add_mirror(&mut document, kind);
    add_light(&mut document);
    add_table(&mut document, kind);
    let pitch = 21.5_f64.to_radians();
    let target = EYE + DVec3::new(0.0, -pitch.sin(), -pitch.cos());
    document.camera("main", EYE, target, 25_f64.to_radians(), 16.0 / 9.0);
    document
}

fn add_walls(document: &mut Document) {
    let (centre, half) = (0.5 * (ROOM_MIN + ROOM_MAX), 0.5 * (ROOM_MAX - ROOM_MIN));
    // Name, albedo, facing direction
    let walls = [
        ("floor", [0.55, 0.52, 0.50], DVec3::Y),
        ("ceiling", [0.72, 0.72, 0.70], DVec3::NEG_Y),
        ("left wall", [0.62, 0.50, 0.45], DVec3::X),
        ("right wall", [0.48, 0.58, 0.62], DVec3::NEG_X),
        ("front wall", [0.60, 0.58, 0.52], DVec3::NEG_Z),
        ("back wall", [0.05, 0.05, 0.06], DVec3::Z),
    ];
    walls::add_walls(document, centre, half, walls);
}

fn add_mirror(document: &mut Document, kind: Kind) {
    let material = document.material(
        "mirror",
        match kind {
            Kind::Mirror => metal([0.96, 0.96, 0.96], 0.0),
            Kind::Glossy => metal([0.96, 0.96, 0.96], 0.15),
            Kind::Plain => lambert([0.55, 0.60, 0.65]),
        },
    );
    let (centre, half) = (0.5 * (MIRROR_MIN + MIRROR_MAX), 0.5 * (MIRROR_MAX - MIRROR_MIN));
    document.mesh("mirror", material, &Mesh::default().panel(centre, half.x * DVec3::X, half.y * DVec3::Y));

    // Four flat bars around the mirror, in its plane: no edge of theirs reflects its light.
    let frame = document.material("frame", lambert([0.08, 0.06, 0.04]));
    let bar = 0.06;
    let panel = |mesh: Mesh, x: [f64; 2], y: [f64; 2]| {
        let centre = DVec3::new(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]), MIRROR_MIN.z);
        mesh.panel(centre, 0.5 * (x[1] - x[0]) * DVec3::X, 0.5 * (y[1] - y[0]) * DVec3::Y)
    };
    let (left, right) = (MIRROR_MIN.x, MIRROR_MAX.x);
    let (bottom, top) = (MIRROR_MIN.y, MIRROR_MAX.y);
    let mut bars = panel(Mesh::default(), [left - bar, right + bar], [bottom - bar, bottom]);
    bars = panel(bars, [left - bar, right + bar], [top, top + bar]);
    bars = panel(bars, [left - bar, left], [bottom, top]);
    bars = panel(bars, [right, right + bar], [bottom, top]);
    document.mesh("frame", frame, &bars);
}

fn add_light(document: &mut Document) {
    let material = document.material("lamp", emitter([1.0, 0.93, 0.82], LIGHT_RADIANCE));
    // Face the centre of the table, level along z.
    let facing = (DVec3::new(0.0, TABLE_TOP, LIGHT_CENTRE.z) - LIGHT_CENTRE).normalize();
    let across = facing.cross(DVec3::Z);
    let panel = Mesh::default().panel(LIGHT_CENTRE, LIGHT_HALF_SIDE * DVec3::Z, LIGHT_HALF_SIDE * across);
    document.mesh("lamp", material, &panel);

    // The shade's far edge just touches the line from the lamp's far side to the mirror's far corner.
    let shade = document.material("shade", lambert([0.05, 0.05, 0.05]));
    let length = 0.6;
    let corner = DVec3::new(MIRROR_MIN.x, MIRROR_MIN.y, MIRROR_MIN.z);
    let source = LIGHT_CENTRE + LIGHT_HALF_SIDE * DVec3::Z;
    let slope = (corner.z - source.z) / (corner - LIGHT_CENTRE).dot(facing);
    let tip_z = source.z + slope * length;
    let base_z = LIGHT_CENTRE.z - LIGHT_HALF_SIDE - 0.02;
    let at =
        |along: f64, across_by: f64, z: f64| (LIGHT_CENTRE + along * facing + across_by * across).with_z(z);
    let corners = [
        at(-0.02, -0.15, base_z),
        at(-0.02, 0.15, base_z),
        at(length, 0.62, tip_z),
        at(length, -0.62, tip_z),
    ];
    document.mesh("shade", shade, &Mesh::default().quad(corners));
}

fn add_table(document: &mut Document, kind: Kind) {
    let table = document.material("table", lambert([0.42, 0.40, 0.36]));
    let (min, max) = (DVec3::new(-1.05, TABLE_TOP - 0.04, -1.8), DVec3::new(1.05, TABLE_TOP, -0.65));
    let mut mesh = Mesh::default().block(min, max);
    for x in [min.x + 0.05, max.x - 0.1] {
        for z in [min.z + 0.05, max.z - 0.1] {
            let foot = DVec3::new(x, GAP, z);
            mesh = mesh.block(foot, foot + DVec3::new(0.05, min.y - 2.0 * GAP, 0.05));
        }
    }
    document.mesh("table", table, &mesh);

    let (ball, ring) = match kind {
        Kind::Plain => (lambert([0.55, 0.62, 0.70]), lambert([0.75, 0.62, 0.42])),
        _ => (glass(1.5, 2.0 * BALL_RADIUS), metal([0.95, 0.87, 0.68], 0.02)),
    };
    let ball = document.material("ball", ball);
    let centre = DVec3::new(-0.3, TABLE_TOP + GAP + BALL_RADIUS, -1.15);
    document.mesh("ball", ball, &Mesh::default().sphere(centre, BALL_RADIUS, 96, 48));
    let ring = document.material("ring", ring);
    let base = DVec3::new(0.42, TABLE_TOP + GAP, -1.15);
    document.mesh("ring", ring, &Mesh::default().ring(base, 0.28, 0.288, 0.085, 256, 4));

    let screen = document.material("screen", lambert([0.05, 0.05, 0.06]));
    // A single panel: a thick screen would have an upper edge in the mirror's light.
    let (centre, half_height) = (DVec3::new(0.0, 0.5 * (GAP + SCREEN_TOP), -0.45), 0.5 * (SCREEN_TOP - GAP));
    let sheet = Mesh::default().panel(centre, 1.6 * DVec3::X, half_height * DVec3::Y);
    document.mesh("screen", screen, &sheet);
}
