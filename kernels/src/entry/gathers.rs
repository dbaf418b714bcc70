//! Entry points of every gather variant: one that builds its index, stage by stage, and one that gathers. Indices are
//! built by `base.spv`, whoever searches them.

use crate::entry::index;
use crate::gather::for_each_gather;
#[cfg(not(feature = "ray-query"))]
use crate::gather::tables::Build;
use crate::gather::tables::Tables;
use crate::interface::frame::FrameParams;
use crate::interface::material::Material;
use crate::interface::needs::Needs;
use crate::interface::point::{DepositGeometry, DepositLight, PointGeometry, PointShading};
use crate::pass::gather::deposit_count;
#[cfg(not(feature = "ray-query"))]
use crate::pass::gather::stage_count;
use crate::seam::AtomicWords;
#[cfg(not(feature = "ray-query"))]
use crate::seam::ScatterSlots;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// An entry point that gathers, from sorted deposits or from others; the block of parameters is the variant's structure,
/// if it has one.
macro_rules! gather_entry {
    ($gather:tt, $sorts:expr, [$($structure:tt)*], |$index:ident, $tables:ident, $counters:ident| $body:expr) => {
        /// Gathers, a point or a deposit an invocation.
        #[spirv(compute(threads(64), entry_point_name = $gather))]
        pub fn gather(
            #[spirv(global_invocation_id)] id: UVec3,
            #[spirv(spec_constant(id = 0, default = 524287))] needs: u32,
            #[spirv(push_constant)] params: &FrameParams,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] materials: &[Material],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] pixel_order: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] point_geometry: &[PointGeometry],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] point_shading: &[PointShading],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] deposit_state: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 5)] deposit_geometry: &[DepositGeometry],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] deposit_light: &[DepositLight],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] sorted_geometry: &[DepositGeometry],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] sorted_light: &[DepositLight],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] index_0: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 10)] index_1: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 11)] index_2: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 12)] index_3: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 13)] accumulator: &mut [u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 14)] counters: &mut [u32],
            $($structure)*
        ) {
            let sorts = const { $sorts };
            let $index = index(id);
            let mut $tables = Tables {
                params,
                needs: Needs(needs),
                materials,
                pixel_order,
                point_geometry,
                point_shading,
                deposit_geometry: if sorts { sorted_geometry } else { deposit_geometry },
                deposit_light: if sorts { sorted_light } else { deposit_light },
                deposit_count: deposit_count(deposit_state, params),
                index_0,
                index_1,
                index_2,
                index_3,
                accumulator: AtomicWords(accumulator),
            };
            let mut $counters = AtomicWords(counters);
            $body
        }
    };
}

#[cfg(not(feature = "ray-query"))]
macro_rules! entries {
    (
        [$($file:ident $type:ident $constant:ident $index:tt $gather:tt;)*]
        [$($file_rt:ident $type_rt:ident $constant_rt:ident $index_rt:tt $gather_rt:tt;)*]
    ) => {
        $(
            #[doc = concat!("See `gather::", stringify!($file), "`.")]
            pub mod $file {
                use super::*;
                use crate::gather::Index;
                use crate::gather::$file::$type;
                use crate::pass;

                index_entry!($index, $type);
                gather_entry!($gather, <$type as Index>::VARIANT.sorts, [], |index, tables, counters| {
                    pass::gather::gather::<$type, _>(index, &mut tables, &mut counters);
                });
            }
        )*
        $(
            #[doc = concat!("See `gather::", stringify!($file_rt), "`.")]
            pub mod $file_rt {
                use super::*;
                use crate::gather::Index;
                use crate::gather::$file_rt::$type_rt;

                index_entry!($index_rt, $type_rt);
            }
        )*
    };
}

#[cfg(feature = "ray-query")]
macro_rules! entries {
    (
        [$($file:ident $type:ident $constant:ident $index:tt $gather:tt;)*]
        [$($file_rt:ident $type_rt:ident $constant_rt:ident $index_rt:tt $gather_rt:tt;)*]
    ) => {
        $(
            #[doc = concat!("See `gather::", stringify!($file_rt), "`.")]
            pub mod $file_rt {
                use super::*;
                use crate::gather::Index;
                use crate::gather::$file_rt::{$type_rt, for_each_near};
                use crate::gather::variant::Side;
                use crate::pass::gather::{Give, Take};
                use spirv_std::ray_tracing::AccelerationStructure;

                gather_entry!(
                    $gather_rt,
                    <$type_rt as Index>::VARIANT.sorts,
                    [#[spirv(descriptor_set = 0, binding = 15)] neighbour_structure: &AccelerationStructure],
                    |index, tables, counters| {
                        if const { matches!(<$type_rt as Index>::VARIANT.side, Side::Points) } {
                            if index < tables.deposit_count {
                                let mut give = Give::new(index, &tables);
                                for_each_near(neighbour_structure, &mut tables, give.near(), &mut give);
                                give.close(&mut counters);
                            }
                        } else if index < tables.params.pixel_count() {
                            let mut take = Take::new(index, &tables);
                            if take.is_point() {
                                for_each_near(neighbour_structure, &mut tables, take.near(), &mut take);
                                take.close(&mut tables, &mut counters);
                            }
                        }
                    }
                );
            }
        )*
    };
}

/// An entry point that builds an index.
#[cfg(not(feature = "ray-query"))]
macro_rules! index_entry {
    ($index:tt, $type:ident) => {
        /// Builds, a stage a dispatch.
        #[spirv(compute(threads(64), entry_point_name = $index))]
        pub fn build(
            #[spirv(global_invocation_id)] id: UVec3,
            #[spirv(push_constant)] params: &FrameParams,
            #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] pixel_order: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] point_geometry: &[PointGeometry],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 2)] deposit_state: &[u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 3)] deposit_geometry: &[DepositGeometry],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 4)] deposit_light: &[DepositLight],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 5)]
            sorted_geometry: &mut [DepositGeometry],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 6)] sorted_light: &mut [DepositLight],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 7)] index_0: &mut [u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 8)] index_1: &mut [u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 9)] index_2: &mut [u32],
            #[spirv(storage_buffer, descriptor_set = 0, binding = 10)] index_3: &mut [u32],
        ) {
            let index = index(id);
            let mut build = Build {
                params,
                pixel_order,
                point_geometry,
                deposit_geometry,
                deposit_light,
                deposit_count: deposit_count(deposit_state, params),
                index_0: AtomicWords(index_0),
                index_1: AtomicWords(index_1),
                index_2: AtomicWords(index_2),
                index_3: AtomicWords(index_3),
                sorted_geometry: ScatterSlots(sorted_geometry),
                sorted_light: ScatterSlots(sorted_light),
            };
            if index < stage_count(params, build.deposit_count) {
                <$type as Index>::build(params.part, index, &mut build);
            }
        }
    };
}

/// See `pass::splat`.
#[cfg(not(feature = "ray-query"))]
pub mod kim2019 {
    use super::*;
    use crate::pass;

    gather_entry!("splat.kim2019", false, [], |index, tables, counters| {
        pass::splat::kim2019(index, &mut tables, &mut counters);
    });
}

for_each_gather!(entries);
