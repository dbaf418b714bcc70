//! Spherical triangles: a triangle as a point sees it. Its solid angle is that of Van Oosterom and Strackee [1983, The solid
//! angle of a plane triangle]. Directions are uniform over it [Arvo 1995, Stratified sampling of spherical triangles]. The only
//! inverse function is that of the angle itself [Peters 2021, BRDF importance sampling for polygonal lights].

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::math::trig::{sin_cos_turns, turns};
use caustics_kernel_macros::shared;
use core::f32::consts::TAU;
use spirv_std::glam::Vec3;

/// A triangle on the unit sphere.
#[derive(Clone, Copy, Debug, Default)]
pub struct SphericalTriangle {
    /// Unit directions to the corners.
    a: Vec3,
    b: Vec3,
    c: Vec3,
    /// Volume that the corners' directions span.
    volume: f32,
    /// Solid angle (sr).
    pub solid_angle: f32,
}

impl SphericalTriangle {
    /// Spherical triangle of a triangle with corners relative to the point that sees it (m). No corner may be that point.
    #[shared]
    pub fn new(a: Vec3, b: Vec3, c: Vec3) -> Self {
        // Compute the volume by edges, so that a small triangle keeps its digits.
        let volume = a.dot((b - a).cross(c - a)).abs();
        let scales = Vec3::ONE / Vec3::new(a.length(), b.length(), c.length());
        let volume = volume * (scales.x * scales.y * scales.z);
        let (a, b, c) = (a * scales.x, b * scales.y, c * scales.z);
        let solid_angle = 2.0 * TAU * turns(volume, 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        SphericalTriangle { a, b, c, volume, solid_angle }
    }

    /// Samples a unit direction in the triangle; pdf_solid_angle = 1 / `solid_angle`.
    #[shared]
    pub fn sample(self, u: f32, v: f32) -> Vec3 {
        let SphericalTriangle { a, b, c, volume, solid_angle } = self;
        // Find the point p between a and c for which a, b and p have the share u of the area. By the formula of the solid angle,
        // a and p lie at equal angles around `middle`.
        let (sin, cos) = sin_cos_turns(u * solid_angle * (0.5 / TAU));
        let middle = a * (volume * cos - (a.dot(c) + b.dot(c)) * sin) + c * ((1.0 + a.dot(b)) * sin);
        let p = middle * (2.0 * a.dot(middle) / middle.length_squared()) - a;
        // Sample between b and p, by the versine.
        let towards_p = b.dot(p);
        let along = 1.0 - v * (0.5 * (b - p).length_squared());
        let share = (v * (1.0 + along) / (1.0 + towards_p).max(f32::MIN_POSITIVE)).sqrt();
        (b * (along - share * towards_p) + p * share).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::PI;
    use crate::math::rng::{Rng, Stream};

    const CORNERS: [[Vec3; 3]; 4] = [
        [Vec3::X, Vec3::Y, Vec3::Z],
        // Wide, slender, small.
        [Vec3::new(3.0, -2.0, 0.2), Vec3::new(-2.0, -3.0, 0.3), Vec3::new(-1.0, 4.0, 0.1)],
        [Vec3::new(0.0, 0.0, 1.0), Vec3::new(2.0, 0.1, 1.0), Vec3::new(2.0, 0.0, 0.7)],
        [Vec3::new(0.5, 0.3, 1.0), Vec3::new(0.53, 0.3, 1.0), Vec3::new(0.5, 0.34, 0.99)],
    ];

    #[test]
    fn solid_angles_match_known_values() {
        let solid_angle = |[a, b, c]: [Vec3; 3]| SphericalTriangle::new(a, b, c).solid_angle;
        assert!((solid_angle(CORNERS[0]) - 0.5 * PI).abs() < 1.0e-6);
        // Half of a side of a cube, seen from the cube's centre.
        let half = [Vec3::new(-1.0, -1.0, 1.0), Vec3::new(1.0, -1.0, 1.0), Vec3::new(1.0, 1.0, 1.0)];
        assert!((solid_angle(half) - PI / 3.0).abs() < 1.0e-6);
        // A small triangle: area times cosine over the square of the distance.
        let tiny = [Vec3::new(3.0, 0.0, 4.0), Vec3::new(3.001, 0.0, 4.0), Vec3::new(3.0, 0.002, 4.0)];
        let expected = 1.0e-6 * 0.8 / 25.0;
        assert!((solid_angle(tiny) / expected - 1.0).abs() < 1.0e-3, "{} {expected}", solid_angle(tiny));
    }

    /// Integral of the direction over a spherical triangle, by its edges [Lambert 1760].
    fn lambert(corners: [Vec3; 3]) -> Vec3 {
        let unit = corners.map(|corner| corner.as_dvec3().normalize());
        let turn = unit[0].cross(unit[1]).dot(unit[2]).signum();
        (0..3)
            .map(|i| {
                let (from, to) = (unit[i], unit[(i + 1) % 3]);
                from.cross(to).normalize() * (0.5 * turn * from.angle_between(to))
            })
            .sum::<spirv_std::glam::DVec3>()
            .as_vec3()
    }

    #[test]
    fn directions_are_uniform() {
        for corners in CORNERS {
            let [a, b, c] = corners;
            let whole = SphericalTriangle::new(a, b, c);
            let unit = corners.map(|corner| corner.normalize());
            // Split it into four parts by the middles of the edges.
            let middle = |i: usize, k: usize| (unit[i] + unit[k]).normalize();
            let (ab, bc, ca) = (middle(0, 1), middle(1, 2), middle(2, 0));
            let parts = [[unit[0], ab, ca], [ab, unit[1], bc], [ca, bc, unit[2]], [ab, bc, ca]];
            let shares =
                parts.map(|[a, b, c]| SphericalTriangle::new(a, b, c).solid_angle / whole.solid_angle);
            assert!((shares.iter().sum::<f32>() - 1.0).abs() < 1.0e-3, "{shares:?}");

            let count = 40_000;
            let (mut counts, mut sum, mut squares) = ([0; 4], Vec3::ZERO, 0.0);
            let centre = (unit[0] + unit[1] + unit[2]).normalize();
            for path in 0..count {
                let u = Rng::new(Stream::Camera, 6, path, 0).next4();
                let direction = whole.sample(u.x, u.y);
                let inside = |[a, b, c]: [Vec3; 3]| {
                    let turn = a.cross(b).dot(c).signum();
                    [(a, b), (b, c), (c, a)].iter().all(|(p, q)| p.cross(*q).dot(direction) * turn >= -1.0e-6)
                };
                assert!(inside(unit), "{direction} {corners:?}");
                let part = parts.iter().position(|part| inside(*part)).unwrap_or(3);
                counts[part] += 1;
                sum += direction - centre;
                squares += (direction - centre).length_squared();
            }
            let n = count as f32;
            for (found, share) in counts.iter().zip(shares) {
                let deviation = (n * share * (1.0 - share)).sqrt();
                assert!((*found as f32 - n * share).abs() < 4.5 * deviation, "{counts:?} {shares:?}");
            }
            let expected = lambert(corners) / whole.solid_angle;
            let error = (sum / n + centre - expected).length();
            assert!(error < 4.5 * (squares / n / n).sqrt() + 1.0e-5, "{error} {expected} {corners:?}");
        }
    }
}
