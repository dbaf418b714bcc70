//! Scores: the contribution of the start of a light path to the image. Emissions that learn read them.
//!
//! The score of a start is a sum over pixels: the square of its contribution to a pixel, relative to the light of the pixel. It
//! is the start's part of the relative variance of the image. Pairs of photon and pixel are summed in integers, so that their
//! order does not show.

use crate::interface::features::Features;
use crate::interface::frame::FrameParams;
use crate::interface::point::{PhotonLight, PointGeometry, PointShading};
use crate::light::light_pyramid::{GuidedStart, LightPyramid};
use crate::math::PI;
use crate::math::mean;
use crate::math::quanta::Quanta;
use crate::platform::Atomics;
use spirv_std::glam::Vec3;

/// One over the quantum of scores, in the unit of `PhotonLight::score`.
pub const INVERSE_QUANTUM: f32 = 4096.0;
/// Largest number of quanta of a pair: 2^40.
const MAX_QUANTA: f32 = 1_099_511_627_776.0;
/// Number of words of the score of a texel or a leaf.
pub const WORDS: u32 = 2;

/// Score of a photon that contributed `value` (W/sr, see `contribution`) to a point. `weight` is that of its pixel: 1 / its light
/// squared.
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

/// Adds a score to the texel of a photon's start, and to the leaf of its light.
#[inline(always)]
pub fn add<A: Atomics>(
    score: Quanta,
    light: &PhotonLight,
    params: &FrameParams,
    features: Features,
    scores: &mut A,
) {
    if score != Quanta::default() {
        let start = GuidedStart::decode(light.start_code, params, features);
        score.add_to(scores, start.texel * WORDS);
        if LightPyramid::is_used(params, features) {
            score.add_to(scores, start.leaf_word(params) * WORDS);
        }
    }
}
