//! Emission that a camera path meets, weighted by MIS: light sampling at the vertex before could have found it, too.

use super::PathContext;
use super::camera_path::Arrival;
use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::light::Light;
use crate::interface::material::FLAG_EMIT_BOTH_SIDES;
use crate::interface::ray::Ray;
use crate::light::area::pdf_solid_angle;
use crate::light::environment;
use crate::light::light_sampling::LightCandidates;
use crate::math::balance_heuristic;
use spirv_std::glam::Vec3;

/// Whether the side of the surface that a path arrives at emits.
#[inline(always)]
pub fn is_emitter(arrival: &Arrival, features: Features) -> bool {
    let Arrival { vertex, material, .. } = arrival;
    let emits = vertex.front || material.flags & FLAG_EMIT_BOTH_SIDES != 0;
    features.has(Features::AREA_LIGHTS) && vertex.light != NONE && emits
}

/// Emission of a surface times the throughput, weighted by MIS against light sampling at the vertex `from`. The path left `from`
/// with the density `pdf_scattered` (1/sr), which is 0 for a delta lobe: light sampling cannot replace it.
#[inline(always)]
pub fn surface_emission(
    arrival: &Arrival,
    from: Vec3,
    distance: f32,
    pdf_scattered: f32,
    candidates: LightCandidates,
    context: PathContext<'_>,
) -> Vec3 {
    let PathContext { params, features, scene } = context;
    let here = &arrival.vertex;
    let light = scene.lights[here.light as usize];
    let mut mis_weight = 1.0;
    if pdf_scattered > 0.0 {
        let cos = here.to_previous.dot(here.face_normal);
        let pdf_light_sampling = pdf_solid_angle(&light, scene, features, from, distance * distance, cos)
            * candidates.gain(here.light, scene, params.light_count, features, from);
        mis_weight = balance_heuristic(pdf_scattered, pdf_light_sampling);
    }
    arrival.throughput * arrival.material.emission * mis_weight
}

/// Radiance of the environment along a ray, weighted by MIS against light sampling at the vertex that the ray left.
#[inline(always)]
pub fn environment_radiance(
    ray: &Ray,
    pdf_scattered: f32,
    candidates: LightCandidates,
    context: PathContext<'_>,
) -> Vec3 {
    let PathContext { params, features, scene } = context;
    // Take the last light: the environment, if there is one
    let mut light = Light::default();
    let light_count = params.light_count;
    if light_count > 0 {
        light = scene.lights[(light_count - 1) as usize];
    }
    let mut radiance = Vec3::ZERO;
    if light.kind == Features::ENVIRONMENT.0 {
        let mut mis_weight = 1.0;
        if pdf_scattered > 0.0 {
            let gain = candidates.gain(light_count - 1, scene, light_count, features, ray.origin);
            let pdf_light_sampling = environment::pdf_solid_angle(&light, scene, ray.direction) * gain;
            mis_weight = balance_heuristic(pdf_scattered, pdf_light_sampling);
        }
        radiance = environment::radiance_from(scene, ray.direction) * mis_weight;
    }
    radiance
}
