//! Meshes in metres, computed in f64, so that differences of a platform's sine do not change the f32 that is written.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, Vec2, Vec3};

/// Triangles with vertex normals; counter-clockwise seen from the front.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertices (m).
    pub positions: Vec<Vec3>,
    /// Unit normals of the vertices.
    pub normals: Vec<Vec3>,
    /// Texture coordinates of the vertices; empty without textures.
    pub uvs: Vec<Vec2>,
    /// Three vertices a triangle.
    pub indices: Vec<u32>,
}

impl Mesh {
    fn vertex(&mut self, position: DVec3, normal: DVec3) -> u32 {
        self.positions.push(position.as_vec3());
        self.normals.push(normal.normalize().as_vec3());
        self.positions.len() as u32 - 1
    }

    /// Adds a flat quadrilateral with corners counter-clockwise seen from the front.
    pub fn quad(mut self, corners: [DVec3; 4]) -> Self {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let [a, b, c, d] = corners.map(|corner| self.vertex(corner, normal));
        self.indices.extend([a, b, c, a, c, d]);
        self
    }

    /// Adds a flat triangle with corners counter-clockwise seen from the front.
    pub fn face(mut self, corners: [DVec3; 3]) -> Self {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let ids = corners.map(|corner| self.vertex(corner, normal));
        self.indices.extend(ids);
        self
    }

    /// Adds a flat parallelogram around `centre`; its front faces along `right` x `up`.
    pub fn panel(self, centre: DVec3, right: DVec3, up: DVec3) -> Self {
        self.quad([centre - right - up, centre + right - up, centre + right + up, centre - right + up])
    }

    /// Adds a panel cut into `count` x `count` squares.
    pub fn grid(self, centre: DVec3, right: DVec3, up: DVec3, count: u32) -> Self {
        let at = |index: u32| (2.0 * f64::from(index) + 1.0) / f64::from(count) - 1.0;
        let scale = 1.0 / f64::from(count);
        (0..count.pow(2)).fold(self, |mesh, index| {
            let middle = centre + at(index % count) * right + at(index / count) * up;
            mesh.panel(middle, scale * right, scale * up)
        })
    }

    /// Adds a panel with an upright texture, repeated `repeats` times along each side.
    pub fn mapped_panel(mut self, centre: DVec3, right: DVec3, up: DVec3, repeats: f32) -> Self {
        self.uvs.extend([Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO].map(|uv| uv * repeats));
        self.panel(centre, right, up)
    }

    /// Adds an axis-aligned box.
    pub fn block(mut self, min: DVec3, max: DVec3) -> Self {
        let centre = 0.5 * (min + max);
        let half = 0.5 * (max - min);
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let unit = |axis: usize| DVec3::AXES[axis % 3] * half[axis % 3];
                self = self.panel(centre + sign * unit(axis), sign * unit(axis + 1), unit(axis + 2));
            }
        }
        self
    }

    /// Adds a sphere with smooth normals and poles on the y axis.
    pub fn sphere(self, centre: DVec3, radius: f64, segments: u32, rows: u32) -> Self {
        let normal = |row: f64| {
            let (sin, cos) = (PI * row / f64::from(rows)).sin_cos();
            // Use exact poles: a sine of pi that is not zero would make slivers.
            if row == 0.0 || row == f64::from(rows) { DVec2::new(0.0, cos) } else { DVec2::new(sin, cos) }
        };
        self.revolve(centre, segments, rows, |row| (radius * normal(row), normal(row)))
    }

    /// Adds a solid ring around the y axis, standing on `base`; walls have smooth normals.
    pub fn ring(self, base: DVec3, inner: f64, outer: f64, height: f64, segments: u32, rows: u32) -> Self {
        let height_at = move |row: f64| height * row / f64::from(rows);
        self.revolve(base, segments, rows, |row| (DVec2::new(inner, height_at(row)), DVec2::NEG_X))
            .revolve(base, segments, 1, |row| (DVec2::new(inner + (outer - inner) * row, height), DVec2::Y))
            .revolve(base, segments, rows, |row| (DVec2::new(outer, height - height_at(row)), DVec2::X))
            .revolve(base, segments, 1, |row| (DVec2::new(outer + (inner - outer) * row, 0.0), DVec2::NEG_Y))
    }

    /// Adds a profile revolved about the y axis through `centre`. The profile gives the point (distance from the axis, height)
    /// and the normal at a row. Seen from the front, rows run down and segments to the right.
    pub fn revolve(
        mut self,
        centre: DVec3,
        segments: u32,
        rows: u32,
        profile: impl Fn(f64) -> (DVec2, DVec2),
    ) -> Self {
        let first = self.positions.len() as u32;
        for row in 0..=rows {
            let (point, normal) = profile(f64::from(row));
            for segment in 0..=segments {
                // The last column repeats the first exactly.
                let (sin, cos) = (TAU * f64::from(segment % segments) / f64::from(segments)).sin_cos();
                let turn = |p: DVec2| DVec3::new(p.x * cos, p.y, -p.x * sin);
                self.vertex(centre + turn(point), turn(normal));
            }
        }
        for row in 0..rows {
            for segment in 0..segments {
                let a = first + row * (segments + 1) + segment;
                let (b, c, d) = (a + segments + 1, a + segments + 2, a + 1);
                self.triangle([a, b, c]);
                self.triangle([a, c, d]);
            }
        }
        self
    }

    /// Adds a triangle, unless two of its corners coincide, as at a pole.
    fn triangle(&mut self, ids: [u32; 3]) {
        let [a, b, c] = ids.map(|id| self.positions[id as usize]);
        if a != b && b != c && c != a {
            self.indices.extend(ids);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Enclosed volume (m^3) by the divergence theorem; negative if fronts face inwards.
    fn volume(mesh: &Mesh) -> f64 {
        mesh.indices
            .chunks(3)
            .map(|ids| {
                let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[ids[k] as usize].as_dvec3());
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    fn check_normals(mesh: &Mesh) {
        for ids in mesh.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[ids[k] as usize]);
            let face = (b - a).cross(c - a).normalize();
            assert!(ids.iter().all(|&id| mesh.normals[id as usize].dot(face) > 0.9));
        }
    }

    #[test]
    fn solids_are_closed_and_face_outwards() {
        let at = DVec3::new(0.3, 0.2, -0.1);
        let sphere = Mesh::default().sphere(at, 0.5, 64, 32);
        let ring = Mesh::default().ring(at, 0.4, 0.5, 0.3, 128, 4);
        let block = Mesh::default().block(at, at + DVec3::new(1.0, 2.0, 3.0));
        let cases =
            [(&sphere, PI / 6.0, 0.01), (&ring, PI * 0.3 * (0.25 - 0.16), 0.001), (&block, 6.0, 1e-6)];
        for (mesh, expected, tolerance) in cases {
            assert!((volume(mesh) - expected).abs() < tolerance, "{} {expected}", volume(mesh));
            check_normals(mesh);
        }
    }
}
