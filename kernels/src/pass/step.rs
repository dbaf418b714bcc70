//! `step.*`: single steps of paths, for the parity tests: every runner must give the same numbers. There are as many steps as a
//! batch has light paths.

use crate::declare::pass;
use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::ray::{Hit, Ray};
use crate::interface::scene::SceneTables;
use crate::interface::step::{EmitStep, SampleStep, ScatterIn, ScatterOut};
use crate::light::emit::Emit;
use crate::light::light_sampling::LightCandidates;
use crate::light::power::ByPower;
use crate::math::rng::{Rng, Stream};
use crate::math::warp;
use crate::platform::Slots;
use crate::surface::class::Classes;
use crate::surface::dispersion::{Channel, needs_channel, part};
use crate::surface::media::MediaStack;
use crate::surface::scatter::ScatteringVertex;
use crate::surface::textured::material_at;
use crate::surface::vertex::vertex;
use crate::trace::Tracer;
use spirv_std::glam::{Vec3, Vec4};

/// Random numbers and every warp.
#[pass(name = "step.sample", over = params.light_path_batch, work = Step)]
pub fn step_sample(index: u32, params: &FrameParams, mut samples: Slots<'_, SampleStep>) {
    samples.write(index, sample(index, params));
}

/// Closest hits of given rays.
#[pass(name = "step.hit", over = params.light_path_batch, work = Step)]
pub fn step_hit(
    index: u32,
    tracer: &mut impl Tracer,
    #[len = params.light_path_batch] rays: &[Ray],
    mut hits: Slots<'_, Hit>,
) {
    hits.write(index, tracer.closest(&rays[index as usize]));
}

/// Scattering events.
#[pass(name = "step.scatter", over = params.light_path_batch, work = Step)]
pub fn step_scatter(
    index: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    #[len = params.light_path_batch] scatter_in: &[ScatterIn],
    mut scatter_out: Slots<'_, ScatterOut>,
) {
    scatter_out.write(index, scatter(&scatter_in[index as usize], params, features, scene));
}

/// Starts of light paths and light samples.
#[pass(name = "step.emit", over = params.light_path_batch, work = Step)]
pub fn step_emit(
    index: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    mut emit_steps: Slots<'_, EmitStep>,
) {
    let by_power = ByPower::new(scene, params, features);
    emit_steps.write(index, emit(index, params, features, scene, &by_power));
}

/// Random numbers and every warp.
#[inline(always)]
pub fn sample(index: u32, params: &FrameParams) -> SampleStep {
    let mut rng = Rng::new(Stream::Camera, params.seed, index, params.frame);
    let u = rng.next4();
    let v = rng.next4();
    let to_viewer = warp::cosine_hemisphere(u.x, u.y);
    let triangle = warp::uniform_triangle(v.x, v.y);
    SampleStep {
        uniform: u.to_array(),
        sphere: warp::uniform_sphere(u.x, u.y),
        hemisphere: to_viewer,
        facet: warp::visible_ggx_normal(to_viewer, u.w, v.x, v.y),
        triangle: [triangle.x, triangle.y],
        padding: 0,
    }
}

/// A scattering event.
#[inline(always)]
pub fn scatter(
    input: &ScatterIn,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
) -> ScatterOut {
    let here = vertex(scene, features, &input.ray, &input.hit, 0.0);
    let mut media = MediaStack::VACUUM;
    if input.inside != NONE {
        media = media.entered(input.inside, scene.materials).0;
    }
    let material = material_at(scene, &here, features);
    let all = Classes::ALL;
    let (mut channel, mut carried) = (Channel::GREEN, Vec3::ONE);
    if needs_channel(&here, &material, scene.materials, media, features) {
        (channel, carried) = part(carried, input.uniform[3]);
    }
    let scattering = ScatteringVertex::new(
        here,
        material,
        scene.materials,
        media,
        carried,
        channel,
        all,
        true,
        params.specular_roughness,
        features,
    );
    let scattered = scattering.sample(Vec4::from_array(input.uniform));
    ScatterOut {
        ray: scattered.ray,
        weight: scattered.sampled.weight * carried,
        pdf: scattered.sampled.pdf_solid_angle,
        class: scattered.sampled.class.0,
        transmitted: u32::from(scattered.sampled.transmitted),
        specular: scattering.eval(input.towards, Classes::SPECULAR).f,
        non_specular: scattering.eval(input.towards, Classes::NON_SPECULAR).f,
        class_probability: scattering.bsdf.class_probability(Classes::NON_SPECULAR),
        padding: 0,
    }
}

/// A start of a light path, and a light sample for the scene's origin.
#[inline(always)]
pub fn emit<E: Emit>(
    index: u32,
    params: &FrameParams,
    features: Features,
    scene: SceneTables<'_>,
    emit: &E,
) -> EmitStep {
    let mut rng = Rng::new(Stream::Light, params.seed, index, params.frame);
    let emission = emit.sample(&mut rng);
    let u = rng.next4();
    let light_sample =
        LightCandidates::ONE.sample_light(0, scene, params.light_count, features, Vec3::ZERO, u);
    EmitStep {
        ray: emission.ray,
        flux: emission.flux,
        to_light: light_sample.to_light,
        radiance_over_pdf: light_sample.radiance_over_pdf,
        pdf: light_sample.pdf_solid_angle,
    }
}
