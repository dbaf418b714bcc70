//! Gathers: which photons a collection point takes, and how they are found. Imports `interface`, `math`, `surface`.
//!
//! A variant indexes either the points (each photon searches for points) or the photons (each point searches for photons). All
//! variants add to the same integers (`accumulator`), so their sums agree to the bit. A new variant is a file and a line of
//! `for_each_gather`.

pub mod accumulator;
pub mod contribution;
pub mod hash;
pub mod morton_sort;
pub mod score;
pub mod tables;
pub mod variant;

use spirv_std::glam::Vec3;
use tables::{Build, Tables};
use variant::Variant;

/// Calls a macro with every variant: its file, its type, its constant in `variant`. The first list is searched in software, the
/// second by ray queries.
macro_rules! for_each_gather {
    ($then:ident) => {
        $then! {
            [
                brute Brute BRUTE;
                photons_grid PhotonsGrid PHOTONS_GRID;
                points_bvh PointsBvh POINTS_BVH;
                points_grid PointsGrid POINTS_GRID;
            ]
            [
                photons_rt PhotonsRt PHOTONS_RT;
                points_rt PointsRt POINTS_RT;
            ]
        }
    };
}

/// Declares the modules of the variants.
macro_rules! modules {
    ($([$($file:ident $type:ident $constant:ident;)*])*) => {
        $($(pub mod $file;)*)*
    };
}

for_each_gather!(modules);
#[cfg(not(target_arch = "spirv"))]
pub(crate) use for_each_gather;

pub mod exchange;

/// An index over points or photons.
pub trait Index {
    /// Name, stages and buffers of the variant.
    const VARIANT: Variant;

    /// Runs one invocation of a stage of building.
    fn build(stage: u32, index: u32, build: &mut Build<'_>);
}

/// An index that is searched in software.
pub trait Gather: Index {
    /// Visits every element near a position exactly once, in any order; it may visit others too. Elements are ids of photons, or
    /// indices of points in `pixel_order`.
    fn for_each_near<V: Visit>(tables: &mut Tables<'_>, near: Near, visit: &mut V);
}

/// Box around a position, in which elements are searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// Centre (m).
    pub position: Vec3,
    /// Half extent of the box (m); zero for the elements whose own box holds the position.
    pub half_extent: Vec3,
}

/// Visitor of the elements that a search finds. It changes while a search loops, so it holds values and sums. Buffers stand
/// beside it in `tables`: a GPU's compiler may crash on buffers that a loop carries.
pub trait Visit {
    /// Takes an element by its id.
    fn visit(&mut self, tables: &mut Tables<'_>, id: u32);
}
