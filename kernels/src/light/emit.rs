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

/// Starts light paths.
pub trait Emit {
    /// Start from two times four uniform numbers: (light, light, place, place), (direction, direction, side, -).
    fn sample(&self, place: Vec4, direction: Vec4) -> EmissionSample;
}
