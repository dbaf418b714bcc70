//! Lights: a small emitting disc under a shade, hung from the ceiling or aimed at the shelves.

use glam::{DQuat, DVec3};

use super::{GAP, Palette, metal};
use crate::gltf::{Document, Shape, emitter};
use crate::lathe::{Piece, curve, lathe, line};
use crate::mesh::Mesh;

/// Number of segments of a cord; few suffice, since it is black.
const CORD_SEGMENTS: u32 = 24;
/// Radius of an emitting disc (m).
const BULB: f64 = 0.03;
/// Number of corners of an emitting disc.
const CORNERS: u32 = 8;
/// Radiance of a light (W m^-2 sr^-1).
const RADIANCE: f64 = 1200.0;
/// Radiance of a spot light for the shelves (W m^-2 sr^-1).
const SPOT_RADIANCE: f64 = 2400.0;
/// Height of the ceiling (m).
const CEILING: f64 = super::ROOM.y;

/// Positions of the pendants above counter and tables: centres of the discs (m).
const PENDANTS: [[f64; 3]; 7] = [
    [-2.3, 2.02, 1.48],
    [-0.9, 2.02, 1.48],
    [0.5, 2.02, 1.48],
    [1.9, 2.02, 1.48],
    [-2.1, 1.75, 3.3],
    [-0.3, 1.75, 4.1],
    [1.6, 1.75, 3.9],
];
/// Positions and targets of the lights for the shelves (m).
const SPOTS: [[[f64; 3]; 2]; 4] = [
    [[-2.1, 2.85, 0.95], [-2.1, 1.35, 0.12]],
    [[-0.7, 2.85, 0.95], [-0.7, 1.35, 0.12]],
    [[0.7, 2.85, 0.95], [0.7, 1.35, 0.12]],
    [[2.0, 2.85, 0.95], [2.0, 1.35, 0.12]],
];

/// Adds all lights.
pub fn add(document: &mut Document, palette: &Palette) {
    let warm = document.material("lamp", emitter([1.0, 0.86, 0.66], RADIANCE));
    let white = document.material("spot", emitter([1.0, 0.94, 0.85], SPOT_RADIANCE));
    let disc = disc();
    let pendant = document.shape(
        "pendant",
        &[
            (warm, &disc),
            (palette.white, &lathe(metal::SEGMENTS, &lining())),
            (palette.enamel, &lathe(metal::SEGMENTS, &shade())),
        ],
    );
    let spot = document.shape("spot", &[(white, &disc), (palette.iron, &lathe(metal::SEGMENTS, &can()))]);
    for position in PENDANTS.map(DVec3::from_array) {
        put(document, "pendant", pendant, position, DVec3::NEG_Y);
        let top = position.y + 0.17;
        let cord = document.mesh("cord", palette.iron, &lathe(CORD_SEGMENTS, &cord(CEILING - top)));
        document.place(cord, position.with_y(top));
    }
    for [position, target] in SPOTS.map(|spot| spot.map(DVec3::from_array)) {
        put(document, "spot", spot, position, (target - position).normalize());
    }
}

/// Places a light, whose axis is its own -y, in a direction.
fn put(document: &mut Document, name: &str, light: Shape, position: DVec3, facing: DVec3) {
    let node = document.node(name, light);
    document.place(node, position);
    document.turn(node, DQuat::from_rotation_arc(DVec3::NEG_Y, facing));
}

/// A disc that faces down, with the fewest triangles for its corners.
fn disc() -> Mesh {
    let corner = |k: u32| {
        let (sin, cos) = (std::f64::consts::TAU * (f64::from(k) + 0.5) / f64::from(CORNERS)).sin_cos();
        DVec3::new(BULB * cos, 0.0, BULB * sin)
    };
    // Quadrilaterals across the disc: (0 1 6 7), (1 2 5 6), (2 3 4 5).
    (0..CORNERS / 2 - 1).fold(Mesh::default(), |mesh, k| {
        mesh.quad([corner(k), corner(k + 1), corner(CORNERS - 2 - k), corner(CORNERS - 1 - k)])
    })
}

/// Outline of the shade's white inside, a bell of 2 mm around the disc.
fn lining() -> Vec<Piece> {
    bell(0.0, 0.002)
}

/// Outline of the shade's outside.
fn shade() -> Vec<Piece> {
    bell(0.0025, 0.0045)
}

/// Outline of a bell, closed at the top, between two distances from its inner face (m).
fn bell(inner: f64, outer: f64) -> Vec<Piece> {
    let face = |by: f64| {
        [
            [0.0, 0.160 + by],
            [0.030 + by, 0.145 + by],
            [0.045 + by, 0.090],
            [0.080 + by, 0.030],
            [0.130 + by, -0.040],
        ]
    };
    let outside = face(outer);
    let mut inside = face(inner);
    inside.reverse();
    vec![curve(&outside, 6), line(outside[4], inside[0]), curve(&inside, 6)]
}

/// Outline of a can that is open at the bottom.
fn can() -> Vec<Piece> {
    let corners = [[0.0, 0.1], [0.045, 0.1], [0.045, -0.05], [0.042, -0.05], [0.042, 0.096], [0.0, 0.096]];
    corners.windows(2).map(|ends| line(ends[0], ends[1])).collect()
}

/// Outline of a cord of this length (m).
fn cord(length: f64) -> Vec<Piece> {
    let (radius, length) = (0.004, length - GAP);
    let corners = [[0.0, length], [radius, length], [radius, 0.0], [0.0, 0.0]];
    corners.windows(2).map(|ends| line(ends[0], ends[1])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lathe::tests::assert_solid;

    #[test]
    fn shades_are_solids() {
        let solids = [("lining", lining()), ("shade", shade()), ("can", can()), ("cord", cord(1.0))];
        for (name, outline) in solids {
            assert_solid(name, &lathe(metal::SEGMENTS, &outline));
        }
    }

    #[test]
    fn light_discs_face_down_and_are_flat() {
        let disc = disc();
        assert!(disc.normals.iter().all(|normal| normal.y == -1.0));
        assert_eq!(disc.indices.len(), 3 * (CORNERS as usize - 2));
    }
}
