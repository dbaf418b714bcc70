//! The entry points that trace, once for every tracer.

/// Stamps `collect`, `reference`, `shoot.store`, `shoot.yang2021`, `validate` and `step.hit` for the tracer that an expression makes of the scene's holes
/// and of its own bindings; bindings 16 and above are the tracer's.
macro_rules! tracing_entries {
    ([$($bound:tt)*], |$cut_outs:ident| $tracer:expr) => {
        use crate::entry::index;
        use crate::gather::receive::Store;
        use crate::interface::counters::Counter;
        use crate::interface::frame::FrameParams;
        use crate::interface::history::{
            VALIDATION_DEPOSITS, ValidationDeposit, validation_paths,
        };
        use crate::interface::instance::Instance;
        use crate::interface::light::Light;
        use crate::interface::material::Material;
        use crate::interface::needs::Needs;
        use crate::interface::point::{DepositGeometry, DepositLight, PointGeometry, PointShading};
        use crate::interface::scene::{SceneTables, TextureTables};
        use crate::interface::texture::{MaterialTextures, Texture, TextureCoordinates};
        use crate::interface::triangle::{Triangle, TriangleSurface};
        use crate::light::by_density::ByDensity;
        use crate::light::power::ByPower;
        use crate::math::ray::{Hit, Ray};
        use crate::pass;
        use crate::seam::{AtomicWords, Atomics, ScatterSlots};
        use crate::texture::cut_out::CutOuts;
        use crate::trace::Tracer;
        use spirv_std::glam::{UVec3, Vec3};
        use spirv_std::spirv;

        /// Camera paths, a pixel an invocation.
        #[spirv(compute(threads(64), entry_point_name = "collect"))]
        pub fn collect(
            #[spirv(global_invocation_id)] id: UVec3,
            #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
            #[spirv(push_constant)] params: &FrameParams,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] triangles: &[Triangle],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] surfaces: &[TriangleSurface],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] materials: &[Material],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] lights: &[Light],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] textures: &[Texture],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 10)] material_textures: &[MaterialTextures],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 11)] texture_coordinates: &[TextureCoordinates],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 12)] texels_0: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 13)] texels_1: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 14)] texels_2: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 15)] texels_3: &[u32],
            $($bound)*
            #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] pixel_order: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] path_radiance: &mut [Vec3],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 24)] seen_radiance: &mut [Vec3],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] point_geometry: &mut [PointGeometry],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] point_shading: &mut [PointShading],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] counters: &mut [u32],
        ) {
            let index = index(id);
            if index < params.pixel_count() {
                let pixel = pixel_order[index as usize];
                let textures = TextureTables {
                    textures,
                    material_textures,
                    texture_coordinates,
                    texels_0,
                    texels_1,
                    texels_2,
                    texels_3,
                };
                let needs = Needs(needs);
                let scene = SceneTables { triangles, surfaces, materials, lights, textures };
                let $cut_outs = CutOuts::of(scene, needs);
                let mut tracer = $tracer;
                let mut counters = AtomicWords(counters);
                let collected =
                    pass::collect::collect(pixel, params, needs, scene, &mut tracer, &mut counters);
                path_radiance[pixel as usize] = collected.radiance;
                seen_radiance[pixel as usize] = collected.seen;
                point_geometry[pixel as usize] = collected.geometry;
                point_shading[pixel as usize] = collected.shading;
            }
        }

        /// Paths of the reference, a pixel an invocation.
        #[spirv(compute(threads(64), entry_point_name = "reference"))]
        pub fn reference(
            #[spirv(global_invocation_id)] id: UVec3,
            #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
            #[spirv(push_constant)] params: &FrameParams,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] triangles: &[Triangle],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] surfaces: &[TriangleSurface],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] materials: &[Material],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] lights: &[Light],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] textures: &[Texture],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 10)] material_textures: &[MaterialTextures],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 11)] texture_coordinates: &[TextureCoordinates],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 12)] texels_0: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 13)] texels_1: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 14)] texels_2: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 15)] texels_3: &[u32],
            $($bound)*
            #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] pixel_order: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] path_radiance: &mut [Vec3],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] counters: &mut [u32],
        ) {
            let index = index(id);
            if index < params.pixel_count() {
                let pixel = pixel_order[index as usize];
                let textures = TextureTables {
                    textures,
                    material_textures,
                    texture_coordinates,
                    texels_0,
                    texels_1,
                    texels_2,
                    texels_3,
                };
                let needs = Needs(needs);
                let scene = SceneTables { triangles, surfaces, materials, lights, textures };
                let $cut_outs = CutOuts::of(scene, needs);
                let mut tracer = $tracer;
                let mut counters = AtomicWords(counters);
                path_radiance[pixel as usize] =
                    pass::reference::reference(pixel, params, needs, scene, &mut tracer, &mut counters);
            }
        }

        /// Light paths, one an invocation; deposits are stored.
        #[spirv(compute(threads(64), entry_point_name = "shoot.store"))]
        pub fn shoot_store(
            #[spirv(global_invocation_id)] id: UVec3,
            #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
            #[spirv(push_constant)] params: &FrameParams,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] triangles: &[Triangle],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] surfaces: &[TriangleSurface],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] materials: &[Material],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] lights: &[Light],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] textures: &[Texture],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 10)] material_textures: &[MaterialTextures],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 11)] texture_coordinates: &[TextureCoordinates],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 12)] texels_0: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 13)] texels_1: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 14)] texels_2: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 15)] texels_3: &[u32],
            $($bound)*
            #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] deposit_geometry: &mut [DepositGeometry],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] deposit_light: &mut [DepositLight],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] deposit_state: &mut [u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] counters: &mut [u32],
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
                let needs = Needs(needs);
                let scene = SceneTables { triangles, surfaces, materials, lights, textures };
                let emit = ByPower { scene, light_count: params.light_count, needs };
                let $cut_outs = CutOuts::of(scene, needs);
                let mut tracer = $tracer;
                let mut counters = AtomicWords(counters);
                let mut store = Store {
                    geometry: ScatterSlots(deposit_geometry),
                    light: ScatterSlots(deposit_light),
                    state: AtomicWords(deposit_state),
                    capacity: params.deposit_capacity,
                };
                let dropped = pass::shoot::shoot(
                    index,
                    params,
                    needs,
                    scene,
                    &emit,
                    &mut tracer,
                    &mut store,
                    &mut counters,
                );
                if dropped != 0 {
                    counters.add(Counter::DepositsDropped as u32, dropped);
                }
            }
        }

        /// Light paths, one an invocation; deposits are spread over the picture.
        #[spirv(compute(threads(64), entry_point_name = "shoot.yang2021"))]
        pub fn shoot_yang2021(
            #[spirv(global_invocation_id)] id: UVec3,
            #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
            #[spirv(push_constant)] params: &FrameParams,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] triangles: &[Triangle],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] surfaces: &[TriangleSurface],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] materials: &[Material],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] lights: &[Light],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] textures: &[Texture],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 10)] material_textures: &[MaterialTextures],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 11)] texture_coordinates: &[TextureCoordinates],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 12)] texels_0: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 13)] texels_1: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 14)] texels_2: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 15)] texels_3: &[u32],
            $($bound)*
            #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] point_geometry: &[PointGeometry],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] point_shading: &[PointShading],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] density_tree: &[f32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] accumulator: &mut [u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] counters: &mut [u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 24)] density_feedback: &mut [u32],
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
                let needs = Needs(needs);
                let scene = SceneTables { triangles, surfaces, materials, lights, textures };
                let power = ByPower { scene, light_count: params.light_count, needs };
                let emit = ByDensity { power, tree: density_tree };
                let $cut_outs = CutOuts::of(scene, needs);
                let mut tracer = $tracer;
                let mut counters = AtomicWords(counters);
                let mut spread = pass::scatter_photons::Spread {
                    scene,
                    point_geometry,
                    point_shading,
                    accumulator: AtomicWords(accumulator),
                    feedback: AtomicWords(density_feedback),
                    params,
                    needs,
                };
                let way = pass::shoot::shoot(
                    index,
                    params,
                    needs,
                    scene,
                    &emit,
                    &mut tracer,
                    &mut spread,
                    &mut counters,
                );
                way.total.tally(&mut counters);
            }
        }

        /// Validation paths, one an invocation.
        #[spirv(compute(threads(64), entry_point_name = "validate"))]
        pub fn validate(
            #[spirv(global_invocation_id)] id: UVec3,
            #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
            #[spirv(push_constant)] params: &FrameParams,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] triangles: &[Triangle],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] surfaces: &[TriangleSurface],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] materials: &[Material],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] lights: &[Light],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] textures: &[Texture],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 10)] material_textures: &[MaterialTextures],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 11)] texture_coordinates: &[TextureCoordinates],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 12)] texels_0: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 13)] texels_1: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 14)] texels_2: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 15)] texels_3: &[u32],
            $($bound)*
            #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] instances: &[Instance],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] validation_deposits: &mut [ValidationDeposit],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] validation_cells: &mut [u32],
        ) {
            let path = index(id);
            if path < validation_paths(params.light_path_count) {
                let textures = TextureTables {
                    textures,
                    material_textures,
                    texture_coordinates,
                    texels_0,
                    texels_1,
                    texels_2,
                    texels_3,
                };
                let needs = Needs(needs);
                let scene = SceneTables { triangles, surfaces, materials, lights, textures };
                let emit = ByPower { scene, light_count: params.light_count, needs };
                let $cut_outs = CutOuts::of(scene, needs);
                let mut tracer = $tracer;
                pass::validate::validate(
                    path,
                    params,
                    needs,
                    scene,
                    instances,
                    &emit,
                    &mut tracer,
                    validation_deposits,
                    path * VALIDATION_DEPOSITS,
                    AtomicWords(validation_cells),
                );
            }
        }

        /// Closest hits of given rays.
        #[spirv(compute(threads(64), entry_point_name = "step.hit"))]
        pub fn step_hit(
            #[spirv(global_invocation_id)] id: UVec3,
            #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
            #[spirv(push_constant)] params: &FrameParams,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] surfaces: &[TriangleSurface],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] materials: &[Material],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] textures: &[Texture],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 10)] material_textures: &[MaterialTextures],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 11)] texture_coordinates: &[TextureCoordinates],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 12)] texels_0: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 13)] texels_1: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 14)] texels_2: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 15)] texels_3: &[u32],
            $($bound)*
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] rays: &[Ray],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] hits: &mut [Hit],
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
                let $cut_outs = CutOuts { surfaces, materials, textures, needs: Needs(needs) };
                hits[index as usize] = $tracer.closest(&rays[index as usize]);
            }
        }
    };
}

pub(crate) use tracing_entries;
