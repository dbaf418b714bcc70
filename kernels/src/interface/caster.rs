//! Casters: spheres around the surfaces that cast caustics, for emission into their cones.

use bytemuck::{Pod, Zeroable};
use spirv_std::glam::Vec3;

/// A sphere around surfaces that cast caustics.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Caster {
    /// Centre (m).
    pub centre: Vec3,
    /// Radius (m); 0 marks an empty slot.
    pub radius: f32,
    /// Factor of the weight by which aimed emission chooses it: 1, or less for walls that light passes.
    pub weight: f32,
}

/// Maximum number of spheres.
pub const MAX_CASTERS: usize = 16;

/// The casters of a scene at a time.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Casters {
    /// Spheres, of which the first `count` are in use.
    pub spheres: [Caster; MAX_CASTERS],
    /// Number of spheres in use.
    pub count: u32,
}

const _: () = assert!(size_of::<Caster>() == 20);
