//! Lights: choosing one, connecting to it, leaving it. Imports `interface`, `math` and
//! `texture`.

pub mod by_density;
pub mod connect;
pub mod density_map;
pub mod directional;
pub mod emit;
pub mod power;
pub mod spot;

use crate::interface::light::Light;

/// Chooses a light by the alias table; its chance is `Light::pdf_light_choice`.
#[inline(always)]
pub fn choose(lights: &[Light], light_count: u32, u: f32, v: f32) -> u32 {
    let row = ((u * light_count as f32) as u32).min(light_count - 1);
    let light = &lights[row as usize];
    if v < light.threshold { row } else { light.alias }
}
