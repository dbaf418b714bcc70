//! A Cornell-like box with a mirror ball and a glass ball, in any number of triangles. It measures the speed of tracers, and how
//! the speed falls with the size of scenes.

use glam::DVec3;

use crate::gltf::{Document, emitter, glass, lambert, metal};
use crate::mesh::Mesh;

/// Half the box's side (m); the floor is at height 0.
const HALF: f64 = 1.0;
/// Radius of the balls (m).
const BALL_RADIUS: f64 = 0.36;
/// Gap between a ball and the floor (m).
const GAP: f64 = 0.001;
/// Half the light's side (m).
const LIGHT_HALF_SIDE: f64 = 0.25;
/// Radiance of the light (W m^-2 sr^-1).
const LIGHT_RADIANCE: f64 = 12.0;

/// Subdivision of the surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Detail {
    /// Number of squares along a wall's side.
    walls: u32,
    /// Number of rows of a ball; it has twice as many segments.
    balls: u32,
}

impl Detail {
    /// Walls of two triangles and smooth balls: 8 thousand triangles.
    pub const DEFAULT: Detail = Detail { walls: 1, balls: 32 };

    /// Detail with about this number of triangles, half in the five walls and half in the two balls.
    pub fn with_triangles(triangles: u32) -> Detail {
        let half = f64::from(triangles) / 2.0;
        // A square of a wall has two triangles, a ball 4 rows².
        Detail { walls: (half / 10.0).sqrt().round() as u32, balls: (half / 8.0).sqrt().round() as u32 }
    }
}

/// Builds the box. All details look equal, but for the polygonal outlines of the balls.
pub fn build(detail: Detail) -> Document {
    let mut document = Document::default();
    let centre = DVec3::new(0.0, HALF, 0.0);
    // Name, albedo, facing direction. The front is open.
    let walls = [
        ("floor", [0.73, 0.73, 0.73], DVec3::Y, DVec3::X),
        ("ceiling", [0.73, 0.73, 0.73], DVec3::NEG_Y, DVec3::X),
        ("back wall", [0.73, 0.73, 0.73], DVec3::Z, DVec3::X),
        ("left wall", [0.63, 0.06, 0.05], DVec3::X, DVec3::Y),
        ("right wall", [0.14, 0.45, 0.09], DVec3::NEG_X, DVec3::Y),
    ];
    for (name, albedo, facing, right) in walls {
        let material = document.material(name, lambert(albedo));
        let (right, up) = (HALF * right, HALF * facing.cross(right));
        document.mesh(name, material, &Mesh::default().grid(centre - HALF * facing, right, up, detail.walls));
    }

    let balls = [
        ("mirror ball", metal([0.95, 0.95, 0.95], 0.0), DVec3::new(-0.45, 0.0, -0.4)),
        ("glass ball", glass(1.5, 2.0 * BALL_RADIUS), DVec3::new(0.45, 0.0, 0.2)),
    ];
    for (name, look, base) in balls {
        let material = document.material(name, look);
        let centre = base + (BALL_RADIUS + GAP) * DVec3::Y;
        let ball = Mesh::default().sphere(centre, BALL_RADIUS, 2 * detail.balls, detail.balls);
        document.mesh(name, material, &ball);
    }

    let light = document.material("lamp", emitter([1.0, 0.9, 0.75], LIGHT_RADIANCE));
    let above = DVec3::new(0.0, 2.0 * HALF - 0.005, 0.0);
    document.mesh(
        "lamp",
        light,
        &Mesh::default().panel(above, LIGHT_HALF_SIDE * DVec3::X, LIGHT_HALF_SIDE * DVec3::Z),
    );

    document.camera("main", centre.with_z(4.6), centre, 32_f64.to_radians(), 16.0 / 9.0);
    document
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamp_faces_down() {
        assert!(DVec3::X.cross(DVec3::Z).y < 0.0);
    }

    #[test]
    fn number_of_triangles_is_met_within_12_percent() {
        for triangles in [1_000, 10_000, 100_000, 1_000_000] {
            let Detail { walls, balls } = Detail::with_triangles(triangles);
            // A row at each pole has one triangle a segment instead of two.
            let count = 10 * walls.pow(2) + 2 * (4 * balls.pow(2) - 4 * balls);
            assert!((f64::from(count) / f64::from(triangles) - 1.0).abs() < 0.12, "{count} for {triangles}");
        }
    }
}
