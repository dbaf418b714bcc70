//! Turned objects of metal and wood: shakers, a bucket, a tap, a tray, stools, tables, rails.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DQuat, DVec3};

use super::{GAP, Palette};
use crate::gltf::{Document, Shape};
use crate::lathe::{Piece, curve, lathe, lathe_at, line, round};
use crate::mesh::Mesh;

/// Number of segments around the axis.
pub const SEGMENTS: u32 = 64;

/// The shapes.
pub struct Turned {
    /// A polished shaker.
    pub shaker: Shape,
    /// An open bucket of polished steel.
    pub bucket: Shape,
    /// A column with a ball on top.
    pub tap: Shape,
    /// A round tray with a brim.
    pub tray: Shape,
    /// A stool at the counter.
    pub stool: Shape,
    /// A round table, [`TABLE_TOP`] high.
    pub table: Shape,
}

/// Height of a table's top (m).
pub const TABLE_TOP: f64 = 0.74;
/// Height of a tray's upper face above its base (m).
pub const TRAY: f64 = 0.003;

impl Turned {
    /// Adds all shapes.
    pub fn new(document: &mut Document, palette: &Palette) -> Self {
        let mut one = |name: &str, material, outline: &[Piece]| {
            document.shape(name, &[(material, &lathe(SEGMENTS, outline))])
        };
        let shaker = one("shaker", palette.steel, &shaker());
        let bucket = one("bucket", palette.steel, &bucket());
        let tap = one("tap", palette.brass, &tap());
        let tray = one("tray", palette.steel, &tray());
        let seat = lathe_at(Mesh::default(), DVec3::Y * 0.74, SEGMENTS, &cushion(0.17, 0.05));
        let leg = lathe(SEGMENTS, &pedestal(0.22, 0.024, 0.74 - GAP));
        let stool = document.shape("stool", &[(palette.leather, &seat), (palette.steel, &leg)]);
        let top = lathe_at(Mesh::default(), DVec3::Y * (TABLE_TOP - 0.03), SEGMENTS, &cushion(0.38, 0.03));
        let foot = lathe(SEGMENTS, &pedestal(0.24, 0.035, TABLE_TOP - 0.03 - GAP));
        let table = document.shape("table", &[(palette.wood, &top), (palette.iron, &foot)]);
        Turned { shaker, bucket, tap, tray, stool, table }
    }
}

/// Adds a brass rod along x: start (m), length (m) and radius (m).
pub fn rail(document: &mut Document, palette: &Palette, name: &str, from: DVec3, length: f64, radius: f64) {
    let end = radius * 0.3;
    let outline = [
        line([0.0, length], [radius - end, length]),
        round([radius - end, length], [radius, length - end], false, 4),
        line([radius, length - end], [radius, end]),
        round([radius, end], [radius - end, 0.0], true, 4),
        line([radius - end, 0.0], [0.0, 0.0]),
    ];
    let shape = document.shape(name, &[(palette.brass, &lathe(SEGMENTS, &outline))]);
    let node = document.node(name, shape);
    document.place(node, from);
    // Turn the axis from y to x.
    document.turn(node, DQuat::from_xyzw(0.0, 0.0, -FRAC_1_SQRT_2, FRAC_1_SQRT_2));
}

fn shaker() -> Vec<Piece> {
    let body = [
        [0.0, 0.240],
        [0.012, 0.238],
        [0.018, 0.228],
        [0.020, 0.205],
        [0.034, 0.180],
        [0.044, 0.160],
        [0.043, 0.120],
        [0.033, 0.004],
    ];
    vec![curve(&body, 8), round([0.033, 0.004], [0.029, 0.0], true, 4), line([0.029, 0.0], [0.0, 0.0])]
}

fn bucket() -> Vec<Piece> {
    vec![
        curve(&[[0.100, 0.190], [0.094, 0.120], [0.082, 0.050], [0.070, 0.010]], 12),
        round([0.070, 0.010], [0.060, 0.0], true, 6),
        line([0.060, 0.0], [0.0, 0.0]),
        line([0.0, 0.002], [0.060, 0.002]),
        curve(&[[0.060, 0.002], [0.068, 0.010], [0.080, 0.050], [0.092, 0.120], [0.098, 0.190]], 10),
        curve(&[[0.098, 0.190], [0.099, 0.1908], [0.100, 0.190]], 2),
    ]
}

fn tap() -> Vec<Piece> {
    let column = [
        [0.0, 0.430],
        [0.030, 0.414],
        [0.042, 0.385],
        [0.030, 0.356],
        [0.020, 0.335],
        [0.026, 0.200],
        [0.030, 0.060],
        [0.045, 0.020],
        [0.070, 0.004],
    ];
    vec![curve(&column, 10), line([0.070, 0.004], [0.070, 0.0]), line([0.070, 0.0], [0.0, 0.0])]
}

fn tray() -> Vec<Piece> {
    vec![
        line([0.0, TRAY], [0.160, TRAY]),
        curve(&[[0.160, TRAY], [0.172, 0.008], [0.176, 0.020]], 6),
        curve(&[[0.176, 0.020], [0.177, 0.0206], [0.178, 0.020]], 2),
        curve(&[[0.178, 0.020], [0.174, 0.006], [0.163, 0.0]], 6),
        line([0.163, 0.0], [0.0, 0.0]),
    ]
}

/// Outline of a disc with a rounded upper edge, on y = 0.
fn cushion(radius: f64, height: f64) -> Vec<Piece> {
    let edge = 0.4 * height;
    vec![
        line([0.0, height], [radius - edge, height]),
        round([radius - edge, height], [radius, height - edge], false, 8),
        line([radius, height - edge], [radius, 0.0]),
        line([radius, 0.0], [0.0, 0.0]),
    ]
}

/// Outline of a column on a flat foot.
fn pedestal(foot: f64, column: f64, height: f64) -> Vec<Piece> {
    vec![
        line([0.0, height], [column, height]),
        line([column, height], [column, 0.08]),
        curve(&[[column, 0.08], [column + 0.012, 0.035], [0.5 * foot, 0.018], [foot, 0.010]], 8),
        line([foot, 0.010], [foot, GAP]),
        line([foot, GAP], [0.0, GAP]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lathe::tests::assert_solid;

    #[test]
    fn turned_objects_are_solids() {
        let things = [
            ("shaker", shaker()),
            ("bucket", bucket()),
            ("tap", tap()),
            ("tray", tray()),
            ("cushion", cushion(0.17, 0.05)),
            ("pedestal", pedestal(0.22, 0.024, 0.7)),
        ];
        for (name, outline) in things {
            assert_solid(name, &lathe(SEGMENTS, &outline));
        }
    }
}
