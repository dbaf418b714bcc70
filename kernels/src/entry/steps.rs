//! Entry points of single steps, for the twin tests.

use crate::entry::index;
use crate::interface::frame::FrameParams;
use crate::interface::light::Light;
use crate::interface::material::Material;
use crate::interface::needs::Needs;
use crate::interface::scene::{SceneTables, TextureTables};
use crate::interface::step::{EmitStep, SampleStep, ScatterIn, ScatterOut};
use crate::interface::texture::{MaterialTextures, Texture, TextureCoordinates};
use crate::interface::triangle::{Triangle, TriangleSurface};
use crate::light::power::ByPower;
use crate::pass::step;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// Random numbers and warps.
#[spirv(compute(threads(64), entry_point_name = "step.sample"))]
pub fn step_sample(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] samples: &mut [SampleStep],
) {
    let index = index(id);
    if index < params.light_path_batch {
        samples[index as usize] = step::sample(index, params);
    }
}

/// Scattering events.
#[spirv(compute(threads(64), entry_point_name = "step.scatter"))]
pub fn step_scatter(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] triangles: &[Triangle],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] surfaces: &[TriangleSurface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] materials: &[Material],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] lights: &[Light],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] textures: &[Texture],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] material_textures: &[MaterialTextures],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] texture_coordinates: &[TextureCoordinates],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] texels_0: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 10)] texels_1: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 11)] texels_2: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 12)] texels_3: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] scatter_in: &[ScatterIn],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] scatter_out: &mut [ScatterOut],
) {
    let index = index(id);
    if index < params.light_path_batch {
        let textures = TextureTables {
            textures,
            material_textures,
            texture_coordinates,
            texels_0,
            texels_1,
            texels_2,
            texels_3,
        };
        let scene = SceneTables { triangles, surfaces, materials, lights, textures };
        scatter_out[index as usize] = step::scatter(&scatter_in[index as usize], params, Needs(needs), scene);
    }
}

/// Starts of light paths and direct connections.
#[spirv(compute(threads(64), entry_point_name = "step.emit"))]
pub fn step_emit(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] triangles: &[Triangle],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] surfaces: &[TriangleSurface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] materials: &[Material],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] lights: &[Light],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] textures: &[Texture],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] material_textures: &[MaterialTextures],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] texture_coordinates: &[TextureCoordinates],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] texels_0: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 10)] texels_1: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 11)] texels_2: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 12)] texels_3: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] emit_steps: &mut [EmitStep],
) {
    let index = index(id);
    if index < params.light_path_batch {
        let needs = Needs(needs);
        let textures = TextureTables {
            textures,
            material_textures,
            texture_coordinates,
            texels_0,
            texels_1,
            texels_2,
            texels_3,
        };
        let scene = SceneTables { triangles, surfaces, materials, lights, textures };
        let emit = ByPower { scene, light_count: params.light_count, needs };
        emit_steps[index as usize] = step::emit(index, params, needs, scene, &emit);
    }
}
