//! Entry points of the density map of light paths.

use crate::entry::index;
use crate::interface::density::DensityTexel;
use crate::interface::frame::FrameParams;
use crate::light::density_map::{TEXELS, map_count};
use crate::pass::density;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// New densities from the feedback of the last frame, a texel an invocation.
#[spirv(compute(threads(64), entry_point_name = "density.update"))]
pub fn density_update(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] density: &mut [DensityTexel],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] density_tree: &[f32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] density_feedback: &[u32],
) {
    let texel = index(id);
    if texel < map_count(params.light_count) * TEXELS {
        let before = density[texel as usize];
        density[texel as usize] = density::update(texel, &before, density_tree, density_feedback);
    }
}

/// A level of the pyramids, a node an invocation.
#[spirv(compute(threads(64), entry_point_name = "density.sum"))]
pub fn density_sum(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] density: &[DensityTexel],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] density_tree: &mut [f32],
) {
    let node = index(id);
    if node < density::node_count(params.part, map_count(params.light_count)) {
        let (place, sum) = density::sum(node, params.part, density, density_tree);
        density_tree[place as usize] = sum;
    }
}
