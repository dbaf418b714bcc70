//! Hardware tracer: Vulkan ray queries against the scene's acceleration structure. GPU only.
//!
//! Where surfaces have holes or blend, the structure's triangles are not opaque: the tracer confirms each candidate of the query.

use crate::interface::features::Features;
use crate::interface::ray::{Hit, Ray};
use crate::texture::cut_out::{CutOuts, SOME_ARE_NOT_THERE};
use crate::trace::Tracer;
use spirv_std::ray_tracing::{AccelerationStructure, CommittedIntersection, RayFlags, RayQuery};

/// Tracer of the scene's acceleration structure; an instance's custom index is its index in `instances`.
pub struct RayQueryTracer<'a> {
    /// All triangles of the scene, in the world and in its instances.
    pub scene: &'a AccelerationStructure,
    /// First triangles of instances, and the presence of surfaces at hits.
    pub cut_outs: CutOuts<'a>,
    /// Query of all rays of an invocation, one after another: AMD's driver keeps a stack for each query, where all lanes share
    /// memory.
    pub query: &'a mut RayQuery,
}

impl Tracer for RayQueryTracer<'_> {
    #[inline(always)]
    fn closest(&mut self, ray: &Ray) -> Hit {
        closest(self.query, self.scene, self.cut_outs, ray)
    }
    #[inline(always)]
    fn occluded(&mut self, ray: &Ray) -> bool {
        occluded(self.query, self.scene, self.cut_outs, ray)
    }
}

/// Confirms a candidate if the surface is there.
#[inline(always)]
unsafe fn consider(query: &RayQuery, cut_outs: CutOuts<'_>, key: u32) {
    // SAFETY: the caller's query stands at a candidate, and all candidates are triangles.
    unsafe {
        let at = query.get_candidate_intersection_barycentrics();
        let mut triangle = query.get_candidate_intersection_primitive_index();
        let mut instance = 0;
        if cut_outs.features.has(Features::INSTANCES) {
            instance = query.get_candidate_intersection_instance_custom_index();
            triangle += cut_outs.instances[instance as usize].first;
        }
        let candidate = Hit { distance: 0.0, triangle, u: at.x, v: at.y, instance };
        if cut_outs.is_there(&candidate, key) {
            query.confirm_intersection();
        }
    }
}

#[inline(always)]
fn closest(query: &mut RayQuery, scene: &AccelerationStructure, cut_outs: CutOuts<'_>, ray: &Ray) -> Hit {
    // SAFETY: the query is initialised before it proceeds, and read only after it has.
    unsafe {
        if cut_outs.features.has(SOME_ARE_NOT_THERE) {
            query.initialize(scene, RayFlags::NONE, 0xff, ray.origin, 0.0, ray.direction, ray.length);
            while query.proceed() {
                consider(query, cut_outs, ray.key);
            }
        } else {
            query.initialize(scene, RayFlags::OPAQUE, 0xff, ray.origin, 0.0, ray.direction, ray.length);
            while query.proceed() {}
        }
        if query.get_committed_intersection_type() as u32 == CommittedIntersection::Triangle as u32 {
            let mut triangle = query.get_committed_intersection_primitive_index();
            let mut instance = 0;
            if cut_outs.features.has(Features::INSTANCES) {
                instance = query.get_committed_intersection_instance_custom_index();
                triangle += cut_outs.instances[instance as usize].first;
            }
            let barycentrics = query.get_committed_intersection_barycentrics();
            Hit {
                distance: query.get_committed_intersection_t(),
                triangle,
                u: barycentrics.x,
                v: barycentrics.y,
                instance,
            }
        } else {
            Hit::MISS
        }
    }
}

#[inline(always)]
fn occluded(query: &mut RayQuery, scene: &AccelerationStructure, cut_outs: CutOuts<'_>, ray: &Ray) -> bool {
    // SAFETY: as above.
    unsafe {
        if cut_outs.features.has(SOME_ARE_NOT_THERE) {
            let flags = RayFlags::TERMINATE_ON_FIRST_HIT;
            query.initialize(scene, flags, 0xff, ray.origin, 0.0, ray.direction, ray.length);
            while query.proceed() {
                consider(query, cut_outs, ray.key);
            }
        } else {
            let flags = RayFlags::OPAQUE | RayFlags::TERMINATE_ON_FIRST_HIT;
            query.initialize(scene, flags, 0xff, ray.origin, 0.0, ray.direction, ray.length);
            while query.proceed() {}
        }
        query.get_committed_intersection_type() as u32 == CommittedIntersection::Triangle as u32
    }
}
