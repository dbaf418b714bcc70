//! Entry points of the filter of the path-traced part.

use crate::entry::index;
use crate::interface::filter::FilterGuide;
use crate::interface::frame::FrameParams;
use crate::interface::material::Material;
use crate::interface::needs::Needs;
use crate::interface::point::{PointGeometry, PointShading};
use crate::pass;
use spirv_std::glam::{UVec3, Vec3};
use spirv_std::spirv;

/// Features of the pixels, and the light that is filtered.
#[spirv(compute(threads(64), entry_point_name = "filter.guide"))]
pub fn guide(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] path_radiance: &[Vec3],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] point_geometry: &[PointGeometry],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] point_shading: &[PointShading],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] materials: &[Material],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] seen_radiance: &mut [Vec3],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] filter_guides: &mut [FilterGuide],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] filter_light: &mut [Vec3],
) {
    let pixel = index(id);
    if pixel < params.pixel_count() {
        let i = pixel as usize;
        let (point, shading) = (&point_geometry[i], &point_shading[i]);
        let (radiance, seen) = (path_radiance[i], seen_radiance[i]);
        let start = pass::filter::start(radiance, seen, point, shading, materials, Needs(needs));
        seen_radiance[i] = start.seen;
        filter_guides[i] = start.guide;
        filter_light[i] = start.light;
    }
}

/// One level; even levels read `filter_light` and write `path_radiance`, odd ones the other way.
#[spirv(compute(threads(64), entry_point_name = "filter.atrous"))]
pub fn atrous(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] filter_guides: &[FilterGuide],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] seen_radiance: &[Vec3],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] filter_light: &mut [Vec3],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] path_radiance: &mut [Vec3],
) {
    let pixel = index(id);
    if pixel < params.pixel_count() {
        let i = pixel as usize;
        if params.part.is_multiple_of(2) {
            let light = pass::filter::level(pixel, params, filter_guides, filter_light);
            path_radiance[i] = pass::filter::finish(light, seen_radiance[i], params);
        } else {
            filter_light[i] = pass::filter::level(pixel, params, filter_guides, path_radiance);
        }
    }
}
