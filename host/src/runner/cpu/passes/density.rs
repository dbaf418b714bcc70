//! The passes of light paths that follow a density map.

use caustics_kernels::interface::density::DensityTexel;
use caustics_kernels::light::by_density::ByDensity;
use caustics_kernels::light::power::ByPower;
use caustics_kernels::pass::density;
use caustics_kernels::pass::scatter_photons::Spread;
use caustics_kernels::pass::shoot::shoot;
use caustics_kernels::seam::AtomicWords;
use rayon::prelude::*;

use super::super::counters::LocalCounters;
use super::{CHUNK, Call, for_chunks, scene, textures, tracer};

/// New densities.
pub fn update(call: &Call<'_>) -> anyhow::Result<()> {
    let mut densities = call.memory.edit::<DensityTexel>("density")?;
    let tree = call.memory.read::<f32>("density_tree")?;
    let feedback = call.memory.read::<u32>("density_feedback")?;
    let (tree, feedback) = (&tree[..], &feedback[..]);
    let chunks = densities[..call.count as usize].par_chunks_mut(CHUNK).enumerate();
    chunks.for_each(|(chunk, densities)| {
        for (offset, texel) in densities.iter_mut().enumerate() {
            *texel = density::update((chunk * CHUNK + offset) as u32, texel, tree, feedback);
        }
    });
    Ok(())
}

/// A level of the pyramids: a few thousand sums, on one thread.
pub fn sum(call: &Call<'_>) -> anyhow::Result<()> {
    let densities = call.memory.read::<DensityTexel>("density")?;
    let mut tree = call.memory.edit::<f32>("density_tree")?;
    for node in 0..call.count {
        let (place, sum) = density::sum(node, call.params.part, &densities, &tree);
        tree[place as usize] = sum;
    }
    Ok(())
}

/// Light paths; deposits are spread over the picture.
pub fn shoot_yang2021(call: &Call<'_>) -> anyhow::Result<()> {
    scene!(call, scene);
    tracer!(call, tracer);
    let geometry = call.memory.read("point_geometry")?;
    let shading = call.memory.read("point_shading")?;
    let tree = call.memory.read::<f32>("density_tree")?;
    let mut accumulator = call.memory.edit::<u32>("accumulator")?;
    let mut feedback = call.memory.edit::<u32>("density_feedback")?;
    let mut counters = call.memory.edit::<u32>("counters")?;
    let (geometry, shading, tree) = (&geometry[..], &shading[..], &tree[..]);
    let accumulator = AtomicWords::new(&mut accumulator);
    let feedback = AtomicWords::new(&mut feedback);
    let counters = AtomicWords::new(&mut counters);
    let (params, needs) = (call.params, call.needs);
    let power = ByPower { scene, light_count: params.light_count, needs };
    let emit = ByDensity { power, tree };
    for_chunks(call.count, |indices| {
        let mut counters = LocalCounters::new(counters);
        let mut tracer = tracer;
        let mut spread = Spread {
            scene,
            point_geometry: geometry,
            point_shading: shading,
            accumulator,
            feedback,
            params,
            needs,
        };
        for index in indices {
            let way = shoot(index, params, needs, scene, &emit, &mut tracer, &mut spread, &mut counters);
            way.total.tally(&mut counters);
        }
    });
    Ok(())
}
