//! Hardware tracer: Vulkan ray queries against the scene's acceleration structure. GPU only.

use crate::math::ray::{Hit, Ray};
use crate::trace::Tracer;
use spirv_std::ray_query;
use spirv_std::ray_tracing::{AccelerationStructure, CommittedIntersection, RayFlags, RayQuery};

/// Traces the scene's acceleration structure; triangle ids are primitive ids.
#[derive(Clone, Copy)]
pub struct RayQueryTracer<'a> {
    /// All triangles of the scene, opaque, in one instance.
    pub scene: &'a AccelerationStructure,
}

impl Tracer for RayQueryTracer<'_> {
    #[inline(always)]
    fn closest(&mut self, ray: &Ray) -> Hit {
        closest(self.scene, ray)
    }
    #[inline(always)]
    fn occluded(&mut self, ray: &Ray) -> bool {
        occluded(self.scene, ray)
    }
}

#[inline(always)]
fn closest(scene: &AccelerationStructure, ray: &Ray) -> Hit {
    ray_query!(let mut query);
    // SAFETY: the query is initialised before it proceeds, and read only after it has.
    unsafe {
        query.initialize(scene, RayFlags::OPAQUE, 0xff, ray.origin, 0.0, ray.direction, ray.length);
        while query.proceed() {}
        if query.get_committed_intersection_type() as u32 == CommittedIntersection::Triangle as u32 {
            let barycentrics = query.get_committed_intersection_barycentrics();
            Hit {
                distance: query.get_committed_intersection_t(),
                triangle: query.get_committed_intersection_primitive_index(),
                u: barycentrics.x,
                v: barycentrics.y,
            }
        } else {
            Hit::MISS
        }
    }
}

#[inline(always)]
fn occluded(scene: &AccelerationStructure, ray: &Ray) -> bool {
    ray_query!(let mut query);
    // SAFETY: as above.
    unsafe {
        let flags = RayFlags::OPAQUE | RayFlags::TERMINATE_ON_FIRST_HIT;
        query.initialize(scene, flags, 0xff, ray.origin, 0.0, ray.direction, ray.length);
        while query.proceed() {}
        query.get_committed_intersection_type() as u32 == CommittedIntersection::Triangle as u32
    }
}
