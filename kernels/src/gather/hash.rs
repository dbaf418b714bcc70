//! Cells of hash grids, and the radii that decide their size.

use crate::gather::tables::Build;
use crate::math::clamp;
use crate::math::grid::cell;
use crate::platform::Words;
use spirv_std::glam::{IVec3, Vec3};

/// Number of slots that are reserved at once; a power of two.
const BLOCK: u32 = 16;
/// Number of bins of a histogram of radii: their base-two exponents.
pub const RADIUS_BINS: u32 = 256;

/// Slot of a cell in a hash table. Neighbours along x are neighbours in the table. `salt` separates the grids that share a table.
#[inline(always)]
pub fn slot(cell: IVec3, salt: u32, cell_mask: u32) -> u32 {
    let x = cell.x as u32;
    let y = (cell.y as u32).wrapping_mul(0x9e37_79b1);
    let z = (cell.z as u32).wrapping_mul(0x85eb_ca77);
    x.wrapping_add(y ^ (y >> 15)).wrapping_add(z ^ (z >> 13)).wrapping_add(salt) & cell_mask
}

/// Salt of the cells of a level, which separates the levels in the hash table.
#[inline(always)]
pub fn salt(level: u32) -> u32 {
    level.wrapping_mul(0x27d4_eb2f)
}

/// Reserves entries for a block of slots, if `slot` is its first. Entries of neighbours in a block lie next to each other.
/// `index_1` holds the counts of all slots and, behind them, the number of entries reserved so far. `index_2` gets the start and
/// the end of each slot's range; the end starts equal to the start.
#[inline(always)]
pub fn reserve(slot: u32, build: &mut Build<'_>) {
    reserve_block(slot, build.params.cell_mask, &mut build.index_1, &mut build.index_2);
}

/// Reserves entries in words of other names than those of [`Build`].
#[inline(always)]
pub fn reserve_block(slot: u32, cell_mask: u32, counts: &mut impl Words, ranges: &mut impl Words) {
    let slots = cell_mask + 1;
    if slot & (BLOCK - 1) != 0 {
        return;
    }
    let end = (slot + BLOCK).min(slots);
    let mut count = 0;
    let mut one = slot;
    while one < end {
        count += counts.get(one);
        one += 1;
    }
    let mut start = if count == 0 { 0 } else { counts.add(slots, count) };
    one = slot;
    while one < end {
        ranges.set(2 * one, start);
        ranges.set(2 * one + 1, start);
        start += counts.get(one);
        one += 1;
    }
}

/// Runs of slots that a box of cells meets. A run is a row of cells along x within one block.
pub struct Runs {
    low: IVec3,
    high: IVec3,
    next: IVec3,
    salt: u32,
    cell_mask: u32,
}

/// Row of cells along x, and the range of the entries in their slots.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    first: IVec3,
    last_x: i32,
    /// First entry.
    pub start: u32,
    /// Index behind the last entry.
    pub end: u32,
}

impl Runs {
    /// Runs of the cells from `low` to `high`; for `salt` see [`slot`].
    #[inline(always)]
    pub fn new(low: IVec3, high: IVec3, salt: u32, cell_mask: u32) -> Runs {
        Runs { low, high, next: low, salt, cell_mask }
    }

    /// Number of cells, as a float: it may exceed an integer.
    #[inline(always)]
    pub fn cell_count(&self) -> f32 {
        let span = (self.high - self.low).as_vec3() + Vec3::ONE;
        span.x * span.y * span.z
    }

    /// Whether another run follows.
    #[inline(always)]
    pub fn is_left(&self) -> bool {
        self.next.z <= self.high.z
    }

    /// Returns the next run, with its entries by the ranges that [`reserve`] made.
    #[inline(always)]
    pub fn next(&mut self, ranges: &[u32]) -> Run {
        let first = self.next;
        let slot = slot(first, self.salt, self.cell_mask);
        let room = ((BLOCK - 1 - (slot & (BLOCK - 1))) as i32).min((self.cell_mask - slot) as i32);
        let last_x = self.high.x.min(first.x + room);
        let last = slot + (last_x - first.x) as u32;
        self.next.x = last_x + 1;
        if last_x == self.high.x {
            self.next.x = self.low.x;
            self.next.y += 1;
            if self.next.y > self.high.y {
                self.next.y = self.low.y;
                self.next.z += 1;
            }
        }
        Run { first, last_x, start: ranges[2 * slot as usize], end: ranges[2 * last as usize + 1] }
    }
}

impl Run {
    /// Whether a position is in one of the run's cells. Other cells share their slots and are visited on their own.
    #[inline(always)]
    pub fn holds(&self, position: Vec3, cell_size: f32) -> bool {
        let cell = cell(position, cell_size);
        let Run { first, last_x, .. } = *self;
        cell.y == first.y && cell.z == first.z && cell.x >= first.x && cell.x <= last_x
    }

    /// Whether a position with these [`cell_bits`] is in one of the run's cells. It must be in the box of all runs.
    #[inline(always)]
    pub fn holds_bits(&self, bits: u32) -> bool {
        let first = cell_bits(self.first);
        let behind = (bits >> 16).wrapping_sub(first >> 16) & 31;
        (bits ^ first) >> 21 == 0 && behind <= (self.last_x - self.first.x) as u32
    }
}

/// Low bits of a cell, in the upper half of a word: they tell cells of a box apart that is below 32 cells wide.
#[inline(always)]
pub fn cell_bits(cell: IVec3) -> u32 {
    (cell.x as u32 & 31) << 16 | (cell.y as u32 & 31) << 21 | (cell.z as u32 & 31) << 26
}

/// Bin of a radius: its biased exponent.
#[inline(always)]
pub fn radius_bin(radius: f32) -> u32 {
    radius.to_bits() >> 23 & 255
}

/// Edge of a cell (m) that holds every disc of a bin; always a normal number. A radius of this exponent is below 2^(exponent +
/// 1), its diameter below 2^(exponent + 2).
#[inline(always)]
pub fn cell_size_of(bin: u32) -> f32 {
    f32::from_bits(clamp(bin + 2, 1, 252) << 23)
}

/// Bits of the edge of a cell (m) that fits nine points in ten, by the histogram at the head of these words. The edge is the
/// power of two above the diameter that nine points in ten stay below.
#[inline(always)]
pub fn common_cell_size<W: Words>(histogram: &W) -> u32 {
    let mut total = 0;
    let mut bin = 0;
    while bin < RADIUS_BINS {
        total += histogram.get(bin);
        bin += 1;
    }
    let mut below = 0;
    let mut exponent = 1;
    bin = 0;
    while bin < RADIUS_BINS {
        if below * 10 < total * 9 {
            below += histogram.get(bin);
            exponent = bin;
        }
        bin += 1;
    }
    cell_size_of(exponent).to_bits()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::platform::AtomicWords;

    #[test]
    fn cells_hold_nine_discs_in_ten() {
        let mut histogram = vec![0; RADIUS_BINS as usize];
        for i in 0..100 {
            histogram[radius_bin(if i < 95 { 0.01 } else { 3.0 }) as usize] += 1;
        }
        let size = f32::from_bits(common_cell_size(&AtomicWords::new(&mut histogram)));
        assert!((0.02..=0.0626).contains(&size), "{size}");
        assert!(f32::from_bits(common_cell_size(&AtomicWords::new(&mut [0; 256]))).is_normal());
    }

    #[test]
    fn cells_hold_the_discs_of_their_bin() {
        for radius in [1.0e-6_f32, 0.01, 0.124_999_99, 0.125, 3.0e5] {
            let size = cell_size_of(radius_bin(radius));
            assert!(size >= 2.0 * radius && size <= 4.0 * radius, "{radius}: {size}");
        }
    }
}
