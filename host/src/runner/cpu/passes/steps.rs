//! The single steps of the twin tests.

use caustics_kernels::interface::step::{EmitStep, SampleStep, ScatterIn, ScatterOut};
use caustics_kernels::light::power::ByPower;
use caustics_kernels::math::ray::{Hit, Ray};
use caustics_kernels::pass;
use caustics_kernels::trace::Tracer;

use rayon::prelude::*;

use super::{CHUNK, Call, map, scene, textures, tracer};

/// Random numbers and warps.
pub fn step_sample(call: &Call<'_>) -> anyhow::Result<()> {
    map::<SampleStep>(call, "samples", |i| pass::step::sample(i, call.params))
}

/// Closest hits.
pub fn step_hit(call: &Call<'_>) -> anyhow::Result<()> {
    tracer!(call, tracer);
    let rays = call.memory.read::<Ray>("rays")?;
    let mut hits = call.memory.edit::<Hit>("hits")?;
    let count = call.count as usize;
    // A tracer a chunk: a copy for each ray would take a sixth of the time.
    let chunks = hits[..count].par_chunks_mut(CHUNK).zip(rays[..count].par_chunks(CHUNK));
    chunks.for_each(|(hits, rays)| {
        let mut tracer = tracer;
        hits.iter_mut().zip(rays).for_each(|(hit, ray)| *hit = tracer.closest(ray));
    });
    Ok(())
}

/// Scattering events.
pub fn step_scatter(call: &Call<'_>) -> anyhow::Result<()> {
    scene!(call, scene);
    let input = call.memory.read::<ScatterIn>("scatter_in")?;
    let input = &input[..];
    map::<ScatterOut>(call, "scatter_out", |i| {
        pass::step::scatter(&input[i as usize], call.params, call.needs, scene)
    })
}

/// Starts of light paths.
pub fn step_emit(call: &Call<'_>) -> anyhow::Result<()> {
    scene!(call, scene);
    let emit = ByPower { scene, light_count: call.params.light_count, needs: call.needs };
    map::<EmitStep>(call, "emit_steps", |i| pass::step::emit(i, call.params, call.needs, scene, &emit))
}
