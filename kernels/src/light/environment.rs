//! The environment: a directional light of random direction. A path samples the direction that its light comes from, by the
//! brightness of the image. The result is parallel light, which starts, is aimed and is guided as `directional` is.
//!
//! Directions are sampled over the unit square, whose areas are solid angles. The image's brightness over the square is a
//! pyramid, as in the maps of guided emission. Radiance is looked up in the image itself, interpolated between texels.

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

use crate::interface::environment::Environment;
use crate::interface::features::Features;
use crate::interface::light::Light;
use crate::interface::scene::SceneTables;
use crate::light::density_map::{Pyramid, from_polar, to_polar};
use crate::light::directional;
use crate::light::emit::{EmissionSample, EvaluatedEmission};
use crate::light::light_sampling::LightSample;
use crate::math::PI;
use crate::math::trig::turns;
use crate::math::warp::uniform_cone;
use spirv_std::glam::{Vec2, Vec3, Vec4};

/// The layout of the pyramid: a texel is 0.2 degrees wide.
pub type EnvironmentPyramid = Pyramid<10>;

/// Solid angle of all directions (sr).
const EVERYWHERE: f32 = 4.0 * PI;

/// Direction of a point of the unit square. Areas of the square are shares of all directions. The map is continuous except
/// straight down.
#[inline(always)]
pub fn direction_of(at: Vec2) -> Vec3 {
    let polar = to_polar(at);
    let around_z = uniform_cone(2.0, polar.x, polar.y);
    Vec3::new(around_z.y, around_z.z, around_z.x)
}

/// Point of the unit square of a direction; the inverse of `direction_of`.
#[inline(always)]
pub fn to_unit_square(direction: Vec3) -> Vec2 {
    // Use the distance from +y, so that directions near it keep their digits.
    let share = 0.25 * (direction - Vec3::Y).length_squared();
    from_polar(Vec2::new(share.min(1.0), turns(direction.x, direction.z)))
}

/// Radiance from a unit direction (W m^-2 sr^-1), interpolated between the four texels around it. Beyond the poles the row next
/// to them goes on.
#[inline(always)]
pub fn radiance_from(scene: SceneTables<'_>, direction: Vec3) -> Vec3 {
    let environment = scene.environment[0];
    let across = (direction.x * direction.x + direction.z * direction.z).sqrt();
    // Find the position in the image, from its top and from its left.
    let down = 2.0 * turns(across, direction.y);
    let mut along = turns(direction.x, -direction.z) + environment.turn;
    along -= along.floor();
    texels_around(scene, &environment, along, down) * environment.scale
}

/// Bilinear interpolation of the four texels around a position of the image.
#[inline(always)]
fn texels_around(scene: SceneTables<'_>, environment: &Environment, along: f32, down: f32) -> Vec3 {
    let Environment { width, height, .. } = *environment;
    let (x, y) = (along * width as f32 - 0.5, (down * height as f32 - 0.5).max(0.0));
    let (left, top) = (x.floor(), y.floor());
    let (right_share, low_share) = (x - left, y - top);
    let column = if left < 0.0 { width - 1 } else { (left as u32).min(width - 1) };
    let next = if column + 1 < width { column + 1 } else { 0 };
    let row = (top as u32).min(height - 1);
    let below = (row + 1).min(height - 1);
    let texel = |column: u32, row: u32| scene.environment_texels[(row * width + column) as usize];
    let upper = texel(column, row).lerp(texel(next, row), right_share);
    upper.lerp(texel(column, below).lerp(texel(next, below), right_share), low_share)
}

/// Density (1/sr) of light sampling in a unit direction. It includes the choice of the light (pbrt: `PDF_Li`).
#[inline(always)]
pub fn pdf_solid_angle(light: &Light, scene: SceneTables<'_>, direction: Vec3) -> f32 {
    let cdf = scene.environment_cdf;
    let density = cdf[EnvironmentPyramid::texel_at(to_unit_square(direction)) as usize]
        * (EnvironmentPyramid::TEXELS as f32 / EnvironmentPyramid::total(cdf, 0));
    light.pdf_light_choice * density / EVERYWHERE
}

/// Samples a direction by the environment's distribution (pbrt: `PiecewiseConstant2D::Sample`). Returns the directional light
/// there.
#[inline(always)]
pub fn sample_environment(light: &Light, scene: SceneTables<'_>, u: f32, v: f32) -> Light {
    let environment = scene.environment[0];
    let sample = EnvironmentPyramid::sample(scene.environment_cdf, 0, Vec2::new(u, v));
    let from = direction_of(sample.at);
    Light {
        kind: Features::DIRECTIONAL_LIGHTS.0,
        direction: -from,
        position: environment.centre + from * environment.radius,
        radius: environment.radius,
        emission: radiance_from(scene, from) * (EVERYWHERE / sample.density),
        ..*light
    }
}

/// Samples the start of a light path (pbrt: `SampleLe`): its direction by the numbers of the position, its position by those of
/// the direction.
#[inline(always)]
pub fn sample_emission(
    light: &Light,
    scene: SceneTables<'_>,
    features: Features,
    u_position: Vec4,
    direction: Vec4,
) -> EmissionSample {
    let light = sample_environment(light, scene, u_position.z, u_position.w);
    directional::sample_emission(&light, scene, features, u_across(u_position, direction), direction)
}

/// Numbers of a position across the parallel light. The numbers of the position have sampled its direction, so those of the
/// direction are free.
#[inline(always)]
pub fn u_across(u_position: Vec4, direction: Vec4) -> Vec4 {
    Vec4::new(u_position.x, u_position.y, direction.x, direction.y)
}

/// Evaluates the start of a light path at an offset across the direction that the numbers of the position sample (m).
#[inline(always)]
pub fn eval_emission(
    light: &Light,
    scene: SceneTables<'_>,
    features: Features,
    u_position: Vec4,
    offset: Vec3,
) -> EvaluatedEmission {
    directional::eval_emission(
        &sample_environment(light, scene, u_position.z, u_position.w),
        scene,
        features,
        u_position,
        offset,
    )
}

/// Samples a direction of the environment, at infinite distance.
#[inline(always)]
pub fn sample_light(
    light: &Light,
    scene: SceneTables<'_>,
    _features: Features,
    position: Vec3,
    u: f32,
    v: f32,
) -> LightSample {
    let light = sample_environment(light, scene, u, v);
    let to_light = -light.direction;
    LightSample {
        to_light,
        radiance_over_pdf: light.emission / light.pdf_light_choice,
        pdf_solid_angle: pdf_solid_angle(&light, scene, to_light),
        endless: true,
        ..LightSample::none(position)
    }
}
