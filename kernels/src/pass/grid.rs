//! The build of `photons_grid`: `grid.survey` (radii), `grid.size`, `grid.count`, `grid.reserve`, `grid.fill`.
//! The order of deposits in a cell is free, because sums are integers.

use crate::gather::photons_grid::{cell, cell_size, hash, radius_bin};
use crate::interface::counters::DepositState;
use crate::interface::frame::FrameParams;
use crate::interface::point::{DepositGeometry, DepositLight, PointGeometry};
use crate::seam::{Atomics, Scatter};

/// Deposits there are: those stored, as far as they fit.
#[inline(always)]
pub fn deposit_count(deposit_state: &[u32], params: &FrameParams) -> u32 {
    deposit_state[DepositState::Stored as usize].min(params.deposit_capacity)
}

/// `grid.survey`: counts a point's radius in its bin.
#[inline(always)]
pub fn survey<A: Atomics>(point: &PointGeometry, radius_histogram: &mut A) {
    if point.depth != 0 {
        radius_histogram.add(radius_bin(point.radius), 1);
    }
}

/// `grid.size`: bits of the cell size [m] for the radii surveyed.
#[inline(always)]
pub fn size(radius_histogram: &[u32]) -> u32 {
    cell_size(radius_histogram).to_bits()
}

/// Slot of a deposit's cell.
#[inline(always)]
fn slot(deposit: &DepositGeometry, cell_size_bits: u32, params: &FrameParams) -> u32 {
    hash(cell(deposit.position, f32::from_bits(cell_size_bits)), params.cell_mask)
}

/// `grid.count`: counts a deposit in its cell.
#[inline(always)]
pub fn count<A: Atomics>(
    deposit: &DepositGeometry,
    cell_size_bits: u32,
    params: &FrameParams,
    cell_counts: &mut A,
) {
    cell_counts.add(slot(deposit, cell_size_bits, params), 1);
}

/// `grid.reserve`: the first slot of a cell's deposits.
#[inline(always)]
pub fn reserve<A: Atomics>(cell_count: u32, deposit_state: &mut A) -> u32 {
    if cell_count == 0 { 0 } else { deposit_state.add(DepositState::Reserved as u32, cell_count) }
}

/// `grid.fill`: moves a deposit to its cell's range; `cell_ends` starts at the range's first slot and ends at its end.
#[inline(always)]
pub fn fill<A: Atomics, G: Scatter<DepositGeometry>, L: Scatter<DepositLight>>(
    deposit: &DepositGeometry,
    light: &DepositLight,
    cell_size_bits: u32,
    params: &FrameParams,
    cell_ends: &mut A,
    sorted_geometry: &mut G,
    sorted_light: &mut L,
) {
    let to = cell_ends.add(slot(deposit, cell_size_bits, params), 1);
    sorted_geometry.write(to, *deposit);
    sorted_light.write(to, *light);
}
