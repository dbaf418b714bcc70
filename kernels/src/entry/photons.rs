//! Entry points of the gathers over photons.

use crate::entry::index;
use crate::gather::brute::Brute;
use crate::gather::photons_grid::PhotonsGrid;
use crate::interface::counters::DepositState;
use crate::interface::frame::FrameParams;
use crate::interface::material::Material;
use crate::interface::needs::Needs;
use crate::interface::point::{DepositGeometry, DepositLight, PointGeometry, PointShading};
use crate::pass::gather_photons::gather_photons;
use crate::pass::grid;
use crate::seam::{AtomicWords, ScatterSlots};
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// Counts the points' radii.
#[spirv(compute(threads(64), entry_point_name = "grid.survey"))]
pub fn grid_survey(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] point_geometry: &[PointGeometry],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] radius_histogram: &mut [u32],
) {
    let index = index(id);
    if index < params.pixel_count() {
        grid::survey(&point_geometry[index as usize], &mut AtomicWords(radius_histogram));
    }
}

/// Chooses the cell size; one invocation.
#[spirv(compute(threads(64), entry_point_name = "grid.size"))]
pub fn grid_size(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] radius_histogram: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] deposit_state: &mut [u32],
) {
    if index(id) == 0 {
        deposit_state[DepositState::CellSize as usize] = grid::size(radius_histogram);
    }
}

/// Counts the deposits of each cell.
#[spirv(compute(threads(64), entry_point_name = "grid.count"))]
pub fn grid_count(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] deposit_geometry: &[DepositGeometry],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] deposit_state: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] cell_counts: &mut [u32],
) {
    let index = index(id);
    if index < grid::deposit_count(deposit_state, params) {
        let size = deposit_state[DepositState::CellSize as usize];
        grid::count(&deposit_geometry[index as usize], size, params, &mut AtomicWords(cell_counts));
    }
}

/// Reserves a range for each cell.
#[spirv(compute(threads(64), entry_point_name = "grid.reserve"))]
pub fn grid_reserve(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] deposit_state: &mut [u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] cell_counts: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] cell_starts: &mut [u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] cell_ends: &mut [u32],
) {
    let index = index(id);
    if index <= params.cell_mask {
        let i = index as usize;
        let start = grid::reserve(cell_counts[i], &mut AtomicWords(deposit_state));
        cell_starts[i] = start;
        cell_ends[i] = start;
    }
}

/// Sorts the deposits into their cells.
#[spirv(compute(threads(64), entry_point_name = "grid.fill"))]
pub fn grid_fill(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] deposit_geometry: &[DepositGeometry],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] deposit_light: &[DepositLight],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] deposit_state: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] cell_ends: &mut [u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] sorted_geometry: &mut [DepositGeometry],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] sorted_light: &mut [DepositLight],
) {
    let index = index(id);
    if index < grid::deposit_count(deposit_state, params) {
        let i = index as usize;
        grid::fill(
            &deposit_geometry[i],
            &deposit_light[i],
            deposit_state[DepositState::CellSize as usize],
            params,
            &mut AtomicWords(cell_ends),
            &mut ScatterSlots(sorted_geometry),
            &mut ScatterSlots(sorted_light),
        );
    }
}

/// Gathers from the grid, a point an invocation.
#[spirv(compute(threads(64), entry_point_name = "gather.photons_grid"))]
pub fn gather_photons_grid(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] materials: &[Material],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] pixel_order: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] point_geometry: &[PointGeometry],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] point_shading: &[PointShading],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] deposit_state: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] sorted_geometry: &[DepositGeometry],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] sorted_light: &[DepositLight],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] cell_starts: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] cell_ends: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] accumulator: &mut [u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 10)] counters: &mut [u32],
) {
    let index = index(id);
    if index < params.pixel_count() {
        let pixel = pixel_order[index as usize];
        let mut grid = PhotonsGrid {
            sorted_geometry,
            cell_starts,
            cell_ends,
            cell_mask: params.cell_mask,
            cell_size: f32::from_bits(deposit_state[DepositState::CellSize as usize]),
            count: grid::deposit_count(deposit_state, params),
        };
        gather_photons(
            pixel,
            params,
            Needs(needs),
            materials,
            point_geometry[pixel as usize],
            point_shading[pixel as usize],
            sorted_geometry,
            sorted_light,
            &mut grid,
            &mut AtomicWords(accumulator),
            &mut AtomicWords(counters),
        );
    }
}

/// Gathers by brute force, a point an invocation.
#[spirv(compute(threads(64), entry_point_name = "gather.brute"))]
pub fn gather_brute(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] materials: &[Material],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] point_geometry: &[PointGeometry],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] point_shading: &[PointShading],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] deposit_state: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] deposit_geometry: &[DepositGeometry],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] deposit_light: &[DepositLight],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] accumulator: &mut [u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] counters: &mut [u32],
) {
    let pixel = index(id);
    if pixel < params.pixel_count() {
        gather_photons(
            pixel,
            params,
            Needs(needs),
            materials,
            point_geometry[pixel as usize],
            point_shading[pixel as usize],
            deposit_geometry,
            deposit_light,
            &mut Brute { count: grid::deposit_count(deposit_state, params) },
            &mut AtomicWords(accumulator),
            &mut AtomicWords(counters),
        );
    }
}
