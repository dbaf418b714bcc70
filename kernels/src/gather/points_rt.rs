//! The gather of [Moreau and Doggett 2022]: boxes around the collection points, in an acceleration structure. Each photon
//! searches it by a ray query of almost no length, which visits every candidate and commits none.
//!
//! Source: [Moreau and Doggett 2022]. There a light path queries as it deposits; here the photons are stored before.
//!
//! Cost: a structure over all pixels every frame, and a query a photon.
//!
//! Limitations: none. Candidates may lie outside their box, so the disc test decides.

use crate::gather::Index;
use crate::gather::contribution::disc_half_extent;
use crate::gather::tables::Build;
use crate::gather::variant::{Over, Side, Stage, Variant, WordCount};
use crate::interface::point::PointGeometry;
use spirv_std::glam::Vec3;

/// Gather with an acceleration structure over the points.
pub struct PointsRt;

impl Index for PointsRt {
    const VARIANT: Variant = Variant {
        name: "points-rt",
        description: "the paper's gather: boxes around points, searched by ray queries from each photon",
        cost: "a structure over all pixels every frame, and a query a photon",
        limitations: "none known",
        side: Side::Points,
        hardware: true,
        frame: &[Stage::Run(0, "bound", Over::Pixels), Stage::Structure(Side::Points)],
        words: [WordCount(6, Over::Pixels), WordCount::NONE, WordCount::NONE, WordCount::NONE],
        ..Variant::NEW
    };

    #[inline(always)]
    fn build(_stage: u32, index: u32, build: &mut Build<'_>) {
        let (low, high) = bound(&build.point(index));
        write_box(&mut build.index_0, index, low, high);
    }
}

/// Box of one point: lower and upper corner (m). Without a point it is a box of no size where the camera path ended. It is never
/// NaN and never far away, since drivers handle both badly.
#[inline(always)]
pub fn bound(point: &PointGeometry) -> (Vec3, Vec3) {
    if !point.exists() {
        return (point.position, point.position);
    }
    let half = disc_half_extent(point);
    (point.position - half, point.position + half)
}

/// Writes a box as an acceleration structure reads it (VkAabbPositionsKHR).
#[inline(always)]
pub fn write_box<W: crate::platform::Words>(words: &mut W, index: u32, low: Vec3, high: Vec3) {
    words.set(6 * index, low.x.to_bits());
    words.set(6 * index + 1, low.y.to_bits());
    words.set(6 * index + 2, low.z.to_bits());
    words.set(6 * index + 3, high.x.to_bits());
    words.set(6 * index + 4, high.y.to_bits());
    words.set(6 * index + 5, high.z.to_bits());
}

#[cfg(feature = "ray-query")]
pub use query::for_each_near;

#[cfg(feature = "ray-query")]
mod query {
    use crate::gather::tables::Tables;
    use crate::gather::{Near, Visit};
    use spirv_std::glam::Vec3;
    use spirv_std::ray_query;
    use spirv_std::ray_tracing::{AccelerationStructure, RayFlags, RayQuery};

    /// Visits the points whose boxes hold the position.
    #[inline(always)]
    pub fn for_each_near<V: Visit>(
        structure: &AccelerationStructure,
        tables: &mut Tables<'_>,
        near: Near,
        visit: &mut V,
    ) {
        ray_query!(let mut query);
        // SAFETY: the query is initialised before it proceeds.
        unsafe {
            query.initialize(structure, RayFlags::NONE, 0xff, near.position, 0.0, Vec3::Z, 1.0e-30);
            while query.proceed() {
                visit.visit(tables, query.get_candidate_intersection_primitive_index());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gather::contribution::takes;
    use crate::interface::point::PhotonGeometry;
    use crate::math::rng::{Rng, Stream};
    use crate::math::warp::uniform_sphere;
    use spirv_std::glam::Vec3;

    #[test]
    fn every_photon_taken_lies_in_the_box() {
        let mut taken = 0;
        for path in 0..400_000 {
            let mut rng = Rng::new(Stream::Camera, 1, path, 0);
            let (a, b, c) = (rng.next4(), rng.next4(), rng.next4());
            let normal = uniform_sphere(a.x, a.y);
            let point = PointGeometry { position: Vec3::new(3.0, -2.0, 1.0), radius: 0.1, normal, depth: 1 };
            // A photon near the disc's rim whose normal leans by up to 26 degrees.
            let tilt = (normal + uniform_sphere(b.x, b.y) * 0.44).normalize();
            let away = (uniform_sphere(c.x, c.y) * 0.1) * (0.9 + 0.1 * c.z);
            let photon =
                PhotonGeometry { position: point.position + away, scatterings: 1, normal: tilt, instance: 0 };
            if takes(&point, &photon, 5) {
                taken += 1;
                let (low, high) = bound(&point);
                assert!(photon.position.cmpge(low).all() && photon.position.cmple(high).all());
            }
        }
        assert!(taken > 10_000, "the test has lost its subject: {taken}");
    }

    #[test]
    fn missing_point_has_a_box_of_no_size() {
        let nowhere = PointGeometry { position: Vec3::ONE, ..Default::default() };
        assert_eq!(bound(&nowhere), (Vec3::ONE, Vec3::ONE));
    }
}
