//! Orthonormal frames around a normal.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use caustics_kernel_macros::shared;
use spirv_std::glam::Vec3;

/// An orthonormal frame; z is the normal.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShadingFrame {
    /// First tangent.
    pub x: Vec3,
    /// Second tangent.
    pub y: Vec3,
    /// Normal.
    pub z: Vec3,
}

/// Value of the normal's z at which frames jump. Duff et al. jump at 0, the z of every wall along that axis: rounding, which
/// differs between devices, would choose the wall's frame.
const SEAM: f32 = -0.55;

impl ShadingFrame {
    /// Frame around a unit normal, without branches [Duff et al. 2017]. It jumps where z is -0.55.
    #[shared]
    pub fn new(normal: Vec3) -> Self {
        let sign = if normal.z < SEAM { -1.0 } else { 1.0 };
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        ShadingFrame {
            x: Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            y: Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            z: normal,
        }
    }

    /// Frame that turns with a unit normal and never jumps, except for normals along one axis that is askew to those of scenes.
    /// Directions keep their coordinates while the normal moves.
    #[inline]
    pub fn steady(normal: Vec3) -> Self {
        let across = Vec3::new(0.36, 0.48, 0.8).cross(normal);
        let square = across.length_squared();
        if square < 1.0e-8 {
            return ShadingFrame::new(normal);
        }
        let x = across / square.sqrt();
        ShadingFrame { x, y: normal.cross(x), z: normal }
    }

    /// Coordinates of a world vector in this frame.
    #[inline]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    /// World vector of coordinates in this frame.
    #[inline]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::*;
    use crate::math::{is_finite, warp};

    #[test]
    fn frames_are_orthonormal_and_invertible() {
        for path in 0..10_000 {
            let u = Rng::new(Stream::Light, 0, path, 0).next4();
            let normal = warp::uniform_sphere(u.x, u.y);
            for frame in [ShadingFrame::new(normal), ShadingFrame::steady(normal)] {
                for (a, b, dot) in [
                    (frame.x, frame.x, 1.0),
                    (frame.y, frame.y, 1.0),
                    (frame.x, frame.y, 0.0),
                    (frame.x, frame.z, 0.0),
                    (frame.y, frame.z, 0.0),
                ] {
                    assert!((a.dot(b) - dot).abs() < 1e-6);
                }
                let v = warp::uniform_sphere(u.z, u.w);
                assert!((frame.to_world(frame.to_local(v)) - v).length() < 1e-6);
            }
        }
        for normal in [Vec3::new(0.36, 0.48, 0.8), Vec3::new(-0.36, -0.48, -0.8)] {
            assert!(is_finite(ShadingFrame::steady(normal).x.element_sum()));
        }
        let down = ShadingFrame::new(-Vec3::Z);
        assert!(is_finite(down.x.element_sum() + down.y.element_sum()));
    }
}
