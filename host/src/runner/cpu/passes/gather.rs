//! The passes of any gather variant.

use anyhow::Context;
use caustics_kernels::gather::tables::{Build, Tables};
use caustics_kernels::gather::variant::{GatherOne, Side, Variant};
use caustics_kernels::interface::point::{DepositGeometry, DepositLight};
use caustics_kernels::pass;
use caustics_kernels::pass::gather::{deposit_count, stage_count};
use caustics_kernels::seam::{AtomicWords, ScatterSlots};

use super::super::counters::LocalCounters;
use super::{Call, for_chunks};

/// A stage of building an index.
pub fn build(call: &Call<'_>, gather: &Variant) -> anyhow::Result<()> {
    let memory = call.memory;
    let pixel_order = memory.read("pixel_order")?;
    let point_geometry = memory.read("point_geometry")?;
    let state = memory.read::<u32>("deposit_state")?;
    let deposit_geometry = memory.read("deposit_geometry")?;
    let deposit_light = memory.read("deposit_light")?;
    let mut sorted_geometry = memory.edit::<DepositGeometry>("sorted_geometry")?;
    let mut sorted_light = memory.edit::<DepositLight>("sorted_light")?;
    let mut words =
        [memory.edit("index_0")?, memory.edit("index_1")?, memory.edit("index_2")?, memory.edit("index_3")?];
    let [index_0, index_1, index_2, index_3] = words.each_mut().map(|words| AtomicWords::new(words));
    let (sorted_geometry, sorted_light) =
        (ScatterSlots::new(&mut sorted_geometry), ScatterSlots::new(&mut sorted_light));
    let deposit_count = deposit_count(&state, call.params);
    let (pixel_order, point_geometry) = (&pixel_order[..], &point_geometry[..]);
    let (deposit_geometry, deposit_light) = (&deposit_geometry[..], &deposit_light[..]);
    for_chunks(stage_count(call.params, deposit_count).min(call.count), |indices| {
        let mut build = Build {
            params: call.params,
            pixel_order,
            point_geometry,
            deposit_geometry,
            deposit_light,
            deposit_count,
            index_0,
            index_1,
            index_2,
            index_3,
            sorted_geometry,
            sorted_light,
        };
        indices.for_each(|index| (gather.cpu.build)(call.params.part, index, &mut build));
    });
    Ok(())
}

/// The gather.
pub fn gather(call: &Call<'_>, gather: &Variant) -> anyhow::Result<()> {
    let one = gather.cpu.gather.with_context(|| format!("{} needs ray queries", gather.name))?;
    each(call, gather.sorts, gather.side, one)
}

/// Splats deposits as Kim does.
pub fn splat_kim2019(call: &Call<'_>) -> anyhow::Result<()> {
    each(call, false, Side::Points, |index, tables, mut counters| {
        pass::splat::kim2019(index, tables, &mut counters);
    })
}

/// Calls a function for each deposit, or for each point.
fn each(call: &Call<'_>, sorts: bool, side: Side, one: GatherOne) -> anyhow::Result<()> {
    let memory = call.memory;
    let deposits =
        if sorts { ["sorted_geometry", "sorted_light"] } else { ["deposit_geometry", "deposit_light"] };
    let state = memory.read::<u32>("deposit_state")?;
    let deposit_count = deposit_count(&state, call.params);
    let tables = (
        memory.read("materials")?,
        memory.read("pixel_order")?,
        memory.read("point_geometry")?,
        memory.read("point_shading")?,
        memory.read(deposits[0])?,
        memory.read(deposits[1])?,
    );
    let words =
        [memory.read("index_0")?, memory.read("index_1")?, memory.read("index_2")?, memory.read("index_3")?];
    let mut accumulator = memory.edit::<u32>("accumulator")?;
    let mut counters = memory.edit::<u32>("counters")?;
    let tables = Tables {
        params: call.params,
        needs: call.needs,
        materials: &tables.0,
        pixel_order: &tables.1,
        point_geometry: &tables.2,
        point_shading: &tables.3,
        deposit_geometry: &tables.4,
        deposit_light: &tables.5,
        deposit_count,
        index_0: &words[0],
        index_1: &words[1],
        index_2: &words[2],
        index_3: &words[3],
        accumulator: AtomicWords::new(&mut accumulator),
    };
    let counters = AtomicWords::new(&mut counters);
    let count = if side == Side::Points { deposit_count } else { call.count };
    for_chunks(count, |indices| {
        let mut tables = tables;
        let mut counters = LocalCounters::new(counters);
        indices.for_each(|index| one(index, &mut tables, &mut counters));
    });
    Ok(())
}
