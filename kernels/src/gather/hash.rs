//! Cells of hash grids, and the radii that decide their size.

use crate::seam::Words;
use spirv_std::glam::{IVec3, Vec3};

/// Bins of a histogram of radii: their base-two exponents.
pub const RADIUS_BINS: u32 = 256;

/// The cell of a position; far away everything falls into the outermost cells.
#[inline(always)]
pub fn cell(position: Vec3, cell_size: f32) -> IVec3 {
    // The size is a power of two, so its inverse is exact. Truncation rounds up below zero: step back.
    let inverse = 1.0 / cell_size;
    let index = |x: f32| {
        let scaled = (x * inverse).clamp(-1.0e9, 1.0e9);
        let truncated = scaled as i32;
        if truncated as f32 > scaled { truncated - 1 } else { truncated }
    };
    IVec3::new(index(position.x), index(position.y), index(position.z))
}

/// Slot of a cell in a hash table; neighbours on x are neighbours in the table.
#[inline(always)]
pub fn slot(cell: IVec3, cell_mask: u32) -> u32 {
    let x = cell.x as u32;
    let y = (cell.y as u32).wrapping_mul(0x9e37_79b1);
    let z = (cell.z as u32).wrapping_mul(0x85eb_ca77);
    x.wrapping_add(y ^ (y >> 15)).wrapping_add(z ^ (z >> 13)) & cell_mask
}

/// Bin of a radius: its biased exponent.
#[inline(always)]
pub fn radius_bin(radius: f32) -> u32 {
    radius.to_bits() >> 23 & 255
}

/// Edge of a cell [m] that holds every disc of a bin: a radius of this exponent is below 2^(exponent + 1), twice that is
/// one more. A normal number.
#[inline(always)]
pub fn cell_size_of(bin: u32) -> f32 {
    f32::from_bits((bin + 2).clamp(1, 252) << 23)
}

/// Bits of the edge of a cell [m]: the power of two above twice the radius that nine points in ten stay below, by the
/// histogram at the head of these words.
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
    use crate::seam::AtomicWords;

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
    fn cells_far_away_do_not_overflow() {
        assert_eq!(cell(Vec3::splat(1.0e30), 1.0e-6), IVec3::splat(1_000_000_000));
        assert_eq!(cell(Vec3::new(-0.5, 0.5, 1.5), 1.0), IVec3::new(-1, 0, 1));
    }

    #[test]
    fn a_cell_holds_the_discs_of_its_bin() {
        for radius in [1.0e-6_f32, 0.01, 0.124_999_99, 0.125, 3.0e5] {
            let size = cell_size_of(radius_bin(radius));
            assert!(size >= 2.0 * radius && size <= 4.0 * radius, "{radius}: {size}");
        }
    }
}
