//! Where light changed: marks of validation deposits in cells of the world, coarse and fine.
//!
//! A cell is about 16 pixels wide where the eye sees it directly, whatever mirrors show it. Each mark also counts in the
//! coarser cells around it, so that a place is judged by the smallest cell that knows enough. Edges are powers of two;
//! cells of all sizes share one hash table.

use crate::gather::photons_grid::{cell, hash};
use crate::interface::frame::FrameParams;
use crate::interface::history::VALIDATION_CELLS;
use crate::math::PI;
use crate::seam::Atomics;
use spirv_std::glam::Vec3;

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

/// Edge of the finest cell over the radius of a point seen directly: 16 pixels of sqrt(pi) radii each, about.
const RADII_PER_EDGE: f32 = 32.0;
/// Sizes of cells, each twice the one before.
const SIZES: u32 = 10;
/// Marks that a cell must have to judge.
const ENOUGH: u32 = 8;
/// Change that counts as one.
const UNIT: f32 = 256.0;

/// Radius [m] of a collection point at a position, seen directly and head on.
#[inline(always)]
pub fn direct_radius(position: Vec3, params: &FrameParams) -> f32 {
    let distance = (position - params.camera.position).length();
    params.radius_px * params.pixel_spread * distance * (1.0 / PI).sqrt()
}

/// Biased exponent of the edge of the finest cell at a position.
#[inline(always)]
fn finest(position: Vec3, params: &FrameParams) -> u32 {
    let exponent = (RADII_PER_EDGE * direct_radius(position, params)).to_bits() >> 23;
    exponent.clamp(1, 253 - SIZES)
}

/// Slot of the cell whose edge has this exponent.
#[inline(always)]
fn slot(position: Vec3, exponent: u32) -> u32 {
    let here = cell(position, f32::from_bits(exponent << 23));
    hash(here, u32::MAX).wrapping_add(exponent.wrapping_mul(0x9e37_79b1)) & (VALIDATION_CELLS - 1)
}

/// Marks a place where a deposit changed by a share in [0, 1].
#[inline(always)]
pub fn mark<A: Atomics>(cells: &mut A, position: Vec3, change: f32, params: &FrameParams) {
    let exponent = finest(position, params);
    let units = (change * UNIT + 0.5) as u32;
    let mut size = 0;
    while size < SIZES {
        let slot = slot(position, exponent + size);
        cells.add(2 * slot, 1);
        if units != 0 {
            cells.add(2 * slot + 1, units);
        }
        size += 1;
    }
}

/// Share in [0, 1] by which the light at a place changed: the mean of the marks in the smallest cell with enough of them,
/// else in the largest; 0 where there are none.
#[inline(always)]
pub fn change(cells: &[u32], position: Vec3, params: &FrameParams) -> f32 {
    let exponent = finest(position, params);
    let (mut marks, mut units) = (0, 0);
    let mut size = 0;
    while size < SIZES && marks < ENOUGH {
        let slot = slot(position, exponent + size);
        marks = cells[2 * slot as usize];
        units = cells[2 * slot as usize + 1];
        size += 1;
    }
    if marks == 0 { 0.0 } else { units as f32 / (marks as f32 * UNIT) }
}
