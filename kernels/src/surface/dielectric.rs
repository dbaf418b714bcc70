//! Smooth dielectric: reflection and refraction by exact Fresnel, or a thin wall that does not refract.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

#[cfg(not(target_arch = "spirv"))]
use crate::interface::features::Features;
#[cfg(not(target_arch = "spirv"))]
use crate::interface::material::FLAG_OPEN_SURFACE;
use crate::interface::material::{FLAG_THIN, Material};
use crate::surface::class::Classes;
#[cfg(not(target_arch = "spirv"))]
use crate::surface::ggx;
use crate::surface::{DielectricInterface, Sampled, fresnel};
use spirv_std::glam::Vec3;

/// Features that the dielectric of a material needs; none without transmission.
#[cfg(not(target_arch = "spirv"))]
pub fn features_of(material: &Material) -> Features {
    if !material.transmits() {
        return Features(0);
    }
    let mut features = Features::DIELECTRIC;
    if material.roughness >= ggx::DELTA_ROUGHNESS {
        features = features | Features::ROUGH_DIELECTRIC;
    }
    if material.flags & FLAG_THIN == 0 && material.absorption.max_element() > 0.0 {
        features = features | Features::ABSORPTION;
    }
    if material.is_medium() && material.dispersion > 0.0 {
        features = features | Features::DISPERSION;
    }
    if material.flags & FLAG_OPEN_SURFACE != 0 {
        features = features | Features::OPEN_SURFACES;
    }
    features
}

/// Reflectance at a cosine. A thin wall adds up its inner reflections: 2 r / (1 + r).
#[inline]
pub fn reflectance(material: &Material, cos: f32, eta: f32) -> f32 {
    if material.flags & FLAG_THIN != 0 {
        let r = fresnel::dielectric_reflectance(cos, 1.0 / material.ior);
        2.0 * r / (1.0 + r)
    } else {
        fresnel::dielectric_reflectance(cos, eta)
    }
}

/// Samples reflection or transmission, in proportion to the flux that either carries. The base colour tints transmitted light.
/// The weight is that of flux; radiance takes eta^2 besides (see `path::camera_path`). `lobe_probability` is that of the
/// dielectric among all lobes.
#[inline]
pub fn sample(
    material: &Material,
    to_previous: Vec3,
    dielectric: DielectricInterface,
    lobe_probability: f32,
    u: f32,
) -> Sampled {
    let share = (1.0 - material.metallic) * material.transmission;
    let tint = material.base_color;
    let passed = (1.0 - dielectric.reflectance) * crate::math::mean(tint);
    let reflection_probability = dielectric.reflectance / (dielectric.reflectance + passed);
    let (cos, eta) = (to_previous.z, dielectric.indices.eta);
    let reflected = Sampled {
        direction: Vec3::new(-to_previous.x, -to_previous.y, cos),
        weight: Vec3::splat(share * dielectric.reflectance / (lobe_probability * reflection_probability)),
        pdf_solid_angle: 0.0,
        class: Classes::SPECULAR,
        transmitted: false,
        straight: false,
        eta,
        roughness: 0.0,
    };
    if u < reflection_probability {
        return reflected;
    }
    let weight =
        tint * (share * (1.0 - dielectric.reflectance) / (lobe_probability * (1.0 - reflection_probability)));
    if material.flags & FLAG_THIN != 0 {
        return Sampled {
            direction: -to_previous,
            weight,
            transmitted: true,
            straight: true,
            eta: 1.0,
            ..reflected
        };
    }
    // Refract by Snell's law: the tangential part scales with eta.
    let cos_behind = (1.0 - eta * eta * (1.0 - cos * cos)).max(0.0).sqrt();
    let direction = Vec3::new(-eta * to_previous.x, -eta * to_previous.y, -cos_behind);
    Sampled { direction: direction.normalize(), weight, transmitted: true, ..reflected }
}
