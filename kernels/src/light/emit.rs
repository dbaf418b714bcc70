//! Starts of light paths, and the trait of emissions that sample them.

use crate::interface::ray::Ray;
use crate::math::rng::Rng;
use spirv_std::glam::Vec3;

/// The start of a light path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissionSample {
    /// First segment.
    pub ray: Ray,
    /// Flux over the density of this start (W); the caller divides by the number of paths.
    pub flux: Vec3,
    /// 1 / density of the direction (sr); 0 for parallel light.
    pub solid_angle: f32,
    /// 1 / density of the position across parallel light (m^2); 0 for other light.
    pub area: f32,
    /// Texel of the map that learns from this start, or the code of a `GuidedStart`; 0 without a map.
    pub start_code: u32,
    /// See `PhotonLight::score`.
    pub score: f32,
}

impl EmissionSample {
    /// No start: it carries no flux.
    pub const NONE: EmissionSample = EmissionSample {
        ray: Ray { origin: Vec3::ZERO, length: 0.0, direction: Vec3::ZERO, key: 0 },
        flux: Vec3::ZERO,
        solid_angle: 0.0,
        area: 0.0,
        start_code: 0,
        score: 0.0,
    };

    /// Start of light that is not parallel, without a texel. `solid_angle` is 1 / density of its direction.
    #[inline(always)]
    pub fn new(ray: Ray, flux: Vec3, solid_angle: f32) -> EmissionSample {
        EmissionSample { ray, flux, solid_angle, area: 0.0, start_code: 0, score: 0.0 }
    }

    /// Start as a mixture samples it, with the density `share` * `density` + `aimed`. `density` is the density that the start was
    /// made for. Where that is 0 the light emits nothing, and the start carries nothing.
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

/// The start of a light path in a given emission direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvaluatedEmission {
    /// The start that `sample_emission` would make of that direction.
    pub sample: EmissionSample,
    /// Density of `sample_emission` in this direction (1/sr), or at this position across parallel light (1/m^2); 0 where the
    /// light emits nothing.
    pub pdf: f32,
}

/// Emission: samples the starts of light paths.
pub trait Emit {
    /// Samples a start; takes as many random numbers as it needs.
    fn sample(&self, rng: &mut Rng) -> EmissionSample;
}

#[cfg(not(target_arch = "spirv"))]
impl Emit for &(dyn Emit + Sync) {
    fn sample(&self, rng: &mut Rng) -> EmissionSample {
        (**self).sample(rng)
    }
}
