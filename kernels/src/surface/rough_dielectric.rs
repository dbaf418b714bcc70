//! Rough dielectric: GGX facets that reflect and refract by exact Fresnel [Walter et al. 2007], visible normals.
//!
//! Reflection shares the facets of the other reflections. All f here are those of flux, whose integral over cos is the
//! transmitted share; radiance takes eta^2 besides (see `path::camera_path`). A rough thin wall transmits its reflection lobe
//! mirrored through its plane, as glTF says.
//!
//! The lobe samples a visible facet and reflects by that facet's Fresnel reflectance [Walter et al. 2007, 5.3]. A white sample
//! weighs what the masking leaves, never more than 1, and so does a path of many bounces. Where reflection and transmission are
//! of different classes, a collection point divides by the probability of its class. With a choice by facet, that probability is
//! an integral without a closed form. There alone, on a camera prefix, [`reflection_probability`] chooses before the facet, and
//! weights exceed 1.
//!
//! Limitations: scattering is single, as glTF defines the lobe. Light that a facet sends to other facets is lost.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::material::{FLAG_THIN, Material};
use crate::surface::{dielectric, ggx};
use spirv_std::glam::Vec3;

/// Smallest |eta - 1| of a rough interface. Below it the normal that refracts one direction to another is lost in rounding.
const MIN_REFRACTION: f32 = 0.01;

/// Whether the interface is rough. `eta` = index on the path's side over index behind.
#[inline]
pub fn is_rough(material: &Material, eta: f32) -> bool {
    let refracts = material.flags & FLAG_THIN != 0 || (eta - 1.0).abs() > MIN_REFRACTION;
    material.transmission > 0.0 && material.roughness >= ggx::DELTA_ROUGHNESS && refracts
}

/// Probability of reflection, chosen before the facet is known. Any value is unbiased. Let R be the root mean square of what
/// facets reflect, and T that of what they transmit. R / (R + T) minimises the second moment of weights. This is a fit to it over
/// all cosines, roughnesses from 0.1 to 1 and eta from 1/2.4 to 2.4. It takes the mean of three reflectances around the mean
/// cosine of visible facets. The second moment stays below 1.9, and is on average 5 % above the smallest one
/// (`lobe_choice_before_the_facet_is_within_6_percent_of_the_minimum`).
#[inline]
pub fn reflection_probability(material: &Material, cos: f32, eta: f32) -> f32 {
    let alpha = ggx::alpha(material.roughness);
    let mean = (cos * cos + 0.4 * alpha * (1.0 - cos * cos)).sqrt();
    let spread = (0.9 * alpha + 0.28 * material.roughness * (1.0 - cos)).min(0.34);
    let around = dielectric::reflectance(material, (mean - spread).max(0.0), eta)
        + dielectric::reflectance(material, mean.min(1.0), eta)
        + dielectric::reflectance(material, (mean + spread).min(1.0), eta);
    0.05 + 0.3 * around
}

/// Probabilities that a facet of this reflectance reflects and transmits. `tint` is the mean tint of transmitted light. They sum
/// to 1.
#[inline]
pub fn shares(reflectance: f32, tint: f32) -> (f32, f32) {
    let passed = (1.0 - reflectance) * tint;
    let sum = (reflectance + passed).max(f32::MIN_POSITIVE);
    (reflectance / sum, passed / sum)
}

/// Transmission towards one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Transmitted {
    /// f (1/sr) before tint.
    pub f: f32,
    /// Density with which visible facets refract to that direction.
    pub pdf_solid_angle: f32,
    /// Fresnel reflectance of that facet.
    pub reflectance: f32,
}

/// Evaluates transmission in a direction behind the face (z < 0) [Walter et al. 2007].
#[inline]
pub fn eval(material: &Material, to_previous: Vec3, direction: Vec3, eta: f32) -> Transmitted {
    let alpha = ggx::alpha(material.roughness);
    let mirrored = Vec3::new(direction.x, direction.y, -direction.z);
    let (mut half, mut stretch) = ((to_previous + mirrored).normalize(), 1.0);
    if material.flags & FLAG_THIN == 0 {
        // Find the facet by Snell's law: the tangential parts of both directions cancel along this vector.
        let along = to_previous * eta + direction;
        let square = along.length_squared();
        half = along / square.sqrt();
        if half.z < 0.0 {
            half = -half;
        }
        let (cos, cos_behind) = (to_previous.dot(half), -direction.dot(half));
        if cos <= 0.0 || cos_behind <= 0.0 {
            return Transmitted::default();
        }
        // Scale by the Jacobian d half / d direction = cos_behind / |along|^2, where mirroring has 1 / (4 cos).
        stretch = 4.0 * cos * cos_behind / square;
    }
    let reflectance = dielectric::reflectance(material, to_previous.dot(half), eta);
    let f = (1.0 - reflectance) * stretch * ggx::eval(to_previous, mirrored, half, alpha);
    Transmitted { f, pdf_solid_angle: stretch * ggx::visible_pdf(to_previous, half, alpha), reflectance }
}

/// Direction that a facet refracts to. It may leave on the near side, and does in total reflection: then nothing is transmitted.
#[inline]
pub fn refracted(material: &Material, to_previous: Vec3, eta: f32, half: Vec3) -> Vec3 {
    let cos = to_previous.dot(half);
    if material.flags & FLAG_THIN != 0 {
        let reflected = half * (2.0 * cos) - to_previous;
        return Vec3::new(reflected.x, reflected.y, -reflected.z);
    }
    let square = 1.0 - eta * eta * (1.0 - cos * cos);
    if square <= 0.0 {
        return to_previous;
    }
    (half * (eta * cos - square.sqrt()) - to_previous * eta).normalize()
}
