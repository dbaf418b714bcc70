//! The seam of light tracing: how a light path leaves its light.

use crate::interface::ray::Ray;
use spirv_std::glam::{Vec3, Vec4};

/// The start of a light path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissionSample {
    /// First segment.
    pub ray: Ray,
    /// Flux over the density of this start (W); the caller divides by the number of paths.
    pub flux: Vec3,
    /// 1 / density of the direction (sr); 0 for parallel light.
    pub solid_angle: f32,
    /// 1 / density of the place across parallel light (m^2); 0 for other light.
    pub area: f32,
    /// Texel of the density map that the start was drawn from; 0 without one.
    pub texel: u32,
}

impl EmissionSample {
    /// A start of light that goes apart, at no texel; 1 / density of its direction is `solid_angle`.
    #[inline(always)]
    pub fn new(ray: Ray, flux: Vec3, solid_angle: f32) -> EmissionSample {
        EmissionSample { ray, flux, solid_angle, area: 0.0, texel: 0 }
    }

    /// The start as a mixture draws it: with this share of `density`, the density that it was made for, and beside that with
    /// the density `aimed`. Where nothing leaves the light it carries nothing.
    #[inline(always)]
    pub fn over(self, density: f32, share: f32, aimed: f32) -> EmissionSample {
        let ratio = if density > 0.0 { density / (share * density + aimed) } else { 0.0 };
        EmissionSample {
            flux: self.flux * ratio,
            solid_angle: self.solid_angle * ratio,
            area: self.area * ratio,
            ..self
        }
    }
}

/// The start of a light path in a direction that somebody chose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Towards {
    /// The start that `leave` would make of that direction.
    pub sample: EmissionSample,
    /// Density with which `leave` takes the direction (1/sr); 0 where nothing leaves.
    pub pdf_solid_angle: f32,
}

/// Starts light paths.
pub trait Emit {
    /// Start from two times four uniform numbers: (light, light, place, place), (direction, direction, side,
    /// choice of a caster).
    fn sample(&self, place: Vec4, direction: Vec4) -> EmissionSample;
}
