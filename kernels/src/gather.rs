//! Gathers: which deposits a collection point takes, and how they are found. Imports `interface`, `math`, `surface`.
//!
//! A variant indexes either the points (each deposit looks for points: `points_rt`) or the photons (each point looks
//! for deposits: `brute`, `photons_grid`). All sum in the same integers (`accumulator`), so all agree to the bit.

pub mod accumulator;
pub mod brute;
pub mod contribution;
pub mod photons_grid;
#[cfg(feature = "ray-query")]
pub mod points_rt;
pub mod receive;
#[cfg(not(target_arch = "spirv"))]
pub mod variant;

use spirv_std::glam::Vec3;

/// Where to look: a box around a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// Centre [m].
    pub position: Vec3,
    /// Half extent of the box [m]; zero asks for the elements whose own box holds the position.
    pub half_extent: Vec3,
}

/// Finds all elements (points or photons) near a place, and perhaps others.
pub trait Neighbours {
    /// Visits every element near, exactly once, in any order.
    fn for_each_near<V: Visit>(&mut self, near: Near, visit: &mut V);
}

/// What is done with an element that was found.
pub trait Visit {
    /// Takes an element by its id.
    fn visit(&mut self, id: u32);
}
