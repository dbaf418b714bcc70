//! Observers of a camera path. An observer that does nothing costs nothing.

use crate::interface::point::{PointGeometry, PointShading};
use crate::interface::radiance_cache::{CacheCell, CacheKey};
use crate::interface::ray::{Hit, Ray};
use crate::surface::scatter::BsdfSample;
use crate::surface::vertex::Vertex;
use spirv_std::glam::Vec3;

/// Observes the vertices of a camera path.
pub trait PathObserver {
    /// Value that is kept of a path. On a GPU an observer holds buffers and does not change, see `path::scratch`.
    type Kept: Copy + Default;

    /// The path arrives at a surface with this throughput.
    #[inline(always)]
    fn arrive(&mut self, _ray: &Ray, _hit: &Hit, _here: &Vertex, _throughput: Vec3) {}
    /// The path scatters; it may end all the same.
    #[inline(always)]
    fn scatter(&mut self, _departure: &BsdfSample) {}
    /// The path leaves the scene with this throughput.
    #[inline(always)]
    fn escape(&mut self, _ray: &Ray, _throughput: Vec3) {}
    /// Cell of the radiance cache; one without samples where there is no cache.
    #[inline(always)]
    fn cached(&self, _key: &CacheKey) -> CacheCell {
        CacheCell::default()
    }
    /// The prefix ends at its collection point.
    fn collect(&mut self, kept: &mut Self::Kept, point: &CollectionPoint);
    /// The path ends without a collection point; `last` is its last vertex (m).
    fn end(&mut self, kept: &mut Self::Kept, last: Vec3);
}

/// A collection point, and the length of the path to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CollectionPoint {
    /// Position and disc.
    pub geometry: PointGeometry,
    /// Factor on its light: BSDF and throughput.
    pub shading: PointShading,
    /// Length of the camera path up to it (m).
    pub length: f32,
}

impl CollectionPoint {
    /// No collection point, at the last vertex of a path (m).
    #[inline(always)]
    pub fn none(last: Vec3) -> CollectionPoint {
        let geometry = PointGeometry { position: last, ..PointGeometry::default() };
        CollectionPoint { geometry, ..CollectionPoint::default() }
    }
}
