//! Rows of boxes, of which each is nearer to the next than to the one before: clustering pairs boxes that are nearest to each other,
//! two of a row in a pass, and would take quadratic time. Imports obvhs.

use glam::DVec3;
use obvhs::aabb::Aabb;
use rayon::prelude::*;

/// Number of bits of a coordinate in a Morton code.
const BITS: u32 = 21;

/// Number of boxes of the longest row, in the order in which obvhs looks for neighbours.
pub fn longest(boxes: &[Aabb]) -> usize {
    let order = morton_order(boxes);
    let cost = |pair: &[u32]| boxes[pair[0] as usize].union(&boxes[pair[1] as usize]).half_area();
    let costs: Vec<f32> = order.par_windows(2).map(cost).collect();
    let longest = |is_row: fn(f32, f32) -> bool| {
        let (mut longest, mut row) = (0, 0);
        for pair in costs.windows(2) {
            row = if is_row(pair[0], pair[1]) { row + 1 } else { 0 };
            longest = longest.max(row);
        }
        longest
    };
    longest(|before, after| before >= after).max(longest(|before, after| before <= after))
}

/// Ids of boxes along a Morton curve through their centres.
fn morton_order(boxes: &[Aabb]) -> Vec<u32> {
    let all = boxes.par_iter().copied().reduce(Aabb::empty, |all, bounds| all.union(&bounds));
    let scale =
        f64::from((1_u32 << BITS) - 1) / all.diagonal().as_dvec3().max(DVec3::splat(f64::MIN_POSITIVE));
    let code = |bounds: &Aabb| {
        let cell = (0.5 * (bounds.min + bounds.max) - all.min).as_dvec3() * scale;
        spread(cell.x as u64) | spread(cell.y as u64) << 1 | spread(cell.z as u64) << 2
    };
    let mut coded: Vec<(u64, u32)> =
        boxes.par_iter().zip(0..boxes.len() as u32).map(|(b, id)| (code(b), id)).collect();
    coded.par_sort_unstable();
    coded.into_iter().map(|(_, id)| id).collect()
}

/// Moves the lowest bits of a number apart, two zeros between them.
fn spread(number: u64) -> u64 {
    let mut bits = number & ((1 << BITS) - 1);
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        bits = (bits | bits << shift) & mask;
    }
    bits
}

/// The boxes, each enlarged by up to its own size, differently: so that none is always nearer to the next.
pub fn jittered(boxes: &[Aabb]) -> Vec<Aabb> {
    let enlarged = |(bounds, id): (&Aabb, u32)| {
        let share = (u64::from(id).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f32 / (1 << 24) as f32;
        let margin = 0.5 * share * bounds.diagonal();
        Aabb { min: bounds.min - margin, max: bounds.max + margin }
    };
    boxes.par_iter().zip(0..boxes.len() as u32).map(enlarged).collect()
}
