//! Single steps on their own, for the twin tests: the same numbers must come out of every runner.

use crate::interface::NONE;
use crate::interface::frame::FrameParams;
use crate::interface::needs::Needs;
use crate::interface::scene::SceneTables;
use crate::interface::step::{EmitStep, SampleStep, ScatterIn, ScatterOut};
use crate::light::connect::connect;
use crate::light::emit::Emit;
use crate::math::rng::{Rng, Stream};
use crate::math::warp;
use crate::surface::class::Classes;
use crate::surface::media::MediaStack;
use crate::surface::scatter::Site;
use crate::surface::textured::material_at;
use crate::surface::vertex::vertex;
use spirv_std::glam::{Vec3, Vec4};

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
pub fn scatter(input: &ScatterIn, params: &FrameParams, needs: Needs, scene: SceneTables<'_>) -> ScatterOut {
    let here = vertex(scene, needs, &input.ray, &input.hit, 0.0);
    let mut media = MediaStack::VACUUM;
    if input.inside != NONE {
        media = media.entered(input.inside, scene.materials).0;
    }
    let material = material_at(scene, &here, needs);
    let all = Classes::ALL;
    let site = Site::new(here, material, scene.materials, media, all, params.specular_roughness, needs);
    let departure = site.leave(Vec4::from_array(input.uniform));
    ScatterOut {
        ray: departure.ray,
        weight: departure.sampled.weight,
        pdf: departure.sampled.pdf_solid_angle,
        class: departure.sampled.class.0,
        transmitted: u32::from(departure.sampled.transmitted),
        specular: site.eval(input.towards, Classes::SPECULAR).f,
        non_specular: site.eval(input.towards, Classes::NON_SPECULAR).f,
        chance: site.surface.class_chance(Classes::NON_SPECULAR),
        padding: 0,
    }
}

/// A start of a light path, and a direct connection from the scene's origin.
#[inline(always)]
pub fn emit<E: Emit>(
    index: u32,
    params: &FrameParams,
    needs: Needs,
    scene: SceneTables<'_>,
    emit: &E,
) -> EmitStep {
    let mut rng = Rng::new(Stream::Light, params.seed, index, params.frame);
    let place = rng.next4();
    let leaving = emit.leave(place, rng.next4());
    let connection = connect(scene, params.light_count, needs, Vec3::ZERO, rng.next4());
    EmitStep {
        ray: leaving.ray,
        flux: leaving.flux,
        to_light: connection.to_light,
        radiance_over_pdf: connection.radiance_over_pdf,
        pdf: connection.pdf_solid_angle,
    }
}
