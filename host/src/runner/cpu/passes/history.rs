//! The passes of the histories.

use caustics_kernels::interface::history::{
    HistoryPoint, HistorySettings, Lent, VALIDATION_DEPOSITS, ValidationDeposit,
};
use caustics_kernels::interface::instance::Instance;
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::point::{PointGeometry, PointShading};
use caustics_kernels::light::power::ByPower;
use caustics_kernels::pass;
use caustics_kernels::seam::AtomicWords;
use glam::Vec3;
use rayon::prelude::*;

use super::{CHUNK, Call, map, scene, textures, tracer};

/// Validation paths.
pub fn validate(call: &Call<'_>) -> anyhow::Result<()> {
    scene!(call, scene);
    tracer!(call, tracer);
    let instances = call.memory.read::<Instance>("instances")?;
    let instances = &instances[..];
    let mut deposits = call.memory.edit::<ValidationDeposit>("validation_deposits")?;
    let mut cells = call.memory.edit::<u32>("validation_cells")?;
    let cells = AtomicWords::new(&mut cells);
    let (params, needs) = (call.params, call.needs);
    let emit = ByPower { scene, light_count: params.light_count, needs };
    let rows = VALIDATION_DEPOSITS as usize;
    let deposits = &mut deposits[..rows * call.count as usize];
    deposits.par_chunks_mut(rows * CHUNK).enumerate().for_each(|(chunk, deposits)| {
        let mut tracer = tracer;
        for (offset, deposits) in deposits.chunks_mut(rows).enumerate() {
            let path = (chunk * CHUNK + offset) as u32;
            pass::validate::validate(
                path,
                params,
                needs,
                scene,
                instances,
                &emit,
                &mut tracer,
                deposits,
                0,
                cells,
            );
        }
    });
    Ok(())
}

/// Borrows what both histories search.
macro_rules! previous {
    ($call:expr, $points:ident, $mean:ident) => {
        let points = $call.memory.read::<HistoryPoint>("history_points")?;
        let mean = $call.memory.read::<Vec3>("history_mean")?;
        let ($points, $mean) = (&points[..], &mean[..]);
    };
}

/// What the paper lends.
pub fn reuse_paper(call: &Call<'_>) -> anyhow::Result<()> {
    previous!(call, history_points, history_mean);
    let geometry = call.memory.read::<PointGeometry>("point_geometry")?;
    let shading = call.memory.read::<PointShading>("point_shading")?;
    let instances = call.memory.read::<Instance>("instances")?;
    let (geometry, shading, instances) = (&geometry[..], &shading[..], &instances[..]);
    let settings = call.memory.read::<HistorySettings>("history_settings")?;
    let settings = &settings[0];
    map::<Lent>(call, "lent", |pixel| {
        pass::reuse::paper(
            pixel,
            &geometry[pixel as usize],
            &shading[pixel as usize],
            instances,
            history_points,
            history_mean,
            settings,
            call.params,
        )
    })
}

/// What is lent as far as it still holds.
pub fn reuse_validated(call: &Call<'_>) -> anyhow::Result<()> {
    previous!(call, history_points, history_mean);
    let geometry = call.memory.read::<PointGeometry>("point_geometry")?;
    let shading = call.memory.read::<PointShading>("point_shading")?;
    let instances = call.memory.read::<Instance>("instances")?;
    let (geometry, shading, instances) = (&geometry[..], &shading[..], &instances[..]);
    let materials = call.memory.read::<Material>("materials")?;
    let cells = call.memory.read::<u32>("validation_cells")?;
    let settings = call.memory.read::<HistorySettings>("history_settings")?;
    let (materials, cells, settings) = (&materials[..], &cells[..], &settings[0]);
    map::<Lent>(call, "lent", |pixel| {
        pass::reuse::validated(
            pixel,
            &geometry[pixel as usize],
            &shading[pixel as usize],
            materials,
            instances,
            history_points,
            history_mean,
            cells,
            settings,
            call.params,
            call.needs,
        )
    })
}

/// Radiance of the caustics, blended with what was lent.
pub fn resolve_history(call: &Call<'_>) -> anyhow::Result<()> {
    let geometry = call.memory.read::<PointGeometry>("point_geometry")?;
    let shading = call.memory.read::<PointShading>("point_shading")?;
    let materials = call.memory.read::<Material>("materials")?;
    let accumulator = call.memory.read::<u32>("accumulator")?;
    let settings = call.memory.read::<HistorySettings>("history_settings")?;
    let lent = call.memory.read::<Lent>("lent")?;
    let (geometry, shading) = (&geometry[..], &shading[..]);
    let (materials, accumulator, lent) = (&materials[..], &accumulator[..], &lent[..]);
    let settings = &settings[0];
    let mut radiance = call.memory.edit::<Vec3>("caustic_radiance")?;
    let mut points = call.memory.edit::<HistoryPoint>("history_points")?;
    let mut mean = call.memory.edit::<Vec3>("history_mean")?;
    let rows =
        radiance.par_chunks_mut(CHUNK).zip(points.par_chunks_mut(CHUNK)).zip(mean.par_chunks_mut(CHUNK));
    rows.enumerate().for_each(|(chunk, ((radiance, points), mean))| {
        for (offset, radiance) in radiance.iter_mut().enumerate() {
            let pixel = chunk * CHUNK + offset;
            let remembered = pass::remember::remember(
                pixel as u32,
                &geometry[pixel],
                &shading[pixel],
                materials,
                accumulator,
                &lent[pixel],
                settings,
                call.params,
                call.needs,
            );
            *radiance = remembered.radiance;
            points[offset] = remembered.point;
            mean[offset] = remembered.mean;
        }
    });
    Ok(())
}
