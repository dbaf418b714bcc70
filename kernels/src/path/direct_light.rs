//! Light sampling (next-event estimation) at a vertex of a camera path, combined with scattering by MIS.

use super::PathContext;
use super::light_numbers::LightNumbers;
use super::scratch::light_samples::LightSamples;
use super::scratch::{PathScratch, ShadowRay, Sum};
use crate::interface::features::Features;
use crate::interface::ray::Ray;
use crate::light::light_sampling::{ByClass, LightSample, Reservoir};
use crate::math::balance_heuristic;
use crate::math::offset;
use crate::math::rng::Rng;
use crate::surface::class::Classes;
use crate::surface::scatter::ScatteringVertex;
use crate::surface::vertex::Vertex;
use crate::trace::Tracer;
use crate::trace::through_media::shadow_transmittance;
use spirv_std::glam::Vec3;

/// Weighs the candidates of each light sample by BSDF and MIS, and chooses one by the light that it would give unshadowed. Stores
/// a shadow ray to each chosen candidate in the scratch. Returns the number of shadow rays.
#[inline(always)]
pub fn choose_light_samples(
    scattering: &ScatteringVertex,
    throughput: Vec3,
    numbers: &LightNumbers,
    samples: &mut LightSamples<'_>,
    finds: Classes,
    rng: &Rng,
    features: Features,
    scratch: &mut PathScratch<'_>,
) -> u32 {
    let mut shadow_rays = 0;
    if scattering.bsdf.has_non_delta_lobe() {
        let mut id = 0;
        while id < numbers.count {
            // Choose a candidate by the light that it would give unshadowed
            let mut reservoir = Reservoir::new(numbers.choice);
            let end = id + numbers.candidates.candidate_count;
            while id < end {
                let sample = samples.get(id);
                let direct = direct_light(scattering, &sample, finds, features);
                reservoir.add(samples.keep(id, sample, direct), direct.sum());
                id += 1;
            }
            if reservoir.has_sample() {
                // Store its shadow ray
                let (sample, direct) = samples.kept(reservoir.kept);
                let direct = direct.times(reservoir.inverse_probability());
                let mut ray = shadow_ray(&scattering.vertex, &sample);
                if features.has(Features::BLENDS) {
                    ray.key = rng.ray_key(id);
                }
                let shadow_ray = ShadowRay {
                    ray,
                    media: scattering.media_towards(sample.to_light),
                    radiance: throughput * direct.sum(),
                    specular: throughput * direct.specular,
                    non_specular: throughput * direct.non_specular,
                };
                scratch.set_shadow_ray(shadow_rays, &shadow_ray);
                shadow_rays += 1;
            }
        }
    }
    shadow_rays
}

/// Traces the shadow rays of a vertex, and adds the light that reaches it. The light leaves room for
/// `left` further scatterings.
#[inline(always)]
pub fn trace_shadow_rays<T: Tracer>(
    count: u32,
    in_prefix: bool,
    left: u32,
    context: PathContext<'_>,
    tracer: &mut T,
    scratch: &mut PathScratch<'_>,
) {
    let PathContext { params, features, scene } = context;
    let mut index = 0;
    while index < count {
        let shadow_ray = scratch.shadow_ray(index);
        let transmittance =
            shadow_transmittance(&shadow_ray.ray, shadow_ray.media, params, features, scene, tracer);
        if transmittance.max_element() > 0.0 {
            scratch.add(Sum::Radiance, shadow_ray.radiance * transmittance);
            if !in_prefix {
                scratch.add_indirect(left, shadow_ray.radiance * transmittance);
            }
            if features.has(Features::PARTS) && in_prefix {
                scratch.add(Sum::Prefix, shadow_ray.specular * transmittance);
                scratch.add(Sum::Direct, shadow_ray.non_specular * transmittance);
            }
        }
        index += 1;
    }
}

/// Light of a light sample that the vertex reflects or transmits, by class: f cos L / pdf. It is weighted by MIS against finding
/// the light by scattering (balance heuristic).
#[inline(always)]
fn direct_light(
    scattering: &ScatteringVertex,
    light_sample: &LightSample,
    classes: Classes,
    features: Features,
) -> ByClass {
    let mut sum = ByClass::default();
    if light_sample.radiance_over_pdf.max_element() > 0.0 {
        let cos = light_sample.to_light.dot(scattering.vertex.shading_normal).abs();
        let above = light_sample.to_light.dot(scattering.vertex.face_normal) > 0.0;
        if features.has(Features::ROUGH_DIELECTRIC) && !above && classes.has(Classes::SPECULAR) {
            // Transmit through the surface; radiance is scaled by eta^2, as where a path scatters.
            let eta = scattering.bsdf.eta;
            sum.specular = light_sample.radiance_over_pdf
                * mis_weighted(scattering, light_sample, Classes::SPECULAR)
                * (cos * eta * eta);
            return sum;
        }
        // Reflect
        let light = light_sample.radiance_over_pdf * if above { cos } else { 0.0 };
        sum.non_specular = light * mis_weighted(scattering, light_sample, Classes::NON_SPECULAR);
        if classes.has(Classes::SPECULAR) && scattering.bsdf.has_non_delta_lobe_in(Classes::SPECULAR) {
            sum.specular = light * mis_weighted(scattering, light_sample, Classes::SPECULAR);
        }
    }
    sum
}

/// f of one class times its MIS weight.
#[inline(always)]
fn mis_weighted(scattering: &ScatteringVertex, light_sample: &LightSample, class: Classes) -> Vec3 {
    let lobes = scattering.eval(light_sample.to_light, class);
    if light_sample.pdf_solid_angle > 0.0 {
        lobes.f * balance_heuristic(light_sample.pdf_solid_angle, lobes.pdf_solid_angle)
    } else {
        lobes.f
    }
}

/// Shadow ray from a vertex to just before a light.
#[inline(always)]
fn shadow_ray(vertex: &Vertex, light_sample: &LightSample) -> Ray {
    let origin = offset::leave(vertex.position, vertex.face_normal, light_sample.to_light, vertex.clearance);
    if light_sample.endless {
        return Ray::endless(origin, light_sample.to_light);
    }
    Ray::between(origin, light_sample.target)
}
