//! The filter of the path-traced part.

use caustics_kernels::interface::filter::FilterGuide;
use caustics_kernels::interface::point::{PointGeometry, PointShading};
use caustics_kernels::pass::filter;
use glam::Vec3;
use rayon::prelude::*;

use super::{Call, map};

/// Features of the pixels, and the light that is filtered.
pub fn guide(call: &Call<'_>) -> anyhow::Result<()> {
    let materials = call.memory.read("materials")?;
    let radiance = call.memory.read::<Vec3>("path_radiance")?;
    let geometry = call.memory.read::<PointGeometry>("point_geometry")?;
    let shading = call.memory.read::<PointShading>("point_shading")?;
    let mut seen = call.memory.edit::<Vec3>("seen_radiance")?;
    let mut guides = call.memory.edit::<FilterGuide>("filter_guides")?;
    let mut light = call.memory.edit::<Vec3>("filter_light")?;
    let (materials, radiance) = (&materials[..], &radiance[..]);
    let (geometry, shading) = (&geometry[..], &shading[..]);
    let rows = seen.par_iter_mut().zip(guides.par_iter_mut()).zip(light.par_iter_mut()).enumerate();
    rows.for_each(|(i, ((seen, guide), light))| {
        let (point, shading) = (&geometry[i], &shading[i]);
        let start = filter::start(radiance[i], *seen, point, shading, materials, call.needs);
        (*seen, *guide, *light) = (start.seen, start.guide, start.light);
    });
    Ok(())
}

/// One level.
pub fn atrous(call: &Call<'_>) -> anyhow::Result<()> {
    let guides = call.memory.read::<FilterGuide>("filter_guides")?;
    let guides = &guides[..];
    if call.params.part.is_multiple_of(2) {
        let light = call.memory.read::<Vec3>("filter_light")?;
        let seen = call.memory.read::<Vec3>("seen_radiance")?;
        let (light, seen) = (&light[..], &seen[..]);
        map(call, "path_radiance", |pixel| {
            let light = filter::level(pixel, call.params, guides, light);
            filter::finish(light, seen[pixel as usize], call.params)
        })
    } else {
        let light = call.memory.read::<Vec3>("path_radiance")?;
        let light = &light[..];
        map(call, "filter_light", |pixel| filter::level(pixel, call.params, guides, light))
    }
}
