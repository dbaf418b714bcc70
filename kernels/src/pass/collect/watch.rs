//! The seam of `collect`: who watches a camera path. It costs nothing where nobody does.

use crate::interface::ray::{Hit, Ray};
use crate::surface::scatter::BsdfSample;
use crate::surface::vertex::Vertex;
use spirv_std::glam::Vec3;

/// Sees what a camera path meets and does.
pub trait Watch {
    /// The path meets a surface, and brings this throughput.
    fn arrive(&mut self, ray: &Ray, hit: &Hit, here: &Vertex, throughput: Vec3);
    /// What it does there; it may end all the same.
    fn scatter(&mut self, departure: &BsdfSample);
    /// It leaves the scene with this throughput.
    fn escape(&mut self, ray: &Ray, throughput: Vec3);
}

/// Nobody.
pub struct Unwatched;

impl Watch for Unwatched {
    #[inline(always)]
    fn arrive(&mut self, _ray: &Ray, _hit: &Hit, _here: &Vertex, _throughput: Vec3) {}
    #[inline(always)]
    fn scatter(&mut self, _departure: &BsdfSample) {}
    #[inline(always)]
    fn escape(&mut self, _ray: &Ray, _throughput: Vec3) {}
}
