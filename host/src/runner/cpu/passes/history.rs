//! The passes of the histories.

use caustics_kernels::interface::history::{
    HistoryPoint, HistorySettings, Lent, VALIDATION_DEPOSITS, ValidationDeposit,
};
use caustics_kernels::interface::instance::Instance;
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::point::{PointBox, PointGeometry, PointShading};
use caustics_kernels::light::power::ByPower;
use caustics_kernels::pass;
use caustics_kernels::reuse::tree::{PointTree, level_start, node_box};
use caustics_kernels::seam::{AtomicWords, Scatter, ScatterSlots};
use glam::Vec3;
use rayon::prelude::*;

use super::{CHUNK, Call, map, scene, textures, tracer};

/// Validation paths.
pub fn validate(call: &Call<'_>) -> anyhow::Result<()> {
    scene!(call, scene);
    tracer!(call, tracer);
    let instances = call.memory.read::<Instance>("instances")?;
    let settings = call.memory.read::<HistorySettings>("history_settings")?;
    let (instances, settings) = (&instances[..], &settings[0]);
    let mut deposits = call.memory.edit::<ValidationDeposit>("validation_deposits")?;
    let mut cells = call.memory.edit::<u32>("validation_cells")?;
    let cells = AtomicWords::new(&mut cells);
    let (params, needs) = (call.params, call.needs);
    let emit = ByPower { scene, light_count: params.light_count, needs };
    let rows = VALIDATION_DEPOSITS as usize;
    let deposits = &mut deposits[..rows * call.count as usize];
    deposits.par_chunks_mut(rows * CHUNK).enumerate().for_each(|(chunk, deposits)| {
        let (mut tracer, mut cells) = (tracer, cells);
        for (offset, deposits) in deposits.chunks_mut(rows).enumerate() {
            let path = (chunk * CHUNK + offset) as u32;
            pass::validate::validate(
                path,
                params,
                needs,
                scene,
                instances,
                settings,
                &emit,
                &mut tracer,
                deposits,
                0,
                &mut cells,
            );
        }
    });
    Ok(())
}

/// Boxes of one level of the tree over the previous points.
pub fn reuse_boxes(call: &Call<'_>) -> anyhow::Result<()> {
    let settings = call.memory.read::<HistorySettings>("history_settings")?;
    let history = call.memory.read::<HistoryPoint>("history_points")?;
    let (reach, history) = (settings[0].reach, &history[..]);
    let mut boxes = call.memory.edit::<PointBox>("history_boxes")?;
    let (level, points) = (call.params.part, call.params.pixel_count());
    let (below, here) = boxes.split_at_mut(level_start(points, level) as usize);
    let below = &*below;
    here[..call.count as usize].par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
        for (offset, out) in out.iter_mut().enumerate() {
            *out = node_box((chunk * CHUNK + offset) as u32, level, points, reach, history, below);
        }
    });
    Ok(())
}

/// Borrows what both histories search.
macro_rules! previous {
    ($call:expr, $tree:ident, $points:ident, $mean:ident) => {
        let boxes = $call.memory.read::<PointBox>("history_boxes")?;
        let points = $call.memory.read::<HistoryPoint>("history_points")?;
        let mean = $call.memory.read::<Vec3>("history_mean")?;
        let ($points, $mean) = (&points[..], &mean[..]);
        let $tree = PointTree::new(&boxes, $call.params.pixel_count());
    };
}

/// What the paper lends.
pub fn reuse_paper(call: &Call<'_>) -> anyhow::Result<()> {
    previous!(call, tree, history_points, history_mean);
    let order = call.memory.read::<u32>("pixel_order")?;
    let geometry = call.memory.read::<PointGeometry>("point_geometry")?;
    let shading = call.memory.read::<PointShading>("point_shading")?;
    let instances = call.memory.read::<Instance>("instances")?;
    let (order, geometry, shading, instances) = (&order[..], &geometry[..], &shading[..], &instances[..]);
    map::<Lent>(call, "lent", |rank| {
        let pixel = order[rank as usize] as usize;
        pass::reuse::paper(&geometry[pixel], &shading[pixel], instances, tree, history_points, history_mean)
    })
}

/// What is lent as far as it still holds.
pub fn reuse_validated(call: &Call<'_>) -> anyhow::Result<()> {
    previous!(call, tree, history_points, history_mean);
    let order = call.memory.read::<u32>("pixel_order")?;
    let geometry = call.memory.read::<PointGeometry>("point_geometry")?;
    let shading = call.memory.read::<PointShading>("point_shading")?;
    let instances = call.memory.read::<Instance>("instances")?;
    let (order, geometry, shading, instances) = (&order[..], &geometry[..], &shading[..], &instances[..]);
    let materials = call.memory.read::<Material>("materials")?;
    let cells = call.memory.read::<u32>("validation_cells")?;
    let settings = call.memory.read::<HistorySettings>("history_settings")?;
    let (materials, cells, settings) = (&materials[..], &cells[..], &settings[0]);
    map::<Lent>(call, "lent", |rank| {
        let pixel = order[rank as usize] as usize;
        pass::reuse::validated(
            rank,
            &geometry[pixel],
            &shading[pixel],
            materials,
            instances,
            tree,
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
    let order = call.memory.read::<u32>("pixel_order")?;
    let geometry = call.memory.read::<PointGeometry>("point_geometry")?;
    let shading = call.memory.read::<PointShading>("point_shading")?;
    let materials = call.memory.read::<Material>("materials")?;
    let accumulator = call.memory.read::<u32>("accumulator")?;
    let settings = call.memory.read::<HistorySettings>("history_settings")?;
    let lent = call.memory.read::<Lent>("lent")?;
    let (order, geometry, shading) = (&order[..], &geometry[..], &shading[..]);
    let (materials, accumulator, lent) = (&materials[..], &accumulator[..], &lent[..]);
    let settings = &settings[0];
    let mut radiance = call.memory.edit::<Vec3>("caustic_radiance")?;
    let mut points = call.memory.edit::<HistoryPoint>("history_points")?;
    let mut mean = call.memory.edit::<Vec3>("history_mean")?;
    // `pixel_order` is a permutation: each pixel is written once.
    let radiance = ScatterSlots::new(&mut radiance);
    points.par_chunks_mut(CHUNK).zip(mean.par_chunks_mut(CHUNK)).enumerate().for_each(
        |(chunk, (points, mean))| {
            let mut radiance = radiance;
            for (offset, (point, mean)) in points.iter_mut().zip(mean).enumerate() {
                let rank = chunk * CHUNK + offset;
                let pixel = order[rank];
                let remembered = pass::remember::remember(
                    pixel,
                    &geometry[pixel as usize],
                    &shading[pixel as usize],
                    materials,
                    accumulator,
                    &lent[rank],
                    settings,
                    call.params,
                    call.needs,
                );
                radiance.write(pixel, remembered.radiance);
                *point = remembered.point;
                *mean = remembered.mean;
            }
        },
    );
    Ok(())
}
