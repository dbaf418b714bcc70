//! Solids of revolution from an outline.
//!
//! An outline is a chain of points (distance from the axis, height) (m) around one half of the solid's section. It runs down the
//! outside, inwards at the bottom, up a hollow, and outwards on a rim. Its pieces are smooth curves that meet in edges. A point
//! of distance zero lies on the axis, and the next piece may start elsewhere on the axis.

use glam::{DVec2, DVec3};

use crate::mesh::Mesh;

/// A smooth part of an outline.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Points on the curve (m).
    points: Vec<DVec2>,
    /// Number of rows of triangles between two points.
    rows: u32,
}

/// A straight piece with one row.
pub fn line(from: [f64; 2], to: [f64; 2]) -> Piece {
    curve(&[from, to], 1)
}

/// A curve through points (Catmull-Rom), with this number of rows between two points.
pub fn curve(points: &[[f64; 2]], rows: u32) -> Piece {
    Piece { points: points.iter().copied().map(DVec2::from_array).collect(), rows }
}

/// A quarter of an ellipse for rounded edges. It starts along the axis and ends across it, or the reverse.
pub fn round(from: [f64; 2], to: [f64; 2], leaves_along_axis: bool, rows: u32) -> Piece {
    let (from, to) = (DVec2::from_array(from), DVec2::from_array(to));
    let points = (0..=rows).map(|row| {
        if row == 0 || row == rows {
            return if row == 0 { from } else { to };
        }
        let (sin, cos) = (std::f64::consts::FRAC_PI_2 * f64::from(row) / f64::from(rows)).sin_cos();
        let share = if leaves_along_axis { DVec2::new(1.0 - cos, sin) } else { DVec2::new(sin, 1.0 - cos) };
        from + share * (to - from)
    });
    Piece { points: points.collect(), rows: 1 }
}

impl Piece {
    /// Point and outward normal at a row.
    fn at(&self, row: u32) -> (DVec2, DVec2) {
        let last = self.points.len() - 1;
        let span = ((row / self.rows) as usize).min(last - 1);
        let share = f64::from(row) / f64::from(self.rows) - span as f64;
        let (a, b) = (self.points[span], self.points[span + 1]);
        let slope = |k: usize| match k {
            0 => self.end_slope(self.points[0], self.points[1], self.points.get(2)),
            k if k == last => {
                let before = last.checked_sub(2).map(|k| &self.points[k]);
                -self.end_slope(self.points[last], self.points[last - 1], before)
            }
            k => 0.5 * (self.points[k + 1] - self.points[k - 1]),
        };
        let (at_a, at_b) = (slope(span), slope(span + 1));
        // Cubic Hermite. The points are met exactly, so that pieces close without a gap.
        let (s, s2, s3) = (share, share * share, share * share * share);
        let point = match share {
            0.0 => a,
            1.0 => b,
            _ => {
                a * (2.0 * s3 - 3.0 * s2 + 1.0)
                    + at_a * (s3 - 2.0 * s2 + s)
                    + b * (3.0 * s2 - 2.0 * s3)
                    + at_b * (s3 - s2)
            }
        };
        let tangent =
            (a - b) * (6.0 * s2 - 6.0 * s) + at_a * (3.0 * s2 - 4.0 * s + 1.0) + at_b * (3.0 * s2 - 2.0 * s);
        let normal = DVec2::new(-tangent.y, tangent.x);
        // Make the surface smooth across the axis.
        let on_axis = point.x == 0.0 && self.points.len() > 2;
        (point, if on_axis { DVec2::new(0.0, normal.y) } else { normal })
    }

    /// Slope at an end, with constant curvature in the last span.
    fn end_slope(&self, end: DVec2, next: DVec2, second: Option<&DVec2>) -> DVec2 {
        second.map_or(next - end, |second| {
            let slope = 2.0 * next - 1.5 * end - 0.5 * *second;
            // A curve that ends on the axis crosses it horizontally.
            if end.x == 0.0 { DVec2::new(slope.x, 0.0) } else { slope }
        })
    }

    fn row_count(&self) -> u32 {
        (self.points.len() as u32 - 1) * self.rows
    }
}

/// Outline of a liquid in a hollow up to a level (m). The liquid overlaps the wall by `depth` (m), so that no air lies between.
/// The hollow starts on the axis, runs upwards and has no sharp edge.
pub fn filling(hollow: &[Piece], level: f64, depth: f64) -> Vec<Piece> {
    let mut wall: Vec<(DVec2, DVec2)> = Vec::new();
    for piece in hollow {
        for row in 0..=piece.row_count() {
            let (point, normal) = piece.at(row);
            match wall.last_mut() {
                Some(last) if last.0 == point => last.1 += normal.normalize(),
                _ => wall.push((point, normal.normalize())),
            }
        }
    }
    let moved: Vec<DVec2> = wall.iter().map(|(point, normal)| point - depth * normal.normalize()).collect();
    let above = moved.iter().position(|point| point.y > level).expect("a level below the rim");
    let (below, above) = (moved[above - 1], moved[above]);
    let share = (level - below.y) / (above.y - below.y);
    let shore = DVec2::new(below.x + share * (above.x - below.x), level);
    let mut points: Vec<DVec2> = moved.into_iter().take_while(|point| point.y <= level).collect();
    points.push(shore);
    points.reverse();
    vec![line([0.0, level], shore.to_array()), Piece { points, rows: 1 }]
}

/// Revolves an outline about the y axis through the origin.
pub fn lathe(segments: u32, pieces: &[Piece]) -> Mesh {
    lathe_at(Mesh::default(), DVec3::ZERO, segments, pieces)
}

/// Adds the solid of revolution of an outline, at a position (m).
pub fn lathe_at(mesh: Mesh, base: DVec3, segments: u32, pieces: &[Piece]) -> Mesh {
    pieces
        .iter()
        .fold(mesh, |mesh, piece| mesh.revolve(base, segments, piece.row_count(), |row| piece.at(row as u32)))
}

#[cfg(test)]
pub mod tests {
    use std::collections::HashMap;

    use glam::Vec3;

    use super::*;

    /// Asserts that every edge has its opposite, that fronts face outwards, and that vertex normals agree with faces.
    pub fn assert_solid(name: &str, mesh: &Mesh) {
        let corner = |id: u32| mesh.positions[id as usize];
        let key = |id: u32| corner(id).to_array().map(|x| (x + 0.0).to_bits());
        let mut edges: HashMap<_, i32> = HashMap::new();
        let mut volume = 0.0;
        for ids in mesh.indices.chunks(3) {
            let [a, b, c] = [corner(ids[0]), corner(ids[1]), corner(ids[2])];
            volume += a.as_dvec3().dot(b.as_dvec3().cross(c.as_dvec3())) / 6.0;
            let face = (b - a).cross(c - a).normalize();
            for k in 0..3 {
                let (from, to) = (key(ids[k]), key(ids[(k + 1) % 3]));
                *edges.entry((from, to)).or_default() += 1;
                *edges.entry((to, from)).or_default() -= 1;
                let cos = mesh.normals[ids[k] as usize].dot(face);
                assert!(cos > 0.7, "{name}: normal and face have a cosine of {cos} at {}", corner(ids[k]));
            }
        }
        assert!(edges.values().all(|&count| count == 0), "{name} is not closed");
        assert!(volume > 0.0, "{name} is inside out");
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        assert_faces_alternate(name, mesh);
    }

    /// Asserts that a line meets fronts and backs alternately, so that inner and outer walls do not cross.
    fn assert_faces_alternate(name: &str, mesh: &Mesh) {
        let (lower, upper) = mesh
            .positions
            .iter()
            .fold((Vec3::MAX, Vec3::MIN), |(lower, upper), p| (lower.min(*p), upper.max(*p)));
        for step in 0..200_u8 {
            // Off the axis, where triangles meet.
            let share = (f32::from(step) + 0.371) / 200.0;
            let (y, z) = (lower.y + share * (upper.y - lower.y), 0.000_137);
            let mut hits: Vec<(f32, f32)> = Vec::new();
            for ids in mesh.indices.chunks(3) {
                let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[ids[k] as usize] - Vec3::new(0.0, y, z));
                let area = |p: Vec3, q: Vec3| p.y * q.z - p.z * q.y;
                let (u, v, w) = (area(b, c), area(c, a), area(a, b));
                if (u > 0.0 && v > 0.0 && w > 0.0) || (u < 0.0 && v < 0.0 && w < 0.0) {
                    hits.push(((u * a.x + v * b.x + w * c.x) / (u + v + w), (u + v + w).signum()));
                }
            }
            hits.sort_by(|a, b| a.0.total_cmp(&b.0));
            let sides: Vec<f32> = hits.iter().map(|hit| hit.1).collect();
            let expected: Vec<f32> = (0..sides.len()).map(|k| if k % 2 == 0 { -1.0 } else { 1.0 }).collect();
            assert_eq!(sides, expected, "{name} at height {y}");
        }
    }

    /// A beaker: outer radius 4 cm, wall 1 cm, 10 cm high, bottom 2 cm.
    fn beaker() -> ([Piece; 3], [Piece; 4]) {
        let outside = [
            line([0.04, 0.1], [0.04, 0.01]),
            round([0.04, 0.01], [0.03, 0.0], true, 8),
            line([0.03, 0.0], [0.0, 0.0]),
        ];
        let inside = [
            line([0.0, 0.02], [0.02, 0.02]),
            round([0.02, 0.02], [0.03, 0.03], false, 8),
            line([0.03, 0.03], [0.03, 0.1]),
            curve(&[[0.03, 0.1], [0.035, 0.103], [0.04, 0.1]], 4),
        ];
        (outside, inside)
    }

    #[test]
    fn beaker_is_a_solid_with_a_hollow() {
        let (outside, inside) = beaker();
        assert_solid("beaker", &lathe(64, &[&outside[..], &inside].concat()));
        let upside_down: Vec<Piece> = outside
            .iter()
            .chain(&inside)
            .cloned()
            .map(|mut piece| {
                piece.points.reverse();
                piece
            })
            .rev()
            .collect();
        let wrong = std::panic::catch_unwind(|| assert_solid("inside out", &lathe(64, &upside_down)));
        assert!(wrong.is_err());
        let open = std::panic::catch_unwind(|| assert_solid("open", &lathe(64, &outside)));
        assert!(open.is_err());
        let mut deep = inside.clone();
        deep[0] = line([0.0, -0.01], [0.02, 0.02]);
        let crossing = std::panic::catch_unwind(|| {
            assert_solid("crossing", &lathe(64, &[&outside[..], &deep].concat()));
        });
        assert!(crossing.is_err());
    }

    #[test]
    fn filling_overlaps_the_wall() {
        let (_, inside) = beaker();
        let liquid = lathe(64, &filling(&inside[..3], 0.07, 0.001));
        assert_solid("filling", &liquid);
        let top = liquid.positions.iter().fold(0.0_f32, |top, p| top.max(p.y));
        let widest = liquid.positions.iter().fold(0.0_f32, |widest, p| widest.max(p.x.hypot(p.z)));
        let lowest = liquid.positions.iter().fold(1.0_f32, |lowest, p| lowest.min(p.y));
        for (found, expected) in [(top, 0.07), (widest, 0.031), (lowest, 0.019)] {
            // Precision of an f32 of a few centimetres.
            assert!((found - expected).abs() < 1e-8, "{found} {expected}");
        }
    }
}
