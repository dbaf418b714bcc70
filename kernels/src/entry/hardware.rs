//! Entry points that trace by ray queries.

use crate::entry::tracing::tracing_entries;
use crate::gather::accumulator::Sum;
use crate::gather::points_rt::PointsRt;
use crate::gather::receive::Give;
use crate::trace::ray_query::RayQueryTracer;
use spirv_std::ray_tracing::AccelerationStructure;

tracing_entries!(
    [#[spirv(descriptor_set = 0, binding = 16)] scene_structure: &AccelerationStructure,],
    |cut_outs| RayQueryTracer { scene: scene_structure, cut_outs }
);

/// Light paths, one an invocation; each deposit goes at once to the points that take it.
#[spirv(compute(threads(64), entry_point_name = "shoot.points_rt"))]
pub fn shoot_points_rt(
    #[spirv(global_invocation_id)] id: UVec3,
    #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
    #[spirv(push_constant)] params: &FrameParams,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] triangles: &[Triangle],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] surfaces: &[TriangleSurface],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] materials: &[Material],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] lights: &[Light],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 11)] textures: &[Texture],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 12)] material_textures: &[MaterialTextures],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 13)] texture_coordinates: &[TextureCoordinates],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 14)] texels_0: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 15)] texels_1: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 16)] texels_2: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 17)] texels_3: &[u32],
    #[spirv(descriptor_set = 0, binding = 4)] scene_structure: &AccelerationStructure,
    #[spirv(descriptor_set = 0, binding = 5)] points_structure: &AccelerationStructure,
    #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] pixel_order: &[u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] point_geometry: &[PointGeometry],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] point_shading: &[PointShading],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] accumulator: &mut [u32],
    #[spirv(storage_buffer, descriptor_set = 0, binding = 10)] counters: &mut [u32],
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
        let mut tracer = RayQueryTracer { scene: scene_structure, cut_outs: CutOuts::of(scene, needs) };
        let mut counters = AtomicWords(counters);
        let mut give = Give {
            pixel_order,
            point_geometry,
            point_shading,
            materials,
            accumulator: AtomicWords(accumulator),
            params,
            needs,
            total: Sum::default(),
        };
        let points = &mut PointsRt { structure: points_structure };
        pass::shoot::shoot(index, params, needs, scene, &emit, &mut tracer, points, &mut give, &mut counters);
        give.total.tally(&mut counters);
    }
}
