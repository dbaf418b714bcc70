//! The density map of a frame [Yang and Ouyang 2021]. `density.update` makes it from the feedback of the last frame's photons.
//! `density.sum` makes the pyramid of sums that paths are sampled from.
//!
//! Densities are relative: 1 is the mean of a map. The clamp below bounds the flux of a path: at an eighth of the mean, it is
//! eight times that of a uniform start. So an eighth of the paths go on searching where no photon was seen.

use crate::declare::pass;
use crate::interface::density::DensityTexel;
use crate::interface::frame::Dispatch;
use crate::light::by_density::{DensityPyramid, FEEDBACK_WORDS, MAPS, map_count};
use crate::light::density_map::Node;
use crate::math::clamp;
use crate::math::quanta::Quanta;
use crate::method::yang2021::FEEDBACK_INVERSE_QUANTUM;
use crate::platform::Slots;

/// Screen area that a photon should have (px); a footprint has at least 2.5.
const TARGET: f32 = 4.0;
/// Weight of the variance of areas, which is relative to the target's square.
const GAIN_VARIANCE: f32 = 1.0;
/// Weight of the last change, which this term damps.
const GAIN_DERIVATIVE: f32 = 0.1;
/// Share of the new density; the rest is the old one, smoothed.
const BLEND: f32 = 0.5;
/// Smallest density.
const MIN_DENSITY: f32 = 0.125;
/// Largest density.
const MAX_DENSITY: f32 = 4096.0;
/// Largest growth in a frame.
const MAX_GROWTH: f32 = 8.0;

/// Updates the densities by the feedback of the last frame, one texel an invocation.
#[pass(name = "density.update", over = map_count(params.light_count) * DensityPyramid::TEXELS, work = Guide)]
pub fn density_update(
    texel: u32,
    density_pyramid: &[f32],
    density_feedback: &[u32],
    #[len = MAPS * DensityPyramid::TEXELS] mut density: Slots<'_, DensityTexel>,
) {
    let before = density.read(texel);
    density.write(texel, update(texel, &before, density_pyramid, density_feedback));
}

/// Sums a level of the pyramids, one node an invocation.
#[pass(name = "density.sum", over = map_count(params.light_count) * DensityPyramid::TEXELS, work = Guide)]
pub fn density_sum(
    node: u32,
    dispatch: Dispatch,
    density: &[DensityTexel],
    #[len = MAPS * DensityPyramid::NODES] mut density_pyramid: Slots<'_, f32>,
) {
    let (slot, sum) = sum(node, dispatch.level, density, &density_pyramid);
    density_pyramid.write(slot, sum);
}

/// New density of a texel, counted over all maps. It follows from the texel's last record, and from the pyramids and the feedback
/// of the last frame.
#[inline(always)]
pub fn update(texel: u32, before: &DensityTexel, pyramid: &[f32], feedback: &[u32]) -> DensityTexel {
    let (map, texel_in_map) = (texel / DensityPyramid::TEXELS, texel % DensityPyramid::TEXELS);
    let base = map * DensityPyramid::NODES;
    let total = DensityPyramid::total(pyramid, map);
    // Start with a uniform map
    if total <= 0.0 {
        return DensityTexel { density: 1.0, change: 0.0 };
    }
    let scale = DensityPyramid::TEXELS as f32 / total;
    let (x, y) = (texel_in_map % DensityPyramid::SIDE, texel_in_map / DensityPyramid::SIDE);
    let at = |x: u32, y: u32| pyramid[(base + y * DensityPyramid::SIDE + x) as usize] * scale;
    let old = at(x, y);
    // Smooth the old density over the texel and its four neighbours
    let (left, right) = (if x > 0 { x - 1 } else { x }, if x + 1 < DensityPyramid::SIDE { x + 1 } else { x });
    let (below, above) =
        (if y > 0 { y - 1 } else { y }, if y + 1 < DensityPyramid::SIDE { y + 1 } else { y });
    let smooth = (old + at(left, y) + at(right, y) + at(x, below) + at(x, above)) * 0.2;

    // Move the density towards the target area of photons
    let first = (texel * FEEDBACK_WORDS) as usize;
    let (photons, paths) = (feedback[first + 4], feedback[first + 5]);
    let mut new = old;
    if photons > 0 {
        let sum = |word: usize| {
            let quanta = Quanta { low: feedback[first + word], high: feedback[first + word + 1] };
            quanta.to_f32(1.0 / FEEDBACK_INVERSE_QUANTUM)
        };
        let (mean, square) = (sum(0) / photons as f32, sum(2) / photons as f32);
        let variance = (mean * mean - square).abs() / (TARGET * TARGET);
        let wanted = old * mean / TARGET + 0.01 * GAIN_VARIANCE * variance - GAIN_DERIVATIVE * before.change;
        new = wanted.min(old * MAX_GROWTH);
    } else if paths > 0 {
        // No pixel saw a photon of these paths.
        new = MIN_DENSITY;
    }
    // Blend with the smoothed density, and clamp
    let density = clamp(smooth + (new - smooth) * BLEND, MIN_DENSITY, MAX_DENSITY);
    DensityTexel { density, change: density - old }
}

/// Node of a level, counted over all maps: its slot in the pyramids, and its sum.
#[inline(always)]
pub fn sum(index: u32, level: u32, densities: &[DensityTexel], pyramid: &Slots<'_, f32>) -> (u32, f32) {
    let Node { slot, below } = DensityPyramid::node(level, index);
    if level == 0 {
        return (slot, densities[index as usize].density);
    }
    (slot, pyramid.read(below[0]) + pyramid.read(below[1]) + pyramid.read(below[2]) + pyramid.read(below[3]))
}
