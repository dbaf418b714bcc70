//! The passes over light paths.

use caustics_kernels::gather::receive::Store;
use caustics_kernels::interface::counters::Counter;
use caustics_kernels::interface::point::{DepositGeometry, DepositLight};
use caustics_kernels::light::power::ByPower;
use caustics_kernels::pass;
use caustics_kernels::seam::{AtomicWords, Atomics, ScatterSlots};

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
        let mut store = Store { geometry, light, state, capacity };
        let mut tracer = tracer;
        let mut dropped = 0;
        for index in indices {
            dropped += pass::shoot::shoot(
                index,
                params,
                needs,
                scene,
                &emit,
                &mut tracer,
                &mut store,
                &mut counters,
            );
        }
        counters.add(Counter::DepositsDropped as u32, dropped);
    });
    Ok(())
}
