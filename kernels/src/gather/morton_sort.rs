//! A counting sort by Morton codes: elements that are near each other in space come to lie near each other in memory.
//!
//! The box of all elements is divided into 8^k cubes, about as many cubes as elements. Elements are counted cube by cube. The
//! counts are added up in the cubes' Morton order, in three levels of 128, so that no invocation adds more than 128 numbers. Each
//! element then takes the next slot of its cube. The order within a cube is free.

use crate::platform::Words;
use spirv_std::glam::{UVec3, Vec3};

/// Stage over elements: finds the bounds of all of them.
pub const BOUNDS: u32 = 100;
/// Stage over elements: counts those of each cube.
pub const COUNT: u32 = 101;
/// Stage over counts of level 1: adds up those of cubes.
pub const SUM: u32 = 102;
/// Stage over counts of level 2: adds up those of level 1.
pub const SUM_OF_SUMS: u32 = 103;
/// Stage of one invocation: turns the counts of level 2 into first slots.
pub const SCAN: u32 = 104;
/// Stage over counts of level 2: turns those of level 1 into first slots.
pub const SPREAD: u32 = 105;
/// Stage over counts of level 1: turns those of cubes into first slots.
pub const SPREAD_AGAIN: u32 = 106;
/// Stage over elements: takes the next slot of the element's cube.
pub const FILL: u32 = 107;

/// Number of counts that an invocation adds up.
const FAN: u32 = 128;
/// Number of words before the counts: keys of the upper corner and of the negated lower corner, and the number of elements.
const HEAD: u32 = 8;
/// Index of the word that holds the number of elements.
pub const TOTAL: u32 = 6;

/// Base-two logarithm of the number of cubes along an axis.
#[inline(always)]
fn bits(capacity: u32) -> u32 {
    let mut bits = 2;
    while bits < 7 && (1 << (3 * bits)) < capacity {
        bits += 1;
    }
    bits
}

/// Number of counts of a level: cubes (0), level 1, level 2. For level 3, the number of words of the whole sort.
#[inline(always)]
pub fn level_count(capacity: u32, level: u32) -> u32 {
    let cubes = 1 << (3 * bits(capacity));
    let sums = cubes_in(cubes);
    match level {
        0 => cubes,
        1 => sums,
        2 => cubes_in(sums),
        _ => HEAD + cubes + sums + cubes_in(sums),
    }
}

#[inline(always)]
fn cubes_in(count: u32) -> u32 {
    count.div_ceil(FAN)
}

/// Index of the first count of a level.
#[inline(always)]
fn level_start(capacity: u32, level: u32) -> u32 {
    let above = if level == 0 { level_count(capacity, 1) } else { 0 };
    let top = if level < 2 { level_count(capacity, 2) } else { 0 };
    HEAD + top + above
}

/// Key of a number. Keys as integers have the order of the numbers; 0 is below all keys.
#[inline(always)]
fn key(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}

#[inline(always)]
fn value(key: u32) -> f32 {
    if key >> 31 == 0 { f32::from_bits(!key) } else { f32::from_bits(key & !(1 << 31)) }
}

/// Cube of a position, as its Morton code.
#[inline(always)]
fn cube<W: Words>(position: Vec3, capacity: u32, words: &W) -> u32 {
    let high = Vec3::new(value(words.get(0)), value(words.get(1)), value(words.get(2)));
    let low = -Vec3::new(value(words.get(3)), value(words.get(4)), value(words.get(5)));
    let bits = bits(capacity);
    let side = (1 << bits) as f32;
    let extent = (high - low).max_element();
    let scale = if extent > 0.0 { side / extent } else { 0.0 };
    let scaled = ((position - low) * scale).clamp(Vec3::ZERO, Vec3::splat(side - 1.0));
    let UVec3 { x, y, z } = scaled.as_uvec3();
    spread(x) | spread(y) << 1 | spread(z) << 2
}

/// Puts two zeros behind each of the lowest ten bits.
#[inline(always)]
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Runs a stage over elements for one of them; `capacity` is their largest number. Returns the element's slot in `FILL`.
#[inline(always)]
pub fn element<W: Words>(stage: u32, position: Vec3, capacity: u32, words: &mut W) -> u32 {
    if stage == BOUNDS {
        words.fetch_max(0, key(position.x));
        words.fetch_max(1, key(position.y));
        words.fetch_max(2, key(position.z));
        words.fetch_max(3, key(-position.x));
        words.fetch_max(4, key(-position.y));
        words.fetch_max(5, key(-position.z));
        return 0;
    }
    let word = level_start(capacity, 0) + cube(position, capacity, words);
    words.add(word, 1)
}

/// Runs one of the other stages, over counts.
#[inline(always)]
pub fn counts<W: Words>(stage: u32, index: u32, capacity: u32, words: &mut W) {
    if stage == SUM || stage == SUM_OF_SUMS {
        // Add up a group of counts
        let level = stage - SUM;
        let (first, end) = group(capacity, level, index);
        let mut sum = 0;
        let mut word = first;
        while word < end {
            sum += words.get(word);
            word += 1;
        }
        words.set(level_start(capacity, level + 1) + index, sum);
    } else {
        // Turn counts into first slots: SCAN those of level 2, SPREAD those of level 1, SPREAD_AGAIN those of cubes.
        let level = SPREAD_AGAIN - stage;
        let mut next = 0;
        let (mut word, mut end) = (level_start(capacity, 2), level_start(capacity, 1));
        if level < 2 {
            next = words.get(level_start(capacity, level + 1) + index);
            (word, end) = group(capacity, level, index);
        }
        while word < end {
            let count = words.get(word);
            words.set(word, next);
            next += count;
            word += 1;
        }
        if level == 2 {
            words.set(TOTAL, next);
        }
    }
}

/// Range of the words of a level that belong to count `index` of the level above.
#[inline(always)]
fn group(capacity: u32, level: u32, index: u32) -> (u32, u32) {
    let start = level_start(capacity, level);
    let end = start + level_count(capacity, level);
    let first = start + index * FAN;
    (first, (first + FAN).min(end))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::{Rng, Stream};
    use crate::platform::AtomicWords;

    /// Slots of positions.
    fn sort(positions: &[Vec3], capacity: u32) -> Vec<u32> {
        let mut memory = vec![0; level_count(capacity, 3) as usize];
        let mut words = AtomicWords::new(&mut memory);
        for stage in [BOUNDS, COUNT] {
            for &position in positions {
                element(stage, position, capacity, &mut words);
            }
        }
        for (stage, level) in [(SUM, 1), (SUM_OF_SUMS, 2), (SCAN, 4), (SPREAD, 2), (SPREAD_AGAIN, 1)] {
            for index in 0..if level == 4 { 1 } else { level_count(capacity, level) } {
                counts(stage, index, capacity, &mut words);
            }
        }
        assert_eq!(words.get(TOTAL), positions.len() as u32);
        positions.iter().map(|&position| element(FILL, position, capacity, &mut words)).collect()
    }

    #[test]
    fn slots_are_a_permutation_in_morton_order() {
        for count in [1, 7, 3000, 200_000] {
            let position = |i| {
                let u = Rng::new(Stream::Light, 3, i, 0).next4();
                Vec3::new(u.x - 0.5, 3.0 * u.y, -0.1 * u.z)
            };
            let positions: Vec<Vec3> = (0..count).map(position).collect();
            let slots = sort(&positions, count);
            let mut sorted = vec![None; count as usize];
            for (position, &slot) in positions.iter().zip(&slots) {
                assert!(sorted[slot as usize].replace(*position).is_none(), "slot {slot} twice");
            }
            // Mean distance of neighbours in memory: that of random order is above 1.
            let sorted: Vec<Vec3> = sorted.into_iter().map(Option::unwrap).collect();
            let far: f32 = sorted.windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f32>();
            assert!(count < 100 || far / (count as f32) < 0.2, "{count}: {}", far / count as f32);
        }
    }

    #[test]
    fn keys_are_in_the_order_of_numbers() {
        let values = [f32::NEG_INFINITY, -3.0e5, -1.0e-30, 0.0, 2.0e-40, 1.0, f32::INFINITY];
        assert!(values.windows(2).all(|pair| key(pair[0]) < key(pair[1])));
        assert!(values.iter().all(|&number| value(key(number)) == number && key(number) > 0));
    }

    #[test]
    fn elements_at_one_position_get_distinct_slots() {
        let mut slots = sort(&[Vec3::ONE; 1000], 1000);
        slots.sort_unstable();
        assert_eq!(slots, (0..1000).collect::<Vec<_>>());
    }
}
