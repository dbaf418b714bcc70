//! Entry points that trace by ray queries.

use crate::entry::tracing::tracing_entries;
use crate::trace::ray_query::RayQueryTracer;
use spirv_std::ray_tracing::AccelerationStructure;

tracing_entries!(
    [#[spirv(descriptor_set = 0, binding = 16)] scene_structure: &AccelerationStructure,],
    |cut_outs| RayQueryTracer { scene: scene_structure, cut_outs }
);
