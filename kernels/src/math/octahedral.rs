//! Unit vectors in 32 bits: the octahedron unfolded onto a square, 16 bits an axis [Cigolle et al. 2014]. The angle is off by at
//! most 1e-4.
//!
//! Cigolle et al.: A survey of efficient representations for independent unit vectors.

use spirv_std::glam::Vec3;

/// Number of steps from the square's middle to its border.
const STEPS: f32 = 32_767.0;

/// Encodes a unit vector as a word.
#[inline]
pub fn encode(v: Vec3) -> u32 {
    let sum = v.x.abs() + v.y.abs() + v.z.abs();
    let (x, y) = (v.x / sum, v.y / sum);
    let (x, y) = if v.z < 0.0 { folded(x, y) } else { (x, y) };
    // Truncation rounds to the nearest: both are positive.
    let step = |c: f32| (c * STEPS + (STEPS + 1.5)) as u32;
    step(x) | step(y) << 16
}

/// Decodes a word to its unit vector.
#[inline]
pub fn decode(word: u32) -> Vec3 {
    let coordinate = |step: u32| (step as f32 - (STEPS + 1.0)) * (1.0 / STEPS);
    let (x, y) = (coordinate(word & 0xffff), coordinate(word >> 16));
    let z = 1.0 - x.abs() - y.abs();
    let (x, y) = if z < 0.0 { folded(x, y) } else { (x, y) };
    Vec3::new(x, y, z).normalize()
}

/// Mirrors the square's corners at its diagonals.
#[inline]
fn folded(x: f32, y: f32) -> (f32, f32) {
    let sign = |c: f32| if c < 0.0 { -1.0 } else { 1.0 };
    ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::{Rng, Stream};
    use crate::math::warp::uniform_sphere;

    #[test]
    fn directions_round_trip() {
        let axes = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
        let random = (0..10_000).map(|path| {
            let u = Rng::new(Stream::Camera, 3, path, 0).next4();
            uniform_sphere(u.x, u.y)
        });
        for v in axes.into_iter().chain(random) {
            assert!((decode(encode(v)) - v).length() < 1e-4, "{v}");
        }
    }
}
