//! Photon differentials: first derivatives of a light path by the two numbers that chose its start. They show where neighbouring
//! paths go [Igehy 1999, Tracing ray differentials; Schjoth et al. 2007, Photon differentials]. A step of those numbers is one
//! path's share. The parallelogram of the two position vectors therefore has the area of one path at its hit.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::math::frame::ShadingFrame;
use caustics_kernel_macros::shared;
use spirv_std::glam::Vec3;

/// Derivatives of a ray's origin and unit direction by u and v, with the width and spread that rough scattering adds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Differential {
    /// Derivative of the position by u (m).
    pub position_u: Vec3,
    /// Derivative of the position by v (m).
    pub position_v: Vec3,
    /// Derivative of the direction by u (rad).
    pub direction_u: Vec3,
    /// Derivative of the direction by v (rad).
    pub direction_v: Vec3,
    /// Width from rough scattering, in quadrature (m).
    pub rough_width: f32,
    /// Spread from rough scattering, in quadrature (rad).
    pub rough_spread: f32,
}

/// A surface's unit normal, on the side of arrival, and its derivatives by u and v.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NormalDerivatives {
    /// Unit normal.
    pub normal: Vec3,
    /// Derivative of the normal by u.
    pub by_u: Vec3,
    /// Derivative of the normal by v.
    pub by_v: Vec3,
}

impl Differential {
    /// Differential at the light, of a path with a share `solid_angle` (sr) of directions and a share `area` (m^2) of positions.
    #[shared]
    pub fn at_light(direction: Vec3, solid_angle: f32, area: f32) -> Self {
        let frame = ShadingFrame::new(direction);
        let (angle, side) = (solid_angle.sqrt(), area.sqrt());
        Differential {
            position_u: frame.x * side,
            position_v: frame.y * side,
            direction_u: frame.x * angle,
            direction_v: frame.y * angle,
            rough_width: 0.0,
            rough_spread: 0.0,
        }
    }

    /// Differential after `distance` (m) along the unit `direction`, on the plane of `face_normal` [Igehy 1999, eq. 10 to 12].
    #[shared]
    pub fn transfer(self, direction: Vec3, distance: f32, face_normal: Vec3) -> Self {
        let cos = direction.dot(face_normal);
        let on_plane = |position: Vec3, turn: Vec3| {
            let moved = position + turn * distance;
            moved - direction * (moved.dot(face_normal) / cos)
        };
        Differential {
            position_u: on_plane(self.position_u, self.direction_u),
            position_v: on_plane(self.position_v, self.direction_v),
            rough_width: self.rough_width + self.rough_spread * distance,
            ..self
        }
    }

    /// Differential after a mirror that the unit `direction` arrives at [Igehy 1999, eq. 14 to 16].
    #[shared]
    pub fn reflect(self, direction: Vec3, at: NormalDerivatives) -> Self {
        let cos = direction.dot(at.normal);
        let mirrored = |turn: Vec3, change: Vec3| {
            let cos_change = turn.dot(at.normal) + direction.dot(change);
            turn - (change * cos + at.normal * cos_change) * 2.0
        };
        Differential {
            direction_u: mirrored(self.direction_u, at.by_u),
            direction_v: mirrored(self.direction_v, at.by_v),
            ..self
        }
    }

    /// Differential after refraction from the unit `direction` to `behind`; `eta` = index before over index behind [Igehy 1999,
    /// eq. 17 to 20].
    #[shared]
    pub fn refract(self, direction: Vec3, behind: Vec3, at: NormalDerivatives, eta: f32) -> Self {
        let (cos, cos_behind) = (direction.dot(at.normal), behind.dot(at.normal));
        let mu = eta * cos - cos_behind;
        let refracted = |turn: Vec3, change: Vec3| {
            let cos_change = turn.dot(at.normal) + direction.dot(change);
            let mu_change = (eta - eta * eta * cos / cos_behind) * cos_change;
            turn * eta - (change * mu + at.normal * mu_change)
        };
        Differential {
            direction_u: refracted(self.direction_u, at.by_u),
            direction_v: refracted(self.direction_v, at.by_v),
            ..self
        }
    }

    /// Differential after rough scattering that spreads directions by `spread` (rad). `turned` drops the derivatives of the
    /// direction, which no longer describe the neighbours.
    #[inline]
    pub fn roughen(self, spread: f32, turned: bool) -> Self {
        let keep = if turned { 0.0 } else { 1.0 };
        Differential {
            direction_u: self.direction_u * keep,
            direction_v: self.direction_v * keep,
            rough_spread: (self.rough_spread * self.rough_spread + spread * spread).sqrt(),
            ..self
        }
    }

    /// Area of a path (m^2): the parallelogram of the position vectors.
    #[shared]
    pub fn area(self) -> f32 {
        self.position_u.cross(self.position_v).length()
    }
}
