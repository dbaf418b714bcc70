//! Entry points of the histories.

use crate::entry::index;
use crate::interface::frame::FrameParams;
use crate::interface::history::{HistoryPoint, HistorySettings, Lent};
use crate::interface::instance::Instance;
use crate::interface::material::Material;
use crate::interface::needs::Needs;
use crate::interface::point::{PointGeometry, PointShading};
use crate::pass;
use spirv_std::glam::{UVec3, Vec3};
use spirv_std::spirv;

/// What the paper lends.
#[spirv(compute(threads(64), entry_point_name = "reuse.paper"))]
pub fn reuse_paper(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] point_geometry: &[PointGeometry],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] point_shading: &[PointShading],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] history_points: &[HistoryPoint],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] history_mean: &[Vec3],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] history_settings: &[HistorySettings],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] lent: &mut [Lent],
) {
    let pixel = index(id);
    if pixel < params.pixel_count() {
        let i = pixel as usize;
        lent[i] = pass::reuse::paper(
            pixel,
            &point_geometry[i],
            &point_shading[i],
            instances,
            history_points,
            history_mean,
            &history_settings[0],
            params,
        );
    }
}

/// What is lent as far as it still holds.
#[spirv(compute(threads(64), entry_point_name = "reuse.validated"))]
pub fn reuse_validated(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] point_geometry: &[PointGeometry],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] point_shading: &[PointShading],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] instances: &[Instance],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] history_points: &[HistoryPoint],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] history_mean: &[Vec3],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] history_settings: &[HistorySettings],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] lent: &mut [Lent],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] materials: &[Material],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] validation_cells: &[u32],
) {
    let pixel = index(id);
    if pixel < params.pixel_count() {
        let i = pixel as usize;
        lent[i] = pass::reuse::validated(
            pixel,
            &point_geometry[i],
            &point_shading[i],
            materials,
            instances,
            history_points,
            history_mean,
            validation_cells,
            &history_settings[0],
            params,
            Needs(needs),
        );
    }
}

/// Radiance of the caustics, blended with what was lent.
#[spirv(compute(threads(64), entry_point_name = "resolve.history"))]
pub fn resolve_history(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] point_geometry: &[PointGeometry],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] point_shading: &[PointShading],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] materials: &[Material],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] accumulator: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] history_settings: &[HistorySettings],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] lent: &[Lent],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] caustic_radiance: &mut [Vec3],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] history_points: &mut [HistoryPoint],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] history_mean: &mut [Vec3],
) {
    let pixel = index(id);
    if pixel < params.pixel_count() {
        let i = pixel as usize;
        let remembered = pass::remember::remember(
            pixel,
            &point_geometry[i],
            &point_shading[i],
            materials,
            accumulator,
            &lent[i],
            &history_settings[0],
            params,
            Needs(needs),
        );
        caustic_radiance[i] = remembered.radiance;
        history_points[i] = remembered.point;
        history_mean[i] = remembered.mean;
    }
}
