//! Where light changed: marks of validation deposits in cells of the world, coarse and fine.
//!
//! A cell is about 16 pixels wide where the eye sees it directly, whatever mirrors show it. Each mark also counts in the
//! coarser cells around it, so that a place is judged by the smallest cell that knows enough. A mesh that moves has cells of
//! its own: what lies on it may rest while all around it changes. Edges are powers of two; all cells share one hash table.

use crate::gather::photons_grid::{cell, hash};
use crate::interface::frame::FrameParams;
use crate::interface::history::VALIDATION_CELLS;
use crate::math::PI;
use crate::seam::Atomics;
use spirv_std::glam::Vec3;

#[cfg(target_arch = "spirv")]
use spirv_std::num_traits::Float;

/// Words of a cell: marks, light lost and way moved in 1/256.
pub const WORDS: u32 = 3;
/// Edge of the finest cell over the radius of a point seen directly: 16 pixels of sqrt(pi) radii each, about.
const RADII_PER_EDGE: f32 = 32.0;
/// Sizes of cells, each twice the one before.
const SIZES: u32 = 10;
/// Marks that a cell must have to judge.
const ENOUGH: u32 = 8;
/// What counts as one.
const UNIT: f32 = 256.0;
/// Longest way that is told from longer ones [radii of a point seen directly].
const LONGEST: f32 = 16.0;

/// How deposits changed from one frame to the next; both are means over the deposits of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Share of the light that is gone, or came from nowhere, in [0, 1].
    pub lost: f32,
    /// How far the rest moved [radii of a point seen directly].
    pub moved: f32,
    /// Marks for each point's disc: validation deposits that a point can expect.
    pub density: f32,
}

/// What moves with the light that is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Carrier(u32);

impl Carrier {
    /// The instance, which carries its light along; for the world, the world.
    #[inline(always)]
    pub fn instance(instance: u32) -> Carrier {
        Carrier(2 * instance)
    }

    /// Nothing: the instance moves below light that stays where it is in the world.
    #[inline(always)]
    pub fn world_below(instance: u32) -> Carrier {
        Carrier(2 * instance + 1)
    }
}

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

/// First word of the cell whose edge has this exponent.
#[inline(always)]
fn slot(position: Vec3, carrier: Carrier, exponent: u32) -> u32 {
    let here = cell(position, f32::from_bits(exponent << 23));
    let key = exponent.wrapping_mul(0x9e37_79b1) ^ carrier.0.wrapping_mul(0xc2b2_ae35);
    WORDS * (hash(here, u32::MAX).wrapping_add(key ^ (key >> 16)) & (VALIDATION_CELLS - 1))
}

/// Marks a place where a deposit lost a share in [0, 1] of its light, or moved by so many radii.
#[inline(always)]
pub fn mark<A: Atomics>(
    cells: &mut A,
    position: Vec3,
    carrier: Carrier,
    lost: f32,
    moved: f32,
    params: &FrameParams,
) {
    let exponent = finest(position, params);
    let lost = (lost * UNIT + 0.5) as u32;
    let moved = (moved.min(LONGEST) * UNIT + 0.5) as u32;
    let mut size = 0;
    while size < SIZES {
        let slot = slot(position, carrier, exponent + size);
        cells.add(slot, 1);
        if lost != 0 {
            cells.add(slot + 1, lost);
        }
        if moved != 0 {
            cells.add(slot + 2, moved);
        }
        size += 1;
    }
}

/// How light changed at a place: by the smallest cell with enough marks, else by the largest; not at all without a mark.
#[inline(always)]
pub fn change(cells: &[u32], position: Vec3, carrier: Carrier, params: &FrameParams) -> Change {
    let exponent = finest(position, params);
    let mut first = 0;
    let mut marks = 0;
    let mut size = 0;
    while size < SIZES && marks < ENOUGH {
        first = slot(position, carrier, exponent + size) as usize;
        marks = cells[first];
        size += 1;
    }
    if marks == 0 {
        return Change::default();
    }
    let per_mark = 1.0 / (marks as f32 * UNIT);
    let edge = f32::from_bits((exponent + size - 1) << 23);
    let disc = direct_radius(position, params);
    Change {
        lost: cells[first + 1] as f32 * per_mark,
        moved: cells[first + 2] as f32 * per_mark,
        density: marks as f32 * (PI * disc / edge) * (disc / edge),
    }
}
