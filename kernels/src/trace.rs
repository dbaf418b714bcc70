//! Tracing: the trait `Tracer`, its software and hardware implementations, and what rays meet in media. Imports `interface`,
//! `math`, `texture` and `surface`.

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

/// Finds what rays hit.
pub trait Tracer {
    /// The closest hit.
    fn closest(&mut self, ray: &Ray) -> Hit;
    /// Whether anything is hit.
    fn occluded(&mut self, ray: &Ray) -> bool;
}
