//! Tracing: the seam `Tracer`, its software and hardware implementations.
//! Imports `interface`, `math` and `texture`.

pub mod bvh;
#[cfg(feature = "ray-query")]
pub mod ray_query;

use crate::math::ray::{Hit, Ray};

/// Finds what rays hit.
pub trait Tracer {
    /// The closest hit.
    fn closest(&mut self, ray: &Ray) -> Hit;
    /// Whether anything is hit.
    fn occluded(&mut self, ray: &Ray) -> bool;
}
