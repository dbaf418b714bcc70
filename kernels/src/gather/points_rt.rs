//! The paper's gather: boxes around the collection points in an acceleration structure, searched by a ray query of
//! almost no length from each deposit; every candidate is visited and none committed. GPU only.
//!
//! Source: [Moreau and Doggett 2022]. Cost: a structure over all pixels every frame, and a query a deposit.
//! Where it is wrong: nowhere; candidates may lie outside their box, so the disc test decides.

use crate::gather::{Near, Neighbours, Visit};
use spirv_std::glam::Vec3;
use spirv_std::ray_query;
use spirv_std::ray_tracing::{AccelerationStructure, RayFlags, RayQuery};

/// Points by their boxes.
#[derive(Clone, Copy)]
pub struct PointsRt<'a> {
    /// Boxes around the points.
    pub structure: &'a AccelerationStructure,
}

impl Neighbours for PointsRt<'_> {
    #[inline(always)]
    fn for_each_near<V: Visit>(&mut self, near: Near, visit: &mut V) {
        candidates(self.structure, near.position, visit);
    }
}

#[inline(always)]
fn candidates<V: Visit>(structure: &AccelerationStructure, position: Vec3, visit: &mut V) {
    ray_query!(let mut query);
    // SAFETY: the query is initialised before it proceeds.
    unsafe {
        query.initialize(structure, RayFlags::NONE, 0xff, position, 0.0, Vec3::Z, 1.0e-30);
        while query.proceed() {
            visit.visit(query.get_candidate_intersection_primitive_index());
        }
    }
}
