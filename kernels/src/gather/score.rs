//! What an emission that learns is told: how much a start gave to the image.
//!
//! The score of a start is the sum over pixels of the squares of what it gave them, relative to what they show: what it adds
//! to the relative variance of the image. It is summed over pairs of photon and pixel in integers, so that no order shows.

use crate::interface::point::{PhotonLight, PointGeometry, PointShading};
use crate::math::PI;
use crate::math::mean;
use crate::math::quanta::Quanta;
use crate::platform::Atomics;
use spirv_std::glam::Vec3;

/// 1 / quantum of scores, in the unit that `PhotonLight::score` brings along.
pub const INVERSE_QUANTUM: f32 = 4096.0;
/// Most quanta of a pair: 2^40.
const MAX_QUANTA: f32 = 1_099_511_627_776.0;
/// Words of a texel's score.
pub const WORDS: u32 = 2;

/// The score of a photon that gave `value` (W/sr, as `contribution` has it) to a point whose pixel has this weight
/// (1 / its light squared).
#[inline(always)]
pub fn score(
    light: &PhotonLight,
    point: &PointGeometry,
    shading: &PointShading,
    value: Vec3,
    weight: f32,
) -> Quanta {
    // Divide twice: the square of a small radius may underflow.
    let radiance = mean(shading.throughput * value) / point.radius / (PI * point.radius);
    let score = radiance * radiance * weight * light.score;
    Quanta::from_f32(score.min(MAX_QUANTA / INVERSE_QUANTUM), INVERSE_QUANTUM)
}

/// Adds a score to those of a photon's start.
#[inline(always)]
pub fn add<A: Atomics>(score: Quanta, light: &PhotonLight, scores: &mut A) {
    if score != Quanta::default() {
        score.add_to(scores, light.texel * WORDS);
    }
}
