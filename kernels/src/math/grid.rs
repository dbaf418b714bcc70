//! Regular grids in space.

use super::clamp;
use spirv_std::glam::{IVec3, Vec3};

/// Cell of a position. Far positions are clamped to the outermost cells.
#[inline(always)]
pub fn cell(position: Vec3, cell_size: f32) -> IVec3 {
    // The size is a power of two, so its inverse is exact. Truncation rounds up below zero: step back.
    let inverse = 1.0 / cell_size;
    let index = |x: f32| {
        let scaled = clamp(x * inverse, -1.0e9, 1.0e9);
        let truncated = scaled as i32;
        if truncated as f32 > scaled { truncated - 1 } else { truncated }
    };
    IVec3::new(index(position.x), index(position.y), index(position.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_far_away_do_not_overflow() {
        assert_eq!(cell(Vec3::splat(1.0e30), 1.0e-6), IVec3::splat(1_000_000_000));
        assert_eq!(cell(Vec3::new(-0.5, 0.5, 1.5), 1.0), IVec3::new(-1, 0, 1));
    }
}
