//! Lights: choosing one, sampling its emission, sampling it for next-event estimation. A type of light is a file here, with
//! `sample_emission`, `eval_emission` and `sample_light`, and a line of `interface::light::for_each_light`. Imports `interface`,
//! `math` and `texture`.

pub mod aimed;
pub mod by_density;
pub mod density_map;
pub mod emission_cone;
pub mod emit;
pub mod guided;
pub mod light_bvh;
pub mod light_pyramid;
pub mod light_sampling;
pub mod mixture;
pub mod power;

use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::light::{Light, for_each_light};
use crate::interface::scene::SceneTables;
use emit::{EmissionSample, EvaluatedEmission};
use light_sampling::LightSample;
use spirv_std::glam::{Vec3, Vec4};

/// Declares the modules of the types, and functions that dispatch on the type of a light.
macro_rules! types {
    (
        $(#[$about_area:meta])* $area:ident $area_bit:ident $area_name:literal;
        $($(#[$doc:meta])* $file:ident $bit:ident $name:literal;)*
    ) => {
        pub mod $area;
        $(pub mod $file;)*

        /// The types of lights.
        pub const TYPES: Features = Features(Features::$area_bit.0 $(| Features::$bit.0)*);

        /// Samples the start of a light path at a light (pbrt: `SampleLe`), by two times four uniform numbers. These are (light,
        /// light, position, position) and (direction, direction, side, choice of a caster).
        #[inline(always)]
        pub fn sample_emission(
            light: &Light,
            scene: SceneTables<'_>,
            features: Features,
            u_position: Vec4,
            direction: Vec4,
        ) -> EmissionSample {
            $(
                if features.has(Features::$bit) && light.kind == Features::$bit.0 {
                    return $file::sample_emission(light, scene, features, u_position, direction);
                }
            )*
            $area::sample_emission(light, scene, features, u_position, direction)
        }

        /// Evaluates the start of a light path at that position in an emission direction (see `emission_cone`), with the density
        /// of `sample_emission`.
        #[inline(always)]
        fn eval_emission(
            light: &Light,
            scene: SceneTables<'_>,
            features: Features,
            u_position: Vec4,
            direction: Vec3,
        ) -> EvaluatedEmission {
            $(
                if features.has(Features::$bit) && light.kind == Features::$bit.0 {
                    return $file::eval_emission(light, scene, features, u_position, direction);
                }
            )*
            $area::eval_emission(light, scene, features, u_position, direction)
        }

        /// Samples a light for a position, by two uniform numbers (pbrt: `SampleLi`). Returns no light where none reaches the
        /// position.
        #[inline(always)]
        fn sample_light(
            light: &Light,
            scene: SceneTables<'_>,
            features: Features,
            position: Vec3,
            u: f32,
            v: f32,
        ) -> LightSample {
            $(
                if features.has(Features::$bit) && light.kind == Features::$bit.0 {
                    return $file::sample_light(light, scene, features, position, u, v);
                }
            )*
            $area::sample_light(light, scene, features, position, u, v)
        }
    };
}
for_each_light!(types);

/// Samples the direction of an environment by the numbers of the position. Returns parallel light from that direction, and
/// numbers of `sample_emission` that sample the position across it. Returns other lights and their numbers unchanged.
#[inline(always)]
fn sample_environment(
    scene: SceneTables<'_>,
    features: Features,
    light_id: u32,
    u_position: Vec4,
    direction: Vec4,
) -> (Light, Vec4) {
    let mut light = scene.lights[light_id as usize];
    let mut u_position = u_position;
    if features.has(Features::ENVIRONMENT) && light.kind == Features::ENVIRONMENT.0 {
        light = environment::sample_environment(&light, scene, u_position.z, u_position.w);
        u_position = environment::u_across(u_position, direction);
    }
    (light, u_position)
}

/// Samples the position on a light where a path starts (m), by the first four uniform numbers of `sample_emission`. For parallel
/// light it is the middle of its disc.
#[inline(always)]
fn sample_position(light: &Light, scene: SceneTables<'_>, features: Features, u_position: Vec4) -> Vec3 {
    if light.triangle == NONE {
        light.position
    } else {
        area::sample_position(light, scene, features, u_position)
    }
}

/// Chooses a light by the alias table, with the probability `Light::pdf_light_choice`.
#[inline(always)]
pub fn choose(lights: &[Light], light_count: u32, u: f32, v: f32) -> u32 {
    let light_id = ((u * light_count as f32) as u32).min(light_count - 1);
    let light = &lights[light_id as usize];
    if v < light.threshold { light_id } else { light.alias }
}
