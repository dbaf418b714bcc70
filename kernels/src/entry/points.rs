//! Entry points over pixels: resolve, display.

use crate::entry::index;
use crate::interface::frame::FrameParams;
use crate::interface::point::{PointGeometry, PointShading};
use crate::pass;
use spirv_std::glam::{UVec3, Vec3};
use spirv_std::spirv;

/// Radiance of the caustics.
#[spirv(compute(threads(64), entry_point_name = "resolve"))]
pub fn resolve(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] point_geometry: &[PointGeometry],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] point_shading: &[PointShading],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] accumulator: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] caustic_radiance: &mut [Vec3],
) {
    let pixel = index(id);
    if pixel < params.pixel_count() {
        let i = pixel as usize;
        let (point, shading) = (&point_geometry[i], &point_shading[i]);
        caustic_radiance[i] = pass::resolve::resolve(pixel, point, shading, accumulator, params);
    }
}

/// Display colours of the whole picture.
#[spirv(compute(threads(64), entry_point_name = "display"))]
pub fn display(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] path_radiance: &[Vec3],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] caustic_radiance: &[Vec3],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] display_color: &mut [Vec3],
) {
    let pixel = index(id);
    if pixel < params.pixel_count() {
        let i = pixel as usize;
        display_color[i] = pass::display::display(path_radiance[i] + caustic_radiance[i], params.exposure);
    }
}
