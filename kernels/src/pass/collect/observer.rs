//! The trait of `collect`: observers of a camera path. They cost nothing where there are none.

use crate::interface::point::{PointGeometry, PointShading};
use crate::interface::ray::{Hit, Ray};
use crate::surface::scatter::BsdfSample;
use crate::surface::vertex::Vertex;
use spirv_std::glam::Vec3;

/// Observes what a camera path meets and does.
pub trait PathObserver {
    /// What it keeps of a path. An observer on a GPU holds buffers and does not change: a compiler there may die of buffers that a
    /// loop carries.
    type Kept: Copy + Default;

    /// The path meets a surface, and brings this throughput.
    #[inline(always)]
    fn arrive(&mut self, _ray: &Ray, _hit: &Hit, _here: &Vertex, _throughput: Vec3) {}
    /// What it does there; it may end all the same.
    #[inline(always)]
    fn scatter(&mut self, _departure: &BsdfSample) {}
    /// It leaves the scene with this throughput.
    #[inline(always)]
    fn escape(&mut self, _ray: &Ray, _throughput: Vec3) {}
    /// Its collection point is here.
    fn collect(&mut self, kept: &mut Self::Kept, point: &CollectionPoint);
    /// It has ended without one; its last vertex is here.
    fn end(&mut self, kept: &mut Self::Kept, last: Vec3);
}

/// A collection point, and how far the path went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CollectionPoint {
    /// Where it is.
    pub geometry: PointGeometry,
    /// What its light is multiplied with.
    pub shading: PointShading,
    /// Length of the camera path up to it (m).
    pub length: f32,
}

impl CollectionPoint {
    /// That of a path which has none, from its last vertex.
    #[inline(always)]
    pub fn none(last: Vec3) -> CollectionPoint {
        let geometry = PointGeometry { position: last, ..PointGeometry::default() };
        CollectionPoint { geometry, ..CollectionPoint::default() }
    }
}

/// Keeps the collection point, and nothing else.
pub struct PointObserver;

impl PathObserver for PointObserver {
    type Kept = CollectionPoint;

    #[inline(always)]
    fn collect(&mut self, kept: &mut CollectionPoint, point: &CollectionPoint) {
        *kept = *point;
    }
    #[inline(always)]
    fn end(&mut self, kept: &mut CollectionPoint, last: Vec3) {
        *kept = CollectionPoint::none(last);
    }
}
