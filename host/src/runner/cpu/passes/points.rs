//! The passes over pixels.

use caustics_kernels::interface::point::{PointGeometry, PointShading};
use caustics_kernels::pass;
use caustics_kernels::seam::AtomicWords;
use glam::Vec3;
use rayon::prelude::*;

use super::super::counters::LocalCounters;
use super::{Call, map, scene, textures, tracer};

/// Camera paths.
pub fn collect(call: &Call<'_>) -> anyhow::Result<()> {
    scene!(call, scene);
    tracer!(call, tracer);
    let mut radiance = call.memory.edit::<Vec3>("path_radiance")?;
    let mut seen = call.memory.edit::<Vec3>("seen_radiance")?;
    let mut geometry = call.memory.edit::<PointGeometry>("point_geometry")?;
    let mut shading = call.memory.edit::<PointShading>("point_shading")?;
    let mut counters = call.memory.edit::<u32>("counters")?;
    let counters = AtomicWords::new(&mut counters);
    let width = call.params.width as usize;
    let rows = radiance
        .par_chunks_mut(width)
        .zip(seen.par_chunks_mut(width))
        .zip(geometry.par_chunks_mut(width))
        .zip(shading.par_chunks_mut(width))
        .enumerate();
    rows.for_each(|(row, (((radiance, seen), geometry), shading))| {
        let mut counters = LocalCounters::new(counters);
        let mut tracer = tracer;
        for x in 0..width {
            let pixel = (row * width + x) as u32;
            let collected =
                pass::collect::collect(pixel, call.params, call.needs, scene, &mut tracer, &mut counters);
            radiance[x] = collected.radiance;
            seen[x] = collected.seen;
            geometry[x] = collected.geometry;
            shading[x] = collected.shading;
        }
    });
    Ok(())
}

/// Paths of the reference.
pub fn reference(call: &Call<'_>) -> anyhow::Result<()> {
    scene!(call, scene);
    tracer!(call, tracer);
    let mut radiance = call.memory.edit::<Vec3>("path_radiance")?;
    let mut counters = call.memory.edit::<u32>("counters")?;
    let counters = AtomicWords::new(&mut counters);
    let width = call.params.width as usize;
    radiance.par_chunks_mut(width).enumerate().for_each(|(row, radiance)| {
        let mut counters = LocalCounters::new(counters);
        let mut tracer = tracer;
        for (x, radiance) in radiance.iter_mut().enumerate() {
            let pixel = (row * width + x) as u32;
            *radiance =
                pass::reference::reference(pixel, call.params, call.needs, scene, &mut tracer, &mut counters);
        }
    });
    Ok(())
}

/// Radiance of the caustics.
pub fn resolve(call: &Call<'_>) -> anyhow::Result<()> {
    let geometry = call.memory.read::<PointGeometry>("point_geometry")?;
    let shading = call.memory.read::<PointShading>("point_shading")?;
    let accumulator = call.memory.read::<u32>("accumulator")?;
    let (geometry, shading, accumulator) = (&geometry[..], &shading[..], &accumulator[..]);
    map(call, "caustic_radiance", |i| {
        let (geometry, shading) = (&geometry[i as usize], &shading[i as usize]);
        pass::resolve::resolve(i, geometry, shading, accumulator, call.params)
    })
}

/// Display colours.
pub fn display(call: &Call<'_>) -> anyhow::Result<()> {
    let path = call.memory.read::<Vec3>("path_radiance")?;
    let caustic = call.memory.read::<Vec3>("caustic_radiance")?;
    let (path, caustic) = (&path[..], &caustic[..]);
    map(call, "display_color", |i| {
        pass::display::display(path[i as usize] + caustic[i as usize], call.params.exposure)
    })
}
