//! Inputs and outputs of the single steps that the parity tests run on every runner.

use crate::interface::ray::{Hit, Ray};
use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// Random numbers and warps of one path.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SampleStep {
    /// Four uniform numbers.
    pub uniform: [f32; 4],
    /// Uniform direction.
    pub sphere: Vec3,
    /// Cosine-distributed direction.
    pub hemisphere: Vec3,
    /// Visible GGX normal.
    pub facet: Vec3,
    /// Barycentric weights of a point on a triangle.
    pub triangle: [f32; 2],
    /// Keeps records at 4 bytes alike on both sides.
    pub padding: u32,
}

/// A hit that scatters.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ScatterIn {
    /// The arriving ray.
    pub ray: Ray,
    /// Its hit.
    pub hit: Hit,
    /// Random numbers of the choice.
    pub uniform: [f32; 4],
    /// Direction in which the step evaluates f.
    pub towards: Vec3,
    /// Material that the ray travels in, or `NONE`.
    pub inside: u32,
}

/// Result of a scattering.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ScatterOut {
    /// Leaving ray.
    pub ray: Ray,
    /// f |cos| / pdf, of the sampled channel in case of dispersion.
    pub weight: Vec3,
    /// pdf_solid_angle, 0 for a delta lobe.
    pub pdf: f32,
    /// Class of the lobe.
    pub class: u32,
    /// 1 for transmission.
    pub transmitted: u32,
    /// f of the specular class towards `towards` (1/sr).
    pub specular: Vec3,
    /// f of the non-specular class towards `towards` (1/sr).
    pub non_specular: Vec3,
    /// Probability of the non-specular class.
    pub class_probability: f32,
    /// Keeps records at 4 bytes alike on both sides.
    pub padding: u32,
}

/// A start of a light path, and a light sample at the scene's origin.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct EmitStep {
    /// First segment.
    pub ray: Ray,
    /// Flux over density (W).
    pub flux: Vec3,
    /// Direction from the scene's origin to a light.
    pub to_light: Vec3,
    /// Radiance over pdf of that light sample (W m^-2 sr^-1 sr).
    pub radiance_over_pdf: Vec3,
    /// pdf_solid_angle of that light sample.
    pub pdf: f32,
}
