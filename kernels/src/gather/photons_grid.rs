//! Photons in a hash grid: deposits are sorted by cell, and each point visits the cells that its box meets.
//!
//! Source: the grid of progressive photon mapping [Hachisuka and Jensen 2009], with counting instead of sorting.
//! Cost: one pass over the points and three over the deposits to build; a point reads a few cells' deposits.
//! Where it is slow: a point whose radius is far above the median visits many cells (at most as many as there are
//! deposits: beyond that it looks at all of them). It is exact for every radius.

use crate::gather::{Near, Neighbours, Visit};
use crate::interface::point::DepositGeometry;
use spirv_std::glam::{IVec3, Vec3};

/// Bins of `radius_histogram`: the base-two exponents of the points' radii.
pub const RADIUS_BINS: u32 = 256;

/// Deposits sorted by the cells of a hash grid.
#[derive(Clone, Copy)]
pub struct PhotonsGrid<'a> {
    /// Deposits, sorted by cell.
    pub sorted_geometry: &'a [DepositGeometry],
    /// First deposit of each cell of the hash table.
    pub cell_starts: &'a [u32],
    /// One past the last deposit of each cell.
    pub cell_ends: &'a [u32],
    /// Cells of the table minus one.
    pub cell_mask: u32,
    /// Edge of a cell [m].
    pub cell_size: f32,
    /// Deposits there are.
    pub count: u32,
}

impl Neighbours for PhotonsGrid<'_> {
    #[inline(always)]
    fn for_each_near<V: Visit>(&mut self, near: Near, visit: &mut V) {
        let low = cell(near.position - near.half_extent, self.cell_size);
        let high = cell(near.position + near.half_extent, self.cell_size);
        let span = (high - low).as_vec3() + Vec3::ONE;
        if span.x * span.y * span.z > self.count as f32 {
            let mut id = 0;
            while id < self.count {
                visit.visit(id);
                id += 1;
            }
            return;
        }
        let mut z = low.z;
        while z <= high.z {
            let mut y = low.y;
            while y <= high.y {
                let mut x = low.x;
                while x <= high.x {
                    let here = IVec3::new(x, y, z);
                    let slot = hash(here, self.cell_mask) as usize;
                    let mut id = self.cell_starts[slot];
                    let end = self.cell_ends[slot];
                    while id < end {
                        // Another cell may share the slot: it has its own visit.
                        if cell(self.sorted_geometry[id as usize].position, self.cell_size) == here {
                            visit.visit(id);
                        }
                        id += 1;
                    }
                    x += 1;
                }
                y += 1;
            }
            z += 1;
        }
    }
}

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

/// Slot of a cell in the hash table; neighbours on x are neighbours in the table.
#[inline(always)]
pub fn hash(cell: IVec3, cell_mask: u32) -> u32 {
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

/// Edge of a cell [m]: the power of two above twice the radius that nine points in ten stay below.
#[inline(always)]
pub fn cell_size(radius_histogram: &[u32]) -> f32 {
    let mut total = 0;
    let mut bin = 0;
    while bin < RADIUS_BINS as usize {
        total += radius_histogram[bin];
        bin += 1;
    }
    let mut below = 0;
    let mut exponent = 1;
    bin = 0;
    while bin < RADIUS_BINS as usize {
        if below * 10 < total * 9 {
            below += radius_histogram[bin];
            exponent = bin as u32;
        }
        bin += 1;
    }
    // A radius of this exponent is below 2^(exponent + 1); twice that is one more. Keep the result a normal number.
    f32::from_bits((exponent + 2).clamp(1, 252) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_hold_nine_discs_in_ten() {
        let mut histogram = vec![0; RADIUS_BINS as usize];
        for i in 0..100 {
            histogram[radius_bin(if i < 95 { 0.01 } else { 3.0 }) as usize] += 1;
        }
        let size = cell_size(&histogram);
        assert!((0.02..=0.0626).contains(&size), "{size}");
        assert!(cell_size(&[0; 256]).is_normal());
    }

    #[test]
    fn cells_far_away_do_not_overflow() {
        assert_eq!(cell(Vec3::splat(1.0e30), 1.0e-6), IVec3::splat(1_000_000_000));
        assert_eq!(cell(Vec3::new(-0.5, 0.5, 1.5), 1.0), IVec3::new(-1, 0, 1));
    }
}
