//! Tracing: the trait `Tracer`, its software and hardware implementations, and segments of paths through media. Imports
//! `interface`, `math`, `texture` and `surface`.

pub mod bvh;
#[cfg(target_arch = "x86_64")]
pub mod bvh8;
pub mod initial_media;
#[cfg(not(target_arch = "spirv"))]
pub mod on_cpu;
#[cfg(feature = "ray-query")]
pub mod ray_query;
pub mod through_media;

use crate::interface::ray::{Hit, Ray};

/// Finds hits of rays.
pub trait Tracer {
    /// Finds the closest hit.
    fn closest(&mut self, ray: &Ray) -> Hit;
    /// Whether the ray hits anything.
    fn occluded(&mut self, ray: &Ray) -> bool;
}
