//! The passes over light paths and deposits.

use caustics_kernels::gather::Neighbours;
use caustics_kernels::gather::brute::Brute;
use caustics_kernels::gather::photons_grid::PhotonsGrid;
use caustics_kernels::gather::receive::Store;
use caustics_kernels::interface::counters::{Counter, DepositState};
use caustics_kernels::interface::point::{DepositGeometry, DepositLight, PointGeometry, PointShading};
use caustics_kernels::light::power::ByPower;
use caustics_kernels::pass;
use caustics_kernels::pass::grid;
use caustics_kernels::seam::{AtomicWords, Atomics, ScatterSlots};
use rayon::prelude::*;

use super::super::counters::LocalCounters;
use super::{Call, for_chunks, scene, textures, tracer};

/// Light paths; deposits are stored.
pub fn shoot_store(call: &Call<'_>) -> anyhow::Result<()> {
    scene!(call, scene);
    tracer!(call, tracer);
    let mut geometry = call.memory.edit::<DepositGeometry>("deposit_geometry")?;
    let mut light = call.memory.edit::<DepositLight>("deposit_light")?;
    let mut state = call.memory.edit::<u32>("deposit_state")?;
    let mut counters = call.memory.edit::<u32>("counters")?;
    let geometry = ScatterSlots::new(&mut geometry);
    let light = ScatterSlots::new(&mut light);
    let state = AtomicWords::new(&mut state);
    let counters = AtomicWords::new(&mut counters);
    let (params, needs) = (call.params, call.needs);
    let emit = ByPower { scene, light_count: params.light_count, needs };
    for_chunks(call.count, |indices| {
        let mut counters = LocalCounters::new(counters);
        let capacity = params.deposit_capacity;
        let mut store = Store { geometry, light, state, capacity, dropped: 0 };
        let mut tracer = tracer;
        let points = &mut Brute { count: 0 };
        for index in indices {
            pass::shoot::shoot(
                index,
                params,
                needs,
                scene,
                &emit,
                &mut tracer,
                points,
                &mut store,
                &mut counters,
            );
        }
        counters.add(Counter::DepositsDropped as u32, store.dropped);
    });
    Ok(())
}

/// Counts radii.
pub fn grid_survey(call: &Call<'_>) -> anyhow::Result<()> {
    let geometry = call.memory.read::<PointGeometry>("point_geometry")?;
    let geometry = &geometry[..];
    let mut histogram = call.memory.edit::<u32>("radius_histogram")?;
    let histogram = AtomicWords::new(&mut histogram);
    for_chunks(call.count, |indices| {
        let mut histogram = histogram;
        indices.for_each(|i| grid::survey(&geometry[i as usize], &mut histogram));
    });
    Ok(())
}

/// Chooses the cell size.
pub fn grid_size(call: &Call<'_>) -> anyhow::Result<()> {
    let histogram = call.memory.read::<u32>("radius_histogram")?;
    call.memory.edit::<u32>("deposit_state")?[DepositState::CellSize as usize] = grid::size(&histogram);
    Ok(())
}

/// Counts deposits of cells.
pub fn grid_count(call: &Call<'_>) -> anyhow::Result<()> {
    let geometry = call.memory.read::<DepositGeometry>("deposit_geometry")?;
    let state = call.memory.read::<u32>("deposit_state")?;
    let mut counts = call.memory.edit::<u32>("cell_counts")?;
    let (geometry, size) = (&geometry[..], state[DepositState::CellSize as usize]);
    let counts = AtomicWords::new(&mut counts);
    for_chunks(grid::deposit_count(&state, call.params), |indices| {
        let mut counts = counts;
        indices.for_each(|i| grid::count(&geometry[i as usize], size, call.params, &mut counts));
    });
    Ok(())
}

/// Reserves ranges of cells.
pub fn grid_reserve(call: &Call<'_>) -> anyhow::Result<()> {
    let counts = call.memory.read::<u32>("cell_counts")?;
    let counts = &counts[..];
    let mut state = call.memory.edit::<u32>("deposit_state")?;
    let mut starts = call.memory.edit::<u32>("cell_starts")?;
    let mut ends = call.memory.edit::<u32>("cell_ends")?;
    let state = AtomicWords::new(&mut state);
    starts.par_iter_mut().zip(ends.par_iter_mut()).zip(counts).for_each(|((start, end), &count)| {
        *start = grid::reserve(count, &mut { state });
        *end = *start;
    });
    Ok(())
}

/// Sorts deposits into cells.
pub fn grid_fill(call: &Call<'_>) -> anyhow::Result<()> {
    let geometry = call.memory.read::<DepositGeometry>("deposit_geometry")?;
    let light = call.memory.read::<DepositLight>("deposit_light")?;
    let state = call.memory.read::<u32>("deposit_state")?;
    let mut ends = call.memory.edit::<u32>("cell_ends")?;
    let mut sorted_geometry = call.memory.edit::<DepositGeometry>("sorted_geometry")?;
    let mut sorted_light = call.memory.edit::<DepositLight>("sorted_light")?;
    let (geometry, light, size) = (&geometry[..], &light[..], state[DepositState::CellSize as usize]);
    let ends = AtomicWords::new(&mut ends);
    let sorted_geometry = ScatterSlots::new(&mut sorted_geometry);
    let sorted_light = ScatterSlots::new(&mut sorted_light);
    for_chunks(grid::deposit_count(&state, call.params), |indices| {
        let (mut ends, mut to_geometry, mut to_light) = (ends, sorted_geometry, sorted_light);
        for i in indices {
            let (geometry, light) = (&geometry[i as usize], &light[i as usize]);
            grid::fill(geometry, light, size, call.params, &mut ends, &mut to_geometry, &mut to_light);
        }
    });
    Ok(())
}

/// Gathers from the grid.
pub fn gather_photons_grid(call: &Call<'_>) -> anyhow::Result<()> {
    let geometry = call.memory.read::<DepositGeometry>("sorted_geometry")?;
    let light = call.memory.read::<DepositLight>("sorted_light")?;
    let starts = call.memory.read::<u32>("cell_starts")?;
    let ends = call.memory.read::<u32>("cell_ends")?;
    let state = call.memory.read::<u32>("deposit_state")?;
    let grid = PhotonsGrid {
        sorted_geometry: &geometry,
        cell_starts: &starts,
        cell_ends: &ends,
        cell_mask: call.params.cell_mask,
        cell_size: f32::from_bits(state[DepositState::CellSize as usize]),
        count: grid::deposit_count(&state, call.params),
    };
    gather(call, &geometry, &light, grid)
}

/// Gathers by brute force.
pub fn gather_brute(call: &Call<'_>) -> anyhow::Result<()> {
    let geometry = call.memory.read::<DepositGeometry>("deposit_geometry")?;
    let light = call.memory.read::<DepositLight>("deposit_light")?;
    let state = call.memory.read::<u32>("deposit_state")?;
    gather(call, &geometry, &light, Brute { count: grid::deposit_count(&state, call.params) })
}

/// Gathers from the points' side through any `Neighbours` over photons.
fn gather<N: Neighbours + Copy + Send + Sync>(
    call: &Call<'_>,
    deposit_geometry: &[DepositGeometry],
    deposit_light: &[DepositLight],
    neighbours: N,
) -> anyhow::Result<()> {
    let materials = call.memory.read("materials")?;
    let geometry = call.memory.read::<PointGeometry>("point_geometry")?;
    let shading = call.memory.read::<PointShading>("point_shading")?;
    let mut accumulator = call.memory.edit::<u32>("accumulator")?;
    let mut counters = call.memory.edit::<u32>("counters")?;
    let (materials, geometry, shading) = (&materials[..], &geometry[..], &shading[..]);
    let accumulator = AtomicWords::new(&mut accumulator);
    let counters = AtomicWords::new(&mut counters);
    for_chunks(call.count, |indices| {
        let mut counters = LocalCounters::new(counters);
        let (mut accumulator, mut neighbours) = (accumulator, neighbours);
        for pixel in indices {
            pass::gather_photons::gather_photons(
                pixel,
                call.params,
                call.needs,
                materials,
                geometry[pixel as usize],
                shading[pixel as usize],
                deposit_geometry,
                deposit_light,
                &mut neighbours,
                &mut accumulator,
                &mut counters,
            );
        }
    });
    Ok(())
}
