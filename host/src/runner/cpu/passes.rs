//! The passes by name: what each reads and writes, and the kernel it maps over indices.

use caustics_kernels::gather::Neighbours;
use caustics_kernels::gather::brute::Brute;
use caustics_kernels::gather::photons_grid::PhotonsGrid;
use caustics_kernels::gather::receive::Store;
use caustics_kernels::interface::counters::{Counter, DepositState};
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::needs::Needs;
use caustics_kernels::interface::point::{
    DepositGeometry, DepositLight, PointBox, PointGeometry, PointShading,
};
use caustics_kernels::interface::scene::SceneTables;
use caustics_kernels::interface::step::{EmitStep, SampleStep, ScatterIn, ScatterOut};
use caustics_kernels::light::power::ByPower;
use caustics_kernels::math::ray::{Hit, Ray};
use caustics_kernels::pass::{self, grid};
use caustics_kernels::seam::{AtomicWords, Atomics, ScatterSlots};
use caustics_kernels::trace::Tracer;
use caustics_kernels::trace::bvh::BvhTracer;
use glam::Vec3;
use rayon::prelude::*;

use super::counters::LocalCounters;
use super::memory::Memory;

/// One dispatch.
pub struct Call<'a> {
    /// Buffers.
    pub memory: &'a Memory,
    /// Invocations.
    pub count: u32,
    /// Push constants.
    pub params: &'a FrameParams,
    /// What the scene needs.
    pub needs: Needs,
}

type Pass = fn(&Call<'_>) -> anyhow::Result<()>;

/// The pass of this name.
pub fn find(name: &str) -> Option<Pass> {
    PASSES.iter().find(|(known, _)| *known == name).map(|(_, pass)| *pass)
}

const PASSES: &[(&str, Pass)] = &[
    ("collect", collect),
    ("bound", bound),
    ("shoot.store", shoot_store),
    ("grid.survey", grid_survey),
    ("grid.size", grid_size),
    ("grid.count", grid_count),
    ("grid.reserve", grid_reserve),
    ("grid.fill", grid_fill),
    ("gather.photons_grid", gather_photons_grid),
    ("gather.brute", gather_brute),
    ("resolve", resolve),
    ("display", display),
    ("step.sample", step_sample),
    ("step.hit", step_hit),
    ("step.scatter", step_scatter),
    ("step.emit", step_emit),
];

/// Light paths or elements that a worker takes at a time.
const CHUNK: usize = 512;

/// Borrows the scene's tables under the names that `SceneTables` has.
macro_rules! scene {
    ($call:expr, $scene:ident) => {
        let triangles = $call.memory.read("triangles")?;
        let surfaces = $call.memory.read("surfaces")?;
        let materials = $call.memory.read("materials")?;
        let lights = $call.memory.read("lights")?;
        let $scene = SceneTables {
            triangles: &triangles,
            surfaces: &surfaces,
            materials: &materials,
            lights: &lights,
        };
    };
}

/// Borrows the software tree.
macro_rules! tracer {
    ($call:expr, $tracer:ident) => {
        let nodes = $call.memory.read("nodes")?;
        let blocks = $call.memory.read("blocks")?;
        let $tracer = BvhTracer { nodes: &nodes, blocks: &blocks };
    };
}

fn collect(call: &Call<'_>) -> anyhow::Result<()> {
    scene!(call, scene);
    tracer!(call, tracer);
    let mut radiance = call.memory.edit::<Vec3>("path_radiance")?;
    let mut geometry = call.memory.edit::<PointGeometry>("point_geometry")?;
    let mut shading = call.memory.edit::<PointShading>("point_shading")?;
    let mut counters = call.memory.edit::<u32>("counters")?;
    let counters = AtomicWords::new(&mut counters);
    let width = call.params.width as usize;
    let rows = radiance
        .par_chunks_mut(width)
        .zip(geometry.par_chunks_mut(width))
        .zip(shading.par_chunks_mut(width))
        .enumerate();
    rows.for_each(|(row, ((radiance, geometry), shading))| {
        let mut counters = LocalCounters::new(counters);
        let mut tracer = tracer;
        for x in 0..width {
            let pixel = (row * width + x) as u32;
            let collected =
                pass::collect::collect(pixel, call.params, call.needs, scene, &mut tracer, &mut counters);
            radiance[x] = collected.radiance;
            geometry[x] = collected.geometry;
            shading[x] = collected.shading;
        }
    });
    Ok(())
}

fn bound(call: &Call<'_>) -> anyhow::Result<()> {
    let order = call.memory.read::<u32>("pixel_order")?;
    let geometry = call.memory.read::<PointGeometry>("point_geometry")?;
    let (order, geometry) = (&order[..], &geometry[..]);
    let mut boxes = call.memory.edit::<PointBox>("point_boxes")?;
    boxes
        .par_iter_mut()
        .zip(order)
        .for_each(|(out, &pixel)| *out = pass::bound::bound(&geometry[pixel as usize]));
    Ok(())
}

fn shoot_store(call: &Call<'_>) -> anyhow::Result<()> {
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
    let emit =
        ByPower { lights: scene.lights, light_count: params.light_count, triangles: scene.triangles, needs };
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

fn grid_survey(call: &Call<'_>) -> anyhow::Result<()> {
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

fn grid_size(call: &Call<'_>) -> anyhow::Result<()> {
    let histogram = call.memory.read::<u32>("radius_histogram")?;
    call.memory.edit::<u32>("deposit_state")?[DepositState::CellSize as usize] = grid::size(&histogram);
    Ok(())
}

fn grid_count(call: &Call<'_>) -> anyhow::Result<()> {
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

fn grid_reserve(call: &Call<'_>) -> anyhow::Result<()> {
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

fn grid_fill(call: &Call<'_>) -> anyhow::Result<()> {
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

fn gather_photons_grid(call: &Call<'_>) -> anyhow::Result<()> {
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

fn gather_brute(call: &Call<'_>) -> anyhow::Result<()> {
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

fn resolve(call: &Call<'_>) -> anyhow::Result<()> {
    let geometry = call.memory.read::<PointGeometry>("point_geometry")?;
    let shading = call.memory.read::<PointShading>("point_shading")?;
    let accumulator = call.memory.read::<u32>("accumulator")?;
    let (geometry, shading, accumulator) = (&geometry[..], &shading[..], &accumulator[..]);
    map(call, "caustic_radiance", |i| {
        let (geometry, shading) = (&geometry[i as usize], &shading[i as usize]);
        pass::resolve::resolve(i, geometry, shading, accumulator, call.params)
    })
}

fn display(call: &Call<'_>) -> anyhow::Result<()> {
    let path = call.memory.read::<Vec3>("path_radiance")?;
    let caustic = call.memory.read::<Vec3>("caustic_radiance")?;
    let (path, caustic) = (&path[..], &caustic[..]);
    map(call, "display_color", |i| {
        pass::display::display(path[i as usize] + caustic[i as usize], call.params.exposure)
    })
}

fn step_sample(call: &Call<'_>) -> anyhow::Result<()> {
    map::<SampleStep>(call, "samples", |i| pass::step::sample(i, call.params))
}

fn step_hit(call: &Call<'_>) -> anyhow::Result<()> {
    tracer!(call, tracer);
    let rays = call.memory.read::<Ray>("rays")?;
    let rays = &rays[..];
    map::<Hit>(call, "hits", |i| { tracer }.closest(&rays[i as usize]))
}

fn step_scatter(call: &Call<'_>) -> anyhow::Result<()> {
    scene!(call, scene);
    let input = call.memory.read::<ScatterIn>("scatter_in")?;
    let input = &input[..];
    map::<ScatterOut>(call, "scatter_out", |i| {
        pass::step::scatter(&input[i as usize], call.params, call.needs, scene)
    })
}

fn step_emit(call: &Call<'_>) -> anyhow::Result<()> {
    scene!(call, scene);
    let (lights, triangles) = (scene.lights, scene.triangles);
    let emit = ByPower { lights, light_count: call.params.light_count, triangles, needs: call.needs };
    map::<EmitStep>(call, "emit_steps", |i| pass::step::emit(i, call.params, call.needs, scene, &emit))
}

/// Writes `kernel(index)` into each element of `buffer` below the dispatch's count.
fn map<T: bytemuck::Pod + Send>(
    call: &Call<'_>,
    buffer: &str,
    kernel: impl Fn(u32) -> T + Sync,
) -> anyhow::Result<()> {
    let mut out = call.memory.edit::<T>(buffer)?;
    let out = &mut out[..call.count as usize];
    out.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
        for (offset, out) in out.iter_mut().enumerate() {
            *out = kernel((chunk * CHUNK + offset) as u32);
        }
    });
    Ok(())
}

/// Calls `work` with consecutive ranges of the indices below `count`, in parallel.
fn for_chunks(count: u32, work: impl Fn(std::ops::Range<u32>) + Sync) {
    let chunk = CHUNK as u32;
    (0..count.div_ceil(chunk)).into_par_iter().for_each(|i| work(i * chunk..(i * chunk + chunk).min(count)));
}
