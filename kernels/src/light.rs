//! Lights: choosing one, connecting to it, leaving it. A type of light is a file here, with `leave`, `towards` and `connect`, and
//! a line of `interface::light::for_each_light`. Imports `interface`, `math` and `texture`.

pub mod aimed;
pub mod by_density;
pub mod connect;
pub mod density_map;
pub mod emit;
pub mod guided;
pub mod mixture;
pub mod power;
pub mod target;

use crate::interface::NONE;
use crate::interface::features::Features;
use crate::interface::light::{Light, for_each_light};
use crate::interface::scene::SceneTables;
use connect::Connection;
use emit::{EmissionSample, Towards};
use spirv_std::glam::{Vec3, Vec4};

/// Declares the files of the types, and asks the one that a light is of.
macro_rules! types {
    (
        $(#[$about_area:meta])* $area:ident $area_bit:ident $area_name:literal;
        $($(#[$doc:meta])* $file:ident $bit:ident $name:literal;)*
    ) => {
        pub mod $area;
        $(pub mod $file;)*

        /// The types of lights.
        pub const TYPES: Features = Features(Features::$area_bit.0 $(| Features::$bit.0)*);

        /// Start of a light path at a light, by two times four uniform numbers: (light, light, place, place), (direction,
        /// direction, side, choice of what to aim at).
        #[inline(always)]
        pub fn leave(
            light: &Light,
            scene: SceneTables<'_>,
            features: Features,
            place: Vec4,
            direction: Vec4,
        ) -> EmissionSample {
            $(
                if features.has(Features::$bit) && light.kind == Features::$bit.0 {
                    return $file::leave(light, scene, features, place, direction);
                }
            )*
            $area::leave(light, scene, features, place, direction)
        }

        /// Start of a light path at that place by an aim (see `target`): what `leave` makes of it.
        #[inline(always)]
        fn towards(
            light: &Light,
            scene: SceneTables<'_>,
            features: Features,
            place: Vec4,
            aim: Vec3,
        ) -> Towards {
            $(
                if features.has(Features::$bit) && light.kind == Features::$bit.0 {
                    return $file::towards(light, scene, features, place, aim);
                }
            )*
            $area::towards(light, scene, features, place, aim)
        }

        /// Connects a position to a light, by two uniform numbers; none where no light leaves towards it.
        #[inline(always)]
        fn connect_to(
            light: &Light,
            scene: SceneTables<'_>,
            features: Features,
            position: Vec3,
            u: f32,
            v: f32,
        ) -> Connection {
            $(
                if features.has(Features::$bit) && light.kind == Features::$bit.0 {
                    return $file::connect(light, scene, features, position, u, v);
                }
            )*
            $area::connect(light, scene, features, position, u, v)
        }
    };
}
for_each_light!(types);

/// The light of a row as a path leaves it by the uniform numbers of `leave`, and those of its place then: of an environment,
/// parallel light from a direction, which takes the numbers that its place had.
#[inline(always)]
fn drawn(
    scene: SceneTables<'_>,
    features: Features,
    row: u32,
    place: Vec4,
    direction: Vec4,
) -> (Light, Vec4) {
    let mut light = scene.lights[row as usize];
    let mut place = place;
    if features.has(Features::ENVIRONMENT) && light.kind == Features::ENVIRONMENT.0 {
        light = environment::drawn(&light, scene, place.z, place.w);
        place = environment::place_across(place, direction);
    }
    (light, place)
}

/// Where on a light a path starts, by the first four uniform numbers of `leave` (m); of parallel light, the middle of its disc.
#[inline(always)]
fn place_on(light: &Light, scene: SceneTables<'_>, features: Features, place: Vec4) -> Vec3 {
    if light.triangle == NONE { light.position } else { area::place_on(light, scene, features, place) }
}

/// Chooses a light by the alias table; its chance is `Light::pdf_light_choice`.
#[inline(always)]
pub fn choose(lights: &[Light], light_count: u32, u: f32, v: f32) -> u32 {
    let row = ((u * light_count as f32) as u32).min(light_count - 1);
    let light = &lights[row as usize];
    if v < light.threshold { row } else { light.alias }
}
